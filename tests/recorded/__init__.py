"""Motions and laws beside public recordings: ``python -m tests.recorded FOLDER``."""
