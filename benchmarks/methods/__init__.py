"""Ways to solve them: our own, those of other programs, and the classical ones."""
