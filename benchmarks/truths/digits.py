"""Impacts in 50 digits: Kane's equations, with known impulses and bilateral constraints."""

from __future__ import annotations

from typing import Any

import numpy as np

from impulsekit.checking.demands import constraint_rows, known_impulses
from impulsekit.checking.system import reference_robot
from impulsekit.impact import solve
from impulsekit.reference import Arithmetic
from impulsekit.scene import Law, Scene

from .found import Found
from .impacts import Impacts

DIGITS = 50


def velocity_after(scene: Scene, q: np.ndarray, v: np.ndarray, digits: int = DIGITS) -> Any:
    """(nv,) v⁺ in numbers of mpmath, by Chang & Huston's equations (18) to (33).

    Contacts are solved under Newton's law with slip at the end, all at once, near the answer
    in doubles; what is found obeys the law to the last digit, whatever it started from.

    Raises:
        InputError: the reference cannot read the robot.
        ArithmeticError: no answer to the contact law was found and proved.
    """
    if scene.contacts:
        return _after_contacts(scene, q, v, digits)
    # The last of the digits that are kept is mpmath's.
    reference = reference_robot(scene.robot, Arithmetic.mpmath(digits))
    known = known_impulses(reference, scene.impulses)
    system = reference.system
    rows = constraint_rows(reference, system.kinematics(q), v, scene.constraints)
    return system.impact(q, v, known.loads, known.in_joints, rows).y_after


def _after_contacts(scene: Scene, q: np.ndarray, v: np.ndarray, digits: int) -> Any:
    if scene.law != Law():
        raise ArithmeticError("contacts in long numbers: Newton's law alone, slip at the end")
    impact = solve(scene, q, v)
    impulses = tuple(np.array(contact.impulse) for contact in impact.contacts)
    impacts = Impacts(scene)
    exact = impacts.at(q, v).exact(Found(impact.dv, "", True, 0.0, contacts=impulses))
    if exact is None or exact.violation > 0.0:
        raise ArithmeticError("the law does not hold in long numbers")
    numbers = Arithmetic.mpmath(digits)
    return numbers.array(v) + [numbers.number(str(jump)) for jump in exact.dv]
