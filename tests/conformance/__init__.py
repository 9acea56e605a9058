"""What the library promises, against truths of its own making, through public names alone."""
