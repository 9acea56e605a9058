"""A robot's bodies: coordinates, places, mass matrix, accelerations, also where points press."""
