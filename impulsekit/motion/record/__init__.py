"""The record of a motion: path, impacts, forces, tables, files; ``Trajectory``."""
