"""A motion as a map of its start: derivatives of it, and motions that come round again."""
