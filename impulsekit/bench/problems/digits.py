"""Impacts in 50 digits: Kane's equations, with known impulses and bilateral constraints."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...checking.demands import constraint_rows, known_impulses
from ...checking.system import reference_robot
from ...scene import Scene

__all__ = ["DIGITS", "velocity_after"]

DIGITS = 50


def velocity_after(scene: Scene, q: np.ndarray, v: np.ndarray, digits: int = DIGITS) -> Any:
    """(nv,) v⁺ in numbers of mpmath, by Chang & Huston's equations (18) to (33).

    Contacts are solved under Newton's law with slip at the end, all at once.

    Raises:
        InputError: the reference cannot read the robot.
        ArithmeticError: no answer to the contact law was found and proved.
    """
    reference = reference_robot(scene.robot, digits)
    if scene.contacts:
        from .coulomb import velocity_after_contacts

        return velocity_after_contacts(reference, scene, q, v)
    known = known_impulses(reference, scene.impulses)
    system = reference.system
    rows = constraint_rows(reference, system.kinematics(q), v, scene.constraints)
    return system.impact(q, v, known.loads, known.in_joints, rows).y_after
