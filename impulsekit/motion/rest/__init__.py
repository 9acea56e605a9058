"""What rests: points and joints that stick, slide, roll and spin, and the forces they take."""
