"""What a motion leaves: its path, its impacts and forces, tables, files; ``Trajectory``."""
