"""What unit blows do to a scene's robot at one configuration.

Δv = H Jᵀp, with the mobility H = M⁻¹ − M⁻¹Aᵀ(A M⁻¹Aᵀ)⁺A M⁻¹ under bilateral rows A.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import InputError, RangeError, a_thing
from ..impact import ImpactSolver
from ..impact.elimination import Elimination
from ..impact.mechanics import Mechanics
from ..impact.singular import refuse_massless
from ..robot import Robot, state
from ..scene import AppliedImpulse, Scene
from ..scene.at_time import at_rest
from ..scene.numbers import vector

__all__ = ["Response", "unit_vector"]

# A vector shorter than this is a zero that was rounded, and tells no direction.
NO_DIRECTION = 1e-9


class Response:
    """A robot as blows find it: its mobility, and what reaches its joints.

    Of a scene only the robot and its constraints count, at rest.
    """

    def __init__(self, what: Scene | Robot, q: Any) -> None:
        if isinstance(what, Robot):
            what = Scene(what)
        if not isinstance(what, Scene):
            raise InputError(f"expected a Scene or a Robot, got {a_thing(what)}")
        held = [at_rest(entry) for entry in what.held]
        self.robot = what.robot
        self.scene = Scene(what.robot, constraints=held, gravity=what.gravity)
        self.q = state.checked_configuration(self.robot.model, q)
        self.mechanics = Mechanics(self.scene, self.q)

    @cached_property
    def mobility(self) -> np.ndarray:
        """(nv, nv) H [1/kg, 1/(kg m), 1/(kg m²)]."""
        unit, mechanics = np.eye(self.robot.nv), self.mechanics
        if not self.scene.constraints:
            refuse_massless(self.robot, self.robot.joint_names)
            return self._loose
        rows = mechanics.constraint_matrix
        half = mechanics.factor.half(rows, unit)
        triples = mechanics.constraint_rows.triples
        held = Elimination(half[:, : len(rows)], (), triples)
        free = held.off_the_span(half[:, len(rows) :])
        return free.T @ free

    def point_mobility(self, jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(3, 3) G = J H Jᵀ, and (3, 3) the same of the robot that nothing holds.

        G is told from rounding by the second, which is of the size |J|²/m of what cancels.
        """
        held = jacobian @ self.mobility @ jacobian.T
        return held, jacobian @ self._loose @ jacobian.T

    @cached_property
    def _loose(self) -> np.ndarray:
        """(nv, nv) of the size of H, where no rows take anything away."""
        root = self.mechanics.factor.half(np.eye(self.robot.nv))
        return root.T @ root

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
    if length < NO_DIRECTION:
        raise RangeError.of(f"length of {what}", length, "above zero")
    return direction / length
