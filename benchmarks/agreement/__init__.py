"""Batches agree with ``solve`` row by row; where they do not, 50 digits decide."""
