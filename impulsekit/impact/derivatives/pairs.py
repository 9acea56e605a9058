"""Rows of relative velocity between two bodies, and their derivatives.

A pair has up to six rows, u = Rᵀ (v_a(c_a) − v_b(c_b)) and the same of ω. The axes R
turn with the world, a or b; the point c_b is one of b or the one that coincides with c_a.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ...scene import AppliedImpulse, Contact, FrameAnchor, JointCoupling, PointAnchor
from ...scene.constraints import DIRECTIONS
from .motion import Motion, Twists, cross

if TYPE_CHECKING:
    from ...robot import Robot
    from ...scene.constraints import Constraint

__all__ = ["FixedRows", "PairRows", "anchor_rows", "blow_rows", "contact_rows", "joint_rows"]


@dataclass(frozen=True, eq=False)
class FixedRows:
    """Rows (k, nv) that do not depend on the configuration: locks, couplings, stops."""

    matrix: np.ndarray

    def placed(self, motion: Motion) -> FixedRows:
        """Itself: it stands everywhere alike."""
        return self

    def change_of_velocity(self, twists: Twists) -> np.ndarray:
        """(k, nv) ∂(G v)/∂q."""
        return np.zeros_like(self.matrix)

    def change_of_pull(self, impulse: np.ndarray) -> np.ndarray | None:
        """(nv, nv) ∂(Gᵀp)/∂q beyond that of wrenches fixed in the bodies; None for zero."""
        return None

    def add_wrenches(self, forces: pin.StdVec_Force, impulse: np.ndarray) -> None:
        """Nothing acts on a body from outside."""

    def turned(self, impulse: np.ndarray) -> np.ndarray | None:
        """(3, nv) how an impulse (3,) in the world turns with the axes; None for not."""
        return None


@dataclass(frozen=True, eq=False)
class PairRows:
    """Rows between two bodies of a model.

    Attributes:
        first, other: the joints that carry a and b; 0 for the world.
        at: (3,) c_a in the joint of a (or in the world).
        other_at: (3,) c_b in the joint of b; None for the point that coincides with c_a.
        axes_joint: the joint that R turns with; 0 for the world.
        axes: (3, 3) R in that joint's frame.
        select: which of the six rows there are.
    """

    first: int
    other: int
    at: np.ndarray
    other_at: np.ndarray | None
    axes_joint: int
    axes: np.ndarray
    select: tuple[int, ...]

    @cached_property
    def axes_are_world(self) -> bool:
        """Whether R is the identity, so that nothing has to be turned where it stands still."""
        return bool(np.array_equal(self.axes, np.eye(3)))

    def placed(self, motion: Motion) -> PlacedPair:
        """The rows at a configuration."""
        return PlacedPair(self, motion)


class PlacedPair:
    """A pair at a configuration.

    Attributes:
        matrix: (k, nv) G, the rows.
    """

    def __init__(self, rows: PairRows, motion: Motion) -> None:
        self._rows, self._motion = rows, motion
        places = motion.placements
        a, b = rows.first, rows.other
        here = places[a].act(rows.at)
        there = here if rows.other_at is None else places[b].act(rows.other_at)
        self._axes = places[rows.axes_joint].rotation @ rows.axes
        # By side: joint, sign, point, ∂c/∂q as a point of that body, ∂θ/∂q.
        self._sides = [
            (joint, sign, point, motion.moving(joint, point), motion.turning(joint))
            for joint, sign, point in ((a, 1.0, here), (b, -1.0, there))
            if joint > 0
        ]
        self._zero = motion.zero
        # A point of the world, or of a that is the world, does not move.
        self._point_moves = self._sides[0][3] if a > 0 else self._zero
        self._turn = motion.turning(rows.axes_joint) if rows.axes_joint > 0 else None
        if len(self._sides) == 1 and a > 0:
            linear, angular = self._sides[0][3:]
        else:
            linear, angular = self._zero, self._zero
            for _, sign, _, moving, turning in self._sides:
                linear = linear + sign * moving
                angular = angular + sign * turning
        self.matrix = self._in_axes(linear, angular)

    def _in_axes(self, linear: np.ndarray, angular: np.ndarray) -> np.ndarray:
        select = self._rows.select
        if self._rows.axes_joint == 0 and self._rows.axes_are_world:
            if len(select) == 6:
                return np.concatenate((linear, angular))
        elif select == (0, 1, 2):
            return self._axes.T @ linear
        both = np.concatenate((self._axes.T @ linear, self._axes.T @ angular))
        return both if len(select) == 6 else both[list(select)]

    def _in_world(self, impulse: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if len(impulse) == 6:
            wrench = impulse
        else:
            wrench = np.zeros(6)
            wrench[list(self._rows.select)] = impulse
        if self._rows.axes_joint == 0 and self._rows.axes_are_world:
            return wrench[:3], wrench[3:]
        return self._axes @ wrench[:3], self._axes @ wrench[3:]

    def change_of_velocity(self, twists: Twists) -> np.ndarray:
        """(k, nv) ∂(G v)/∂q."""
        u, w = np.zeros(3), np.zeros(3)
        du, dw = self._zero, self._zero
        for joint, sign, point, moving, _ in self._sides:
            twist, change = twists.of(joint)
            # The point moves with its body, or with a where it is the one that coincides.
            shift = self._point_moves if self._rows.other_at is None else moving
            u = u + sign * (twist[:3] + cross(twist[3:], point))
            w = w + sign * twist[3:]
            du = du + sign * (change[:3] + cross(change[3:], point) + cross(twist[3:], shift))
            dw = dw + sign * change[3:]
        if self._turn is not None:
            du = du - cross(self._turn, u)
            dw = dw - cross(self._turn, w)
        return self._in_axes(du, dw)

    def change_of_pull(self, impulse: np.ndarray) -> np.ndarray | None:
        """(nv, nv) ∂(Gᵀp)/∂q beyond that of wrenches fixed in the bodies."""
        force, couple = self._in_world(impulse)
        total: np.ndarray | None = None
        for joint, sign, _, moving, turning in self._sides:
            if joint == self._rows.axes_joint:
                relative = None
            else:
                relative = -turning if self._turn is None else self._turn - turning
            part = None
            if relative is not None:
                part = moving.T @ cross(relative, force)
                if couple.any():
                    part = part + turning.T @ cross(relative, couple)
            if sign < 0.0 and self._rows.other_at is None:
                arm = turning.T @ cross(self._point_moves - moving, force)
                part = arm if part is None else part + arm
            if part is not None:
                total = sign * part if total is None else total + sign * part
        return total

    def add_wrenches(self, forces: pin.StdVec_Force, impulse: np.ndarray) -> None:
        """Add the impulse on both bodies to spatial forces, each in its joint's frame."""
        force, couple = self._in_world(impulse)
        for joint, sign, point, _, _ in self._sides:
            about_origin = couple + cross(point, force)
            spatial = pin.Force(sign * force, sign * about_origin)
            forces[joint] = forces[joint] + self._motion.placements[joint].actInv(spatial)

    def turned(self, impulse: np.ndarray) -> np.ndarray | None:
        """(3, nv) how an impulse (3,) in the world turns with the axes."""
        return None if self._turn is None else cross(self._turn, impulse)


def blow_rows(robot: Robot, entry: AppliedImpulse) -> PairRows:
    """The six rows at a struck point, in the axes of the impulse."""
    joint, placement = _frame(robot, entry.frame)
    local = entry.axes == "local"
    return PairRows(
        joint,
        0,
        placement.act(np.array(entry.at)),
        None,
        joint if local else 0,
        placement.rotation if local else np.eye(3),
        tuple(range(6)),
    )


def anchor_rows(robot: Robot, entry: PointAnchor | FrameAnchor) -> PairRows:
    """The rows of an anchor."""
    joint, placement = _frame(robot, entry.frame)
    other, other_placement = _frame(robot, entry.other)
    directions = entry.directions if isinstance(entry, FrameAnchor) else DIRECTIONS[:3]
    local = isinstance(entry, FrameAnchor) and entry.axes == "local"
    coincides = entry.other_at is None or other == 0
    return PairRows(
        joint,
        other,
        placement.act(np.array(entry.at)),
        None if coincides else other_placement.act(np.array(entry.other_at)),
        joint if local else 0,
        placement.rotation if local else np.eye(3),
        tuple(DIRECTIONS.index(direction) for direction in directions),
    )


def contact_rows(robot: Robot, entry: Contact, axes: np.ndarray, placement: pin.SE3) -> PairRows:
    """The rows t₁, t₂, n of a contact, its axes (3, 3) in the world as they were found.

    ``placement`` is that of the joint which carries the plane.
    """
    joint, frame = _frame(robot, entry.frame)
    other, _ = _frame(robot, entry.against)
    own = placement.rotation.T @ axes if other > 0 else axes
    return PairRows(joint, other, frame.act(np.array(entry.at)), None, other, own, (0, 1, 2))


def joint_rows(robot: Robot, entry: Constraint) -> FixedRows:
    """The rows of a lock or a coupling."""
    model = robot.model
    if isinstance(entry, JointCoupling):
        row = np.zeros((1, model.nv))
        names, ratios = (entry.joint, *entry.other), (1.0, *(-r for r in entry.ratio))
        for name, ratio in zip(names, ratios, strict=True):
            row[0, model.joints[robot.joint_id(name)].idx_v] = ratio
        return FixedRows(row)
    joint = model.joints[robot.joint_id(entry.joint_names[0])]
    return FixedRows(np.eye(model.nv)[joint.idx_v : joint.idx_v + joint.nv])


def _frame(robot: Robot, name: str) -> tuple[int, pin.SE3]:
    """The joint that carries a frame and the frame's placement there."""
    frame = robot.model.frames[robot.frame_id(name)]
    return frame.parentJoint, pin.SE3(frame.placement)
