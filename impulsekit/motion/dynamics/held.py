"""Bilateral constraints during the motion: rows, their rates, and how far they have drifted.

What holds, and how it is kept from drifting:

- rows keep the velocity that the scene prescribes (zero, a number, or what it is at the
  start for "kept"), so relative positions keep their value at the start, or move evenly, or
  as a function of time says;
- that is enforced on accelerations, on velocities after every step, and on positions
  wherever the rows determine one: anchors of three directions or more, hinges, sliders
  with their rotation held, locks, and couplings of joints that are no continuous ones;
- an anchor whose points are less than ``CLOSED`` apart at the start is closed for good;
  others keep their distance, as its rows ask for.

Partial rotations in axes that turn with neither body determine no position: of those,
only velocities are kept.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from ...rows.constraints import ConstraintRows
from ...rows.entries import FunctionRows, JointRows
from ...rows.pair import Pair
from ...rows.reach import ReachedModel
from ...scene import Scene
from ...scene.at_time import is_driven, scene_at
from .driven import DrivenRows

__all__ = ["CLOSED", "HeldRows"]

# Loops closed by hand are off by about as much [m].
CLOSED = 1e-6

# What a constraint's coordinates are off by, (k,), at (q, t), and which rows they belong to.
Drift = tuple[slice | list[int], Callable[[np.ndarray, float], np.ndarray]]


class HeldRows:
    """The bilateral rows of a scene on its whole model.

    Attributes:
        rows: of the scene's constraints.
        velocity: (m,) what the rows' velocities are kept at.
        kept: (m,) True where that is what it is at the start; None where none is.
    """

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        self._model = reached.model
        self.rows = ConstraintRows.of(scene_at(scene, 0.0), reached, "constraints")
        self.velocity = self.rows.velocity.copy()
        self.kept = self.rows.kept
        self._driven = [
            DrivenRows(entry, name, where)
            for entry, name, where in zip(
                scene.constraints,
                scene.entry_names("constraints"),
                self.rows.slices,
                strict=True,
            )
            if is_driven(entry)
        ]
        self._drifts: list[Drift] = []
        # Drift is looked at with a workspace of its own.
        self._data: pin.Data | None = None

    def start(self, q: np.ndarray, v: np.ndarray) -> None:
        """Take what "kept" rows keep, and where all rows stand, from the start of the motion."""
        self._data = self._model.createData()
        before = self.rows.matrix(self._data, q).dot(v)
        self.velocity = self.rows.target(before).copy()
        pin.forwardKinematics(self._model, self._data, q)
        self._drifts = []
        driven = {own.where.start: own for own in self._driven}
        for block, where in zip(self.rows.blocks, self.rows.slices, strict=True):
            speed, said = self.velocity[where], block.said
            if where.start in driven:
                self._drifts += driven[where.start].drifts(self._model, said, q)
            elif block.pair is not None:
                self._drifts += _drifts_of_pair(self, block.pair, where.start, speed)
            elif isinstance(said, FunctionRows):
                self._drifts.append((where, _drift_of_functions(said, q, speed)))
            elif isinstance(said, JointRows) and said.whole_joint:
                self._drifts.append((where, self._drift_of_joint(said, q, speed)))
            elif isinstance(said, JointRows):
                self._drifts += self._drift_of_joints(said, q, speed, where)

    def velocity_at(self, t: float) -> np.ndarray:
        """(m,) what the rows' velocities are kept at, at a time [s]."""
        if not self._driven:
            return self.velocity
        velocity = self.velocity.copy()
        for own in self._driven:
            velocity[own.where] = own.velocity(t)
        return velocity

    def rate_at(self, t: float) -> np.ndarray:
        """(m,) how fast these velocities change."""
        rate = np.zeros(len(self.velocity))
        for own in self._driven:
            rate[own.where] = own.acceleration(t)
        return rate

    def drift(self, q: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        """(k,) how far coordinates are off at a time, and (k,) the rows they belong to."""
        pin.forwardKinematics(self._model, self.data, q)
        values: list[np.ndarray] = []
        rows: list[np.ndarray] = []
        everywhere = np.arange(len(self.velocity))
        for where, drift in self._drifts:
            values.append(drift(q, t))
            rows.append(everywhere[where])
        if not values:
            return np.empty(0), np.empty(0, dtype=int)
        return np.concatenate(values), np.concatenate(rows)

    @property
    def data(self) -> pin.Data:
        """Pinocchio's data, with the placements of the last drift."""
        if self._data is None:
            self._data = self._model.createData()
        return self._data

    def _drift_of_joint(self, said: JointRows, q: np.ndarray, speed: np.ndarray) -> Callable:
        model, start = self._model, q.copy()
        first = model.joints[said.terms[0][0][0]].idx_v
        rows = slice(first, first + len(said.terms))
        move = np.zeros(model.nv)
        move[rows] = speed

        def drift(q: np.ndarray, t: float) -> np.ndarray:
            wanted = pin.integrate(model, start, t * move)
            return pin.difference(model, wanted, q)[rows]

        return drift

    def _drift_of_joints(
        self, said: JointRows, q: np.ndarray, speed: np.ndarray, where: slice
    ) -> list[Drift]:
        model = self._model
        if any(model.nqs[joint_id] != 1 for row in said.terms for joint_id, _, _ in row):
            return []
        factors = np.zeros((len(said.terms), model.nq))
        for row, terms in zip(factors, said.terms, strict=True):
            for joint_id, _, factor in terms:
                row[model.idx_qs[joint_id]] += factor
        start = factors.dot(q)
        return [(where, lambda q, t: factors.dot(q) - start - speed * t)]


def _drift_of_functions(said: FunctionRows, q: np.ndarray, speed: np.ndarray) -> Callable:
    start = said.value(q)
    if np.abs(start).max() < CLOSED:
        start = np.zeros(len(start))
    return lambda q, t: said.value(q) - start - speed * t


def _drifts_of_pair(held: HeldRows, pair: Pair, first_row: int, speed: np.ndarray) -> list[Drift]:
    """What the rows of two frames determine of their places, which are in ``held.data``."""
    if pair.said.carrier == "line":
        return [([first_row], _distance_drift(held, pair, float(speed[0])))]
    linear, angular = pair.said.linear, pair.said.angular
    first, other = (placement.copy() for placement in pair.placements(held.data))
    drifts: list[Drift] = []
    rows = [first_row + i for i in range(len(speed))]
    if linear:
        turns_with = len(angular) == 3
        found = _linear_drift(held, pair, linear, turns_with, first, other, speed[: len(linear)])
        if found is not None:
            drifts.append((rows[: len(linear)], found))
    if angular and not speed[len(linear) :].any():
        turned = _angular_drift(held, pair, angular, first, other)
        if turned is not None:
            drifts.append((rows[len(linear) :], turned))
    return drifts


def _distance_drift(held: HeldRows, pair: Pair, speed: float) -> Callable:
    """How far two points are from the distance that they keep."""
    start = pair.distance(held.data)
    return lambda q, t: np.array([pair.distance(held.data) - start - speed * t])


def _linear_drift(
    held: HeldRows,
    pair: Pair,
    linear: list[int],
    turns_with: bool,
    first: pin.SE3,
    other: pin.SE3,
    speed: np.ndarray,
) -> Callable | None:
    moves = bool(speed.any())
    whole = len(linear) == 3 and not moves
    coincides = pair.said.coincides
    if coincides and (whole or turns_with):
        # The point of the other body stays the one that was met at the start.
        if moves:
            return None
        met = other.actInv(first.translation)

        def by_other(q: np.ndarray, t: float) -> np.ndarray:
            one, two = pair.placements(held.data)
            gap = one.translation - two.act(met)
            return pair.said.axes_at(one, two).T.dot(gap)[linear]

        return by_other
    if not (pair.said.carrier == "world" or whole):
        return None
    if coincides and pair.said.other.moves:
        return None
    start = first.translation - other.translation
    if not coincides and np.abs(start).max() < CLOSED:
        start = np.zeros(3)
    velocity = np.zeros(3)
    velocity[linear] = speed

    def between(q: np.ndarray, t: float) -> np.ndarray:
        one, two = pair.placements(held.data)
        gap = one.translation - two.translation - start - t * velocity
        return pair.said.axes_at(one, two).T.dot(gap)[linear]

    return between


def _angular_drift(
    held: HeldRows, pair: Pair, angular: list[int], first: pin.SE3, other: pin.SE3
) -> Callable | None:
    """The turn of ``first`` against ``other`` since the start, in the axes of the rows."""
    relative = other.rotation.T.dot(first.rotation)
    if len(angular) == 3:

        def all_three(q: np.ndarray, t: float) -> np.ndarray:
            one, two = pair.placements(held.data)
            turn = pin.log3(one.rotation.dot(two.rotation.dot(relative).T))
            return pair.said.axes_at(one, two).T.dot(turn)

        return all_three
    local = pair.said.carrier != "world"
    if len(angular) != 2 or not (local or not pair.said.other.moves):
        return None
    (free,) = {0, 1, 2} - set(angular)

    def hinge(q: np.ndarray, t: float) -> np.ndarray:
        one, two = pair.placements(held.data)
        if local:
            # The free axis of ``other``, seen from ``first``: where it was at the start.
            tilt = -one.rotation.T.dot(two.rotation.dot(relative))[:, free]
        else:
            # The body's direction that lay along the free axis at the start.
            tilt = one.rotation.dot(first.rotation.T)[:, free]
        return _tilt(tilt, free)[angular]

    return hinge


def _tilt(axis: np.ndarray, free: int) -> np.ndarray:
    """(3,) e × axis: the small turn that has brought the unit vector e there."""
    unit = np.zeros(3)
    unit[free] = 1.0
    return np.cross(unit, axis)
