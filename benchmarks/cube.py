"""The cube of public recordings of tosses (ContactNets), its eight corners over a table."""

from __future__ import annotations

from impulsekit.scene import Contact, Scene

from .urdf import one_body

__all__ = ["FRICTION", "WIDTH", "cube_scene"]

# As published: side [m], restitution and friction (tilt test).
WIDTH, RESTITUTION, FRICTION = 0.1048, 0.125, 0.18
MASS, INERTIA = 0.37, 0.00081


def cube_scene() -> Scene:
    """The cube of the tosses with its eight corners over a table."""
    robot = one_body("cube", MASS, INERTIA)
    half = 0.5 * WIDTH
    signs = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    contacts = [
        Contact("cube", at=[half * a, half * b, half * c], restitution=RESTITUTION,
                friction=FRICTION, name=f"corner_{i}")
        for i, (a, b, c) in enumerate(signs)
    ]  # fmt: skip
    return Scene(robot, contacts=contacts, gravity=[0, 0, -9.81])
