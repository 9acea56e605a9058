"""``Recording``: configurations over time, from wherever they come."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..design.parameters import checked_sigma
from ..errors import InputError, NotFiniteError, RangeError, ShapeError, a_thing
from ..errors.calls import public
from ..formatting import OneLine
from ..robot import Robot
from ..robot.arrays import floats, lock
from ..robot.state import QUATERNION_TOLERANCE, checked_configuration

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..impact import Impact
    from .columns import RecordingFormat


def _slopes(times: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return (nv,) slopes at 0 of the parabolas, or lines through two samples, that fit best."""
    order = min(2, len(times) - 1)
    size = float(np.abs(times).max())
    powers = np.stack([(times / size) ** k for k in range(order + 1)], axis=1)
    return np.linalg.lstsq(powers, offsets, rcond=None)[0][1] / size


@public
@dataclass(frozen=True, eq=False, repr=False)
class Recording(OneLine):
    """Configurations of a robot over time: a log, the result of another simulator, a path.

    Attributes:
        robot: the robot.
        t: (T,) times [s], not decreasing; read-only.
        q: (T, nq) configurations; read-only.
        impacts: pairs of a time [s] and an ``Impact``.
        v: (T, nv) recorded velocities, or None; read-only.
        sigma: standard deviation of the noise of q on its tangent [m, rad], one number or
            (nv,); None if unknown.
        name: what reports call it.
        notes: what was repaired or left out while reading, a sentence each.

    Raises:
        InputError: no instant, or an impact of another robot.
        ShapeError, NotFiniteError, RangeError: the arrays do not match.
        StateError: a quaternion is not of unit length.

    Example:
        >>> robot = Robot.from_example("panda")
        >>> q = np.array([robot.neutral(), robot.configuration(panda_joint1=1.0)])
        >>> round(float(Recording(robot, [0.0, 2.0], q).at(np.array([0.5]))[0, 0]), 3)
        0.25
    """

    robot: Robot
    t: Any
    q: Any
    impacts: Iterable[tuple[float, Impact]] = ()
    v: Any = None
    sigma: Any = None
    name: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.robot, Robot):
            raise InputError(f"Recording: robot is {a_thing(self.robot)}, not a Robot")
        model = self.robot.model
        t, q = (
            floats(array, f"Recording: {what}") for what, array in (("t", self.t), ("q", self.q))
        )
        if t.ndim != 1:
            raise ShapeError.of("Recording: t", (t.size,), t.shape)
        if t.size == 0:
            raise InputError("Recording: t holds no samples")
        if q.shape != (t.size, self.robot.nq):
            raise ShapeError.of("Recording: q", (t.size, self.robot.nq), q.shape)
        arrays = {"t": t, "q": q}
        if self.v is not None:
            arrays["v"] = v = floats(self.v, "Recording: v")
            if v.shape != (t.size, model.nv):
                raise ShapeError.of("Recording: v", (t.size, model.nv), v.shape)
        for what, array in arrays.items():
            if not np.isfinite(array).all():
                index = int(np.flatnonzero(~np.isfinite(array.reshape(t.size, -1)).all(axis=1))[0])
                raise NotFiniteError.of(f"Recording: {what}", f"instant {index}", array[index])
        if (np.diff(t) < 0.0).any():
            index = int(np.flatnonzero(np.diff(t) < 0.0)[0])
            raise RangeError.of(f"Recording: t[{index + 1}]", t[index + 1], f"{t[index]} or more")
        for row in q:
            if not pin.isNormalized(model, row, QUATERNION_TOLERANCE):
                checked_configuration(model, row)
        if self.sigma is not None:
            arrays["sigma"] = checked_sigma(self.sigma, model.nv, "Recording: sigma")
        impacts = _impacts(self.impacts)
        for time, impact in impacts:
            if impact.scene.robot.nq != self.robot.nq:
                raise InputError(f"Recording: the impact at {time:g} s is of another robot")
        lock(*arrays.values())
        for field, value in (*arrays.items(), ("impacts", impacts), ("notes", tuple(self.notes))):
            object.__setattr__(self, field, value)

    @classmethod
    def from_columns(
        cls,
        robot: Robot,
        columns: Mapping[str, ArrayLike],
        format: RecordingFormat | None = None,
        *,
        repair: str | Sequence[str] = (),
        name: str = "",
    ) -> Recording:
        """Return a recording of named columns; see ``load_recordings`` for names and repairs.

        Args:
            robot: the robot.
            columns: arrays with T rows by name: "t", and "q", or "position" and
                "quaternion_xyzw" or "quaternion_wxyz", or "q.JOINT" for each joint.
            format: units and orders that the names do not say.
            repair: names of the repairs that may be made.
            name: what reports call it.

        Raises:
            InputError, ShapeError, NotFiniteError, RangeError, StateError, UnknownNameError.

        Example:
            >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
            >>> columns = {"t": [0.0, 0.1], "position": [[0, 0, 1], [0, 0, 0.9]],
            ...            "quaternion_wxyz": [[1, 0, 0, 0], [1, 0, 0, 0]]}
            >>> Recording.from_columns(ball, columns).q[1].tolist()
            [0.0, 0.0, 0.9, 0.0, 0.0, 0.0, 1.0]
        """
        from .columns import read_columns

        t, q, v, notes = read_columns(robot, columns, format, repair=repair, name=name)
        return cls(robot, t, q, v=v, name=name, notes=notes)

    def at(self, times: np.ndarray) -> np.ndarray:
        """Return (F, nq) configurations at (F,) times [s], along geodesics between the instants."""
        after = np.clip(np.searchsorted(self.t, times, side="right"), 1, max(len(self.t) - 1, 1))
        found = np.empty((len(times), self.robot.nq))
        for row, (time, i) in enumerate(zip(times, after, strict=True)):
            if len(self.t) == 1:
                found[row] = self.q[0]
                continue
            span = self.t[i] - self.t[i - 1]
            share = float(np.clip((time - self.t[i - 1]) / span, 0.0, 1.0)) if span > 0 else 1.0
            if share in (0.0, 1.0):
                found[row] = self.q[i - 1 + round(share)]
            else:
                found[row] = pin.interpolate(self.robot.model, self.q[i - 1], self.q[i], share)
        return found

    def part(self, start: float, end: float) -> Recording:
        """Return the instants from ``start`` to ``end`` [s], both included.

        Raises:
            RangeError: there is no instant between them.
        """
        inside = (self.t >= start) & (self.t <= end)
        if not inside.any():
            reach = f"within {self.t[0]:g} to {self.t[-1]:g} s"
            raise RangeError.of("start and end", f"{start:g} to {end:g} s", reach)
        return replace(
            self,
            t=self.t[inside],
            q=self.q[inside],
            v=None if self.v is None else self.v[inside],
            impacts=tuple((time, each) for time, each in self.impacts if start <= time <= end),
        )

    def velocities(self, breaks: Sequence[float] = (), reach: int = 4) -> np.ndarray:
        """Return (T, nv) velocities by local fits of second order on the manifold.

        Each is the slope of a parabola through the nearest samples, ``reach`` on either side, in
        the tangent space at its own sample (Savitzky & Golay 1964, on the group); samples on
        the other side of a time in ``breaks``, such as an impact, take no part.

        Raises:
            InputError: fewer than two samples between two breaks.
            RangeError: ``reach`` is below 1.
        """
        if reach < 1:
            raise RangeError.of("reach", reach, "1 or more")
        t, q, model = self.t, self.q, self.robot.model
        piece = np.searchsorted(np.sort(np.asarray(breaks, dtype=float)), t, side="right")
        found = np.empty((len(t), model.nv))
        for k in range(len(t)):
            low, high = max(0, k - reach), min(len(t), k + reach + 1)
            near = low + np.flatnonzero(piece[low:high] == piece[k])
            near = near[(near == k) | (t[near] != t[k])]
            if len(near) < 2:
                raise InputError(
                    f"velocities: the sample at {t[k]:g} s has no other between two breaks; "
                    "give fewer breaks"
                )
            offsets = np.array([pin.difference(model, q[k], q[i]) for i in near])
            found[k] = _slopes(t[near] - t[k], offsets)
        return found


def _impacts(given: Any) -> tuple[tuple[float, Impact], ...]:
    """Return pairs of a time and an impact."""
    if isinstance(given, Iterable):
        pairs = [each if isinstance(each, tuple | list) else () for each in given]
        if all(len(pair) == 2 and hasattr(pair[1], "scene") for pair in pairs):
            return tuple((float(time), impact) for time, impact in pairs)
    raise InputError(
        f"Recording: impacts must be pairs of a time [s] and an Impact, got {a_thing(given)}; "
        "give velocities as v=..."
    )


def as_recordings(given: Any, what: str) -> list[Recording]:
    """Return one recording or several as a list, for a function, ``what`` in words.

    Raises:
        InputError: something else is among them.
    """
    alone = isinstance(given, Recording) or not isinstance(given, Iterable)
    several = [given] if alone else list(given)
    for each in several:
        if not isinstance(each, Recording):
            raise InputError(f"{what} takes Recordings, not {a_thing(each)}")
    return several
