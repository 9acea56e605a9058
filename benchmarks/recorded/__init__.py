"""Motions and laws beside public recordings: ``python -m benchmarks.recorded FOLDER``."""
