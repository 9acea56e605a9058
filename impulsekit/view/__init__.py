"""What a person looks at. Nothing heavy is loaded from here; name the file that is wanted."""
