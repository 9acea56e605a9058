"""What unit blows do to a scene's robot at one configuration.

Δv = H Jᵀp, with the mobility H = M⁻¹ − M⁻¹Aᵀ(A M⁻¹Aᵀ)⁺A M⁻¹ under bilateral rows A.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError, a_thing
from ..impact import ImpactSolver
from ..impact.algorithms import refuse_massless
from ..impact.bilateral import RANK_TOLERANCE
from ..impact.factor import FilledFactor
from ..impact.mechanics import Mechanics
from ..robot import Robot, state
from ..scene import AppliedImpulse, Scene
from ..scene.numbers import vector

__all__ = ["Response", "unit_vector"]


class Response:
    """A robot as blows find it: its mobility, and what reaches its joints.

    Of a scene only the robot and its constraints count, at rest.
    """

    def __init__(self, what: Scene | Robot, q: Any) -> None:
        if isinstance(what, Robot):
            what = Scene(what)
        if not isinstance(what, Scene):
            raise InputError(f"a Scene or a Robot is wanted, not {a_thing(what)}")
        held = [replace(entry, velocity=0.0) for entry in what.constraints]
        self.robot = what.robot
        self.scene = Scene(what.robot, constraints=held, gravity=what.gravity)
        self.q = state.checked_configuration(self.robot.model, q)
        self.mechanics = Mechanics(self.scene, self.q)

    @cached_property
    def mobility(self) -> np.ndarray:
        """(nv, nv) H [1/kg, 1/(kg m), 1/(kg m²)]."""
        rows = self.mechanics.constraint_matrix if self.scene.constraints else None
        motions = self.robot.massless_motions
        if rows is None:
            refuse_massless(self.robot, self.robot.joint_names)
            rows = np.empty((0, self.robot.nv))
        elif not motions:
            # M needs no rows to be whole, and they would cost its digits.
            return self._held(FilledFactor(self._model, self._masses, rows[:0]), rows)
        return self._held(
            FilledFactor(self._model, self._masses, rows, singular=bool(motions)), rows
        )

    @property
    def _model(self) -> pin.Model:
        return self.robot.model

    @property
    def _masses(self) -> np.ndarray:
        return self.mechanics.mass_matrix

    def _held(self, factor: FilledFactor, rows: np.ndarray) -> np.ndarray:
        """(nv, nv) H from a factor of M, or of M filled up by the rows (m, nv), which hold still.

        Where A Δv = 0 both have the same H.
        """
        root = factor.half(np.eye(self.robot.nv)).T
        if not len(rows):
            return root @ root.T
        half = factor.half(rows)
        sizes = np.sqrt((half**2).sum(axis=0))
        half = half[:, sizes > 1e-11 * sizes.max(initial=0.0)]
        left, values, _ = np.linalg.svd(half / np.sqrt((half**2).sum(axis=0)), full_matrices=False)
        basis = left[:, values > RANK_TOLERANCE]
        free = root - (root @ basis) @ basis.T
        return free @ free.T

    def point_jacobian(self, frame: str, at: Any) -> np.ndarray:
        """(3, nv) of a point of a frame, world axes."""
        self.robot.frame_id(frame)
        return self.mechanics.point_jacobian(frame, np.array(vector(at, "at")))[:3]

    def reaction_map(self, joint: str, frame: str, at: Any) -> np.ndarray:
        """(6, 6) what a joint carries of unit wrenches at a point, both in world axes."""
        place = vector(at, "at")
        still = self.robot.velocity()
        columns = []
        for unit in np.eye(6):
            blow = AppliedImpulse(frame, tuple(unit[:3]), tuple(unit[3:]), place)
            scene = replace(self.scene, impulses=[blow])
            reactions = ImpactSolver(scene).solve(self.q, still).reactions
            if joint not in reactions:
                self.robot.joint_id(joint)
            columns.append(reactions[joint])
        return np.array(columns).T


def unit_vector(given: Any, what: str) -> np.ndarray:
    """(3,) a direction at unit length.

    Raises:
        RangeError: it has no length.
        ShapeError, NotFiniteError: no three finite numbers.
    """
    direction = np.array(vector(given, what))
    length = float(np.linalg.norm(direction))
    if length < 1e-9:
        raise RangeError.of(f"length of {what}", length, "above zero")
    return direction / length
