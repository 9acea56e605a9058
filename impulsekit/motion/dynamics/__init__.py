"""Accelerations of all that a scene holds: free, constrained, driven, and at rest."""
