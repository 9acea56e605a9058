"""Joints with dry friction: which of them stand still, and which way the others move.

One that moves has −τ_c sign(v). One that stands still has a row of its own in the law of what
rests, |τ| ≤ τ_c (``laws.resting``), which lets it go where that does not hold it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...scene import JointFriction, Scene

__all__ = ["DryJoints", "Share"]

# A joint or a point breaks away if it moves with more than this share of the accelerations without
# friction and contact forces, although static friction acts: ten times what the law of rest leaves.
TORN = 1e-8
# Velocities below this share of the largest of all joints are zero: rounding of an impact.
JOINT_STILL = 1e-12
# Where nothing accelerates, anything above this is a motion [rad/s², m/s²].
LEAST_MOVING = 1e-300


class Share(NamedTuple):
    """What an entry of the scene has of a joint's friction: its index, and the part it bears."""

    joint: int
    part: float


class DryJoints:
    """The joints of a scene with dry friction.

    Attributes:
        rows: (k,) of the joints in v. bounds: (k,) τ_c [N m, N].
        ways: (k,) −1 or 1: it moves that way; 0: it stands still, or begins to move.
        torques: (k,) of the last evaluation [N m, N].
        rates: (k,) accelerations of those that stand still [rad/s², m/s²], 0 for others.
        size: the largest acceleration without friction and contact forces then.
        shares: by entry of the scene that is a ``JointFriction``, its share; None without effect.
    """

    def __init__(self, scene: Scene) -> None:
        robot, own = scene.robot, list[tuple[int, int, float]]()
        for i, force in enumerate(scene.forces):
            if isinstance(force, JointFriction) and force.torque > 0.0:
                row = robot.model.joints[robot.joint_id(force.joint)].idx_v
                own.append((i, row, force.torque))
        self.rows = np.unique([row for _, row, _ in own]).astype(int)
        at = {row: k for k, row in enumerate(self.rows.tolist())}
        self.bounds = np.zeros(len(at))
        for _, row, torque in own:
            self.bounds[at[row]] += torque
        self.shares = {i: Share(at[row], torque / self.bounds[at[row]]) for i, row, torque in own}
        self.ways = np.zeros(len(at))
        self.torques, self.rates = np.zeros(len(at)), np.zeros(len(at))
        self.size, self._last = 0.0, np.zeros(len(at))

    @property
    def still(self) -> np.ndarray:
        """Indices of those that stand still."""
        return np.flatnonzero(self.ways == 0.0)

    def begin(self, v: np.ndarray) -> None:
        """Let joints move as the velocity (nv,) says, at the start or after a jump of it."""
        least = JOINT_STILL * float(np.abs(v).max(initial=0.0))
        own = v[self.rows]
        self.ways = np.where(np.abs(own) > least, np.sign(own), 0.0)

    def heed(self, v: np.ndarray) -> None:
        """Let joints stand still that a velocity (nv,) does not move the way they went: what rests
        has stopped them."""
        self.ways[self.ways * v[self.rows] <= 0.0] = 0.0

    def add_moving(self, load: np.ndarray) -> np.ndarray:
        """(nv,) a load with the friction of joints that move."""
        self.torques = -self.ways * self.bounds
        total = load.copy()
        total[self.rows] += self.torques
        return total

    def last(self, still: np.ndarray) -> np.ndarray:
        """Torques to start from, of the joints that stand still."""
        return self._last[still]

    def note(self, still: np.ndarray, torques: np.ndarray, rates: np.ndarray, size: float) -> None:
        """Keep what was found at the last evaluation, of the joints that stand still."""
        self.torques[still] = torques
        self.rates[:], self.size = 0.0, size
        self.rates[still], self._last[still] = rates, torques

    def left_to_tear(self) -> float:
        """Margin until one that stands still moves, by the last evaluation [rad/s², m/s²]."""
        return max(TORN * self.size, LEAST_MOVING) - float(np.abs(self.rates).max(initial=0.0))

    def tear(self) -> bool:
        """Let move what friction does not hold, by the last evaluation; whether there was any."""
        torn = (self.ways == 0.0) & (np.abs(self.rates) > TORN * self.size)
        self.ways[torn] = np.sign(self.rates[torn])
        return bool(torn.any())

    def torque_of(self, entry: int) -> float:
        """What an entry of the scene gives, by the last evaluation [N m, N]."""
        share = self.shares.get(entry)
        return 0.0 if share is None else float(share.part * self.torques[share.joint])
