"""Shapes of bodies, their nearest points, and the motion of these points, in closed form."""
