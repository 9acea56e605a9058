"""Constraints and contacts that are given by functions of the configuration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from ..errors import CallbackError, ImpulsekitError, InputError, RangeError, ShapeError
from ..errors.calls import public
from ..robot import Robot
from .coefficients import Damping, RestitutionLike, Stiffness
from .constraints import velocity_of
from .contacts import Tangential
from .entry import Entry
from .functions import numbers_from
from .numbers import Name, NotNegative, OfMotion, OfState, Velocity, keep, number

MOST_ROWS = 1000


class _OfFunctions(Entry):
    """An entry that functions of the configuration give."""

    # What a function of q depends on is not known by name.
    of_whole_robot: ClassVar[bool] = True

    def check_robot(self, robot: Robot, where: str) -> None:
        """Compare the gradient with differences, where its function is defined."""
        check_gradient(robot, self, where)


@public
@dataclass(frozen=True)
class GapConstraint(_OfFunctions):
    """Functions of the configuration that are kept: g(q) = 0, or g at its value at the start.

    A bead on a wire, a cam that drives its follower, a gear of varying ratio. The multipliers act
    along the generalized speeds, as motors in the joints would.

    Attributes:
        g: function of q (nq,), read-only, that gives ``rows`` numbers. In ``simulate`` it keeps
            the value of the start; within 1e-6 of zero there it is zero.
        gradient: function of q that gives (rows, nv): ġ = gradient(q) · v, with the speeds of
            Pinocchio (of a joint with one degree of freedom dq/dt). It is compared with differences
            of g. None for these differences themselves, right to some 1e-10.
        bias: function of (q, v) that gives d/dt(gradient) · v (rows,); None for differences.
        rows: how many numbers g gives.
        velocity: the value of ġ after the impact: a number for all rows, one for each, "kept",
            or a function of time [s].
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, RangeError, NotFiniteError, ShapeError.

    Example:
        A bead with coordinates x and z on the parabola z = x².

        >>> wire = GapConstraint(
        ...     lambda q: q[1] - q[0] ** 2, gradient=lambda q: [[-2 * q[0], 1]], name="wire"
        ... )
        >>> wire.rows
        1
    """

    section = "constraints"

    g: OfState
    gradient: OfState | None = None
    bias: OfMotion | None = None
    rows: int = 1
    velocity: Velocity = 0.0
    name: Name | None = None

    def _check(self, what: str) -> None:
        rows = number(self.rows, f"{what}: rows")
        if rows != int(rows) or not 1 <= rows <= MOST_ROWS:
            raise RangeError.of(f"{what}: rows", self.rows, f"1 to {MOST_ROWS}")
        object.__setattr__(self, "rows", int(rows))
        keep(self, what, velocity_of(self.rows), "velocity")


@public
@dataclass(frozen=True)
class GapContact(_OfFunctions):
    """A contact whose gap is a function of the configuration: a cam and its follower, clearance.

    In ``solve`` it touches where the gap is zero or less. Impulses, forces and velocities are
    given by row: along both tangents, then the normal.

    Attributes:
        gap: function of q (nq,), read-only: 0 where it touches, positive apart [m or rad].
        normal: function of q that gives (nv,): the rate of the gap is normal(q) · v, with the
            speeds of Pinocchio. It is compared with differences of the gap. None for these.
        tangents: function of q that gives (2, nv) or (1, nv): how fast it slips; needed for
            friction. Their scale must be that of a velocity where the normal's is.
        restitution, friction, tangential_restitution, stiffness, stiffness_ratio,
            tangential_damping: as for ``Contact``.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, RangeError, NotFiniteError.

    Example:
        A follower's height q[1] over a cam that turns by q[0].

        >>> import math
        >>> cam = GapContact(lambda q: q[1] - 0.2 - 0.05 * math.cos(q[0]), restitution=0.3)
        >>> cam.friction
        0.0
    """

    section = "contacts"

    gap: OfState
    normal: OfState | None = None
    tangents: OfState | None = None
    restitution: RestitutionLike = 0.0
    friction: NotNegative = 0.0
    tangential_restitution: Tangential = 0.0
    name: Name | None = None
    stiffness: Stiffness = None
    stiffness_ratio: Stiffness = None
    tangential_damping: Damping = None

    def _check(self, what: str) -> None:
        if self.friction and self.tangents is None:
            raise InputError(f"{what}: friction needs tangents, the rows of its slip")


# How far configurations are moved for differences of fourth order [m, rad]: where these differ
# least from those of twice the move, rounding counted in.
MOVES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
# A gradient that is off by more than this part of its largest entry, or of 1, is a mistake.
MISTAKEN = 1e-6
# Where the gradient is tried when a scene is made: this far from the neutral configuration.
AWAY = 0.1


class FunctionRows:
    """The rows of a ``GapConstraint`` (k, nv), or of a ``GapContact`` (3, nv).

    Attributes:
        labels: of the rows.
    """

    def __init__(self, robot: Robot, entry: GapConstraint | GapContact, name: str = "") -> None:
        self._model, self._entry = robot.model, entry
        self._what = name or entry.name or type(entry).__name__
        self._move = 0.0
        if isinstance(entry, GapConstraint):
            self._value, self._gradient, self._size = entry.g, entry.gradient, entry.rows
            self._names = "g", "gradient"
            count = entry.rows
            self.labels = ("g",) if count == 1 else tuple(f"g{i}" for i in range(count))
        else:
            self._value, self._gradient, self._size = entry.gap, entry.normal, 1
            self._names = "gap", "normal"
            self.labels = ("t1", "t2", "n")

    def value(self, q: np.ndarray) -> np.ndarray:
        """Return (k,) g, or (1,) the gap."""
        return numbers_from(self._value, f"{self._what}: {self._names[0]}", self._size, q)

    def matrix_at(self, q: np.ndarray) -> np.ndarray:
        """Return (k, nv) the rows at q.

        Raises:
            RangeError: a gradient is not that of its function.
        """
        if self._move == 0.0:
            self.check(q)
        rows = self._own_rows(q)
        if isinstance(self._entry, GapConstraint):
            return rows
        whole = np.zeros((3, self._model.nv))
        whole[2] = rows[0]
        if self._entry.tangents is not None:
            tangents = self._matrix(self._entry.tangents, "tangents", q, None)
            whole[: len(tangents)] = tangents
        return whole

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return (k,) how fast the rows' velocities change where no joint accelerates."""
        entry = self._entry
        if isinstance(entry, GapConstraint) and entry.bias is not None:
            return numbers_from(entry.bias, f"{self._what}: bias", self._size, q, v)
        if self._move == 0.0:
            self.check(q)
        size = float(np.abs(v).max(initial=0.0))
        if size == 0.0:
            return np.zeros(len(self.labels))
        return self._along(q, v / size, lambda there: self.matrix_at(there).dot(v)) * size

    def check(self, q: np.ndarray) -> None:
        """Check that the gradient is that of the function at q.

        Raises:
            RangeError: it is not.
        """
        error = self._choose_move(q)
        if self._gradient is None:
            return
        given, found = self._own_rows(q), self._by_differences(q)
        size = max(1.0, float(np.abs(found).max(initial=0.0)))
        off = np.abs(given - found)
        if off.max(initial=0.0) > MISTAKEN * size + error:
            row, column = np.unravel_index(int(off.argmax()), off.shape)
            raise RangeError.of(
                f"{self._what}: {self._names[1]}[{row}, {column}]",
                float(given[row, column]),
                f"{found[row, column]:.9g}, the derivative of {self._names[0]}",
            )

    def _own_rows(self, q: np.ndarray) -> np.ndarray:
        if self._gradient is None:
            return self._by_differences(q)
        return self._matrix(self._gradient, self._names[1], q, self._size)

    def _matrix(
        self, function: Callable, field: str, q: np.ndarray, rows: int | None
    ) -> np.ndarray:
        """(k, nv) what a function gives; of one row (nv,) will do."""
        nv, what = self._model.nv, f"{self._what}: {field}"

        def flat(q: np.ndarray) -> np.ndarray:
            return np.asarray(function(q), dtype=float).ravel()

        try:
            count = flat(q.copy()).size // nv
        except Exception:
            count = 0
        expected = rows or min(max(count, 1), 2)
        given = numbers_from(flat, what, expected * nv, q)
        if given.size != expected * nv:
            raise ShapeError.of(what, (expected, nv), given.shape)
        return given.reshape(expected, nv)

    def _by_differences(self, q: np.ndarray) -> np.ndarray:
        columns = [self._along(q, unit, self.value) for unit in np.eye(self._model.nv)]
        return np.array(columns).T.reshape(self._size, self._model.nv)

    def _choose_move(self, q: np.ndarray) -> float:
        """Choose how far to move for differences; how much these may be off."""
        best = np.inf
        rounding = np.finfo(float).eps * float(np.abs(self.value(q)).max(initial=0.0))
        for move in MOVES:
            off = 0.0
            for unit in np.eye(self._model.nv):
                # The error of fourth order is a fifteenth of what twice the move changes.
                one, two, four = (
                    self._difference(q, n * move * unit, self.value) for n in (1, 2, 4)
                )
                change = (8.0 * one - two) / 12.0 - (8.0 * two - four) / 24.0
                off = max(off, float(np.abs(change).max()) / (15.0 * move))
            off += 2.0 * rounding / move
            if off < best:
                self._move, best = move, off
        return best

    def _along(
        self, q: np.ndarray, way: np.ndarray, function: Callable[[np.ndarray], np.ndarray]
    ) -> np.ndarray:
        """The derivative of a function of q along a way (nv,)."""
        move = self._move
        near, far = (self._difference(q, n * move * way, function) for n in (1, 2))
        return (8.0 * near - far) / (12.0 * move)

    def _difference(
        self, q: np.ndarray, by: np.ndarray, function: Callable[[np.ndarray], np.ndarray]
    ) -> np.ndarray:
        ends = [function(pin.integrate(self._model, q, s * by)) for s in (1.0, -1.0)]
        return ends[0] - ends[1]


def check_gradient(robot: Robot, entry: Any, where: str) -> None:
    """Compare the gradient of an entry with differences, where its function is defined.

    Raises:
        RangeError, ShapeError: it is not the gradient.
    """
    rows, model = FunctionRows(robot, entry, where), robot.model
    neutral = robot.neutral()
    for sign in (0.0, 1.0, -1.0):
        # Along all coordinates by different ways.
        way = sign * AWAY * (1.0 + np.arange(model.nv)) / max(model.nv, 1)
        try:
            rows.check(pin.integrate(model, neutral, way))
        except (CallbackError, ZeroDivisionError):
            continue
        except ImpulsekitError as error:
            if not error.from_function or isinstance(error, RangeError | ShapeError):
                raise
