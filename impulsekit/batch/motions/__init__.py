"""Many motions of one scene: over processes, into arrays."""
