"""The whole motion between samples: one polynomial of q and v for every step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..._core import Feature, FeatureKind, RestingContact, RestingState, SlipState

__all__ = ["Path"]


class Path:
    """Steps in order of time; where two meet, the later one counts.

    Attributes:
        step_times: (S,) where they begin [s]. end: where the last one ends [s].
    """

    def __init__(
        self, model: pin.Model, given: Any, t: float, q: np.ndarray, v: np.ndarray
    ) -> None:
        self._model = model
        size = model.nq + model.nv
        self._times = given.times.reshape(-1, 4)
        self._before = given.before.reshape(len(self._times), size)
        self._shape = given.shape.reshape(len(self._times), 7, size)
        self._resting_state: list[int] = given.resting_state
        self._resting_states: list[RestingState] = given.resting_states
        self._last = t, np.array(q), np.array(v)
        self.step_times, self.end = self._times[:, 0], float(t)

    def __len__(self) -> int:
        return len(self._times)

    def arrays(self) -> dict[str, np.ndarray]:
        """The path as plain arrays; ``of_arrays`` makes it again."""
        states = self._resting_states
        points = [np.array([_numbers(p) for p in own.points]).ravel() for own in states]
        dry = [own.dry for own in states]
        t, q, v = self._last
        return {
            "path_times": self._times,
            "path_before": self._before,
            "path_shape": self._shape,
            "path_footing": np.array(self._resting_state, dtype=np.int64),
            "path_rests": np.concatenate([np.zeros(0), *points]),
            "path_rests_end": np.cumsum([own.size for own in points], dtype=np.int64),
            "path_dry": np.array(dry, dtype=np.int64).reshape(len(dry), -1 if len(dry) else 0),
            "path_controls": _table([own.controls for own in states]),
            "path_end": np.concatenate([[t], q, v]),
        }

    @classmethod
    def of_arrays(cls, model: pin.Model, arrays: dict[str, np.ndarray]) -> Path:
        """Return the path that ``arrays`` hold."""
        points = np.split(arrays["path_rests"], arrays["path_rests_end"])[:-1]
        dry = arrays["path_dry"].tolist()
        end = arrays["path_end"]
        states = [
            RestingState(
                points=[_resting_contact(p) for p in own.reshape(-1, PACKED)],
                dry=directions,
                controls=controls,
            )
            for own, directions, controls in zip(points, dry, arrays["path_controls"], strict=True)
        ]
        given = _Steps(
            arrays["path_times"], arrays["path_before"], arrays["path_shape"],
            arrays["path_footing"].tolist(), states,
        )  # fmt: skip
        return cls(model, given, float(end[0]), end[1 : 1 + model.nq], end[1 + model.nq :])

    def between(self, start: float, end: float) -> Iterator[tuple[float, float]]:
        """From when to when steps reach, within a span of time [s]."""
        for first, last, _, _ in self._times.tolist():
            a, b = max(first, start), min(last, end)
            if a < b:
                yield a, b

    def _number(self, t: Any) -> np.ndarray:
        return np.maximum(np.searchsorted(self.step_times, t, side="right") - 1, 0)

    def span(self, t: float) -> tuple[float, float]:
        """From when to when the step reaches that counts at a time [s]."""
        if not len(self):
            return self.end, self.end
        start, end, _, _ = self._times[int(self._number(t))].tolist()
        return start, end

    def resting_state(self, t: float) -> RestingState:
        """Return the resting contacts of the step at a time, as the core has them."""
        if not len(self):
            return RestingState()
        return self._resting_states[self._resting_state[int(self._number(t))]]

    def states(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """q (T, nq) and v (T, nv) at times; just after it where an impact happened."""
        nq = self._model.nq
        found = np.empty((len(times), nq + self._model.nv))
        if len(self):
            own = self._number(times)
            start, end, begin, length = self._times[own].T
            inside = np.minimum(np.maximum(times, start), end)
            x = np.where(length > 0.0, (inside - begin) / np.where(length > 0.0, length, 1.0), 0.0)
            found[:] = 0.0
            for i in range(6, -1, -1):
                found += self._shape[own, i]
                found *= (x if i % 2 == 0 else 1.0 - x)[:, None]
            found += self._before[own]
        t, q, v = self._last
        found[times >= t] = np.concatenate([q, v])
        for row in found:
            row[:nq] = pin.normalize(self._model, row[:nq])
        return found[:, :nq].copy(), found[:, nq:].copy()

    def state(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """q (nq,) and v (nv,) at a time."""
        q, v = self.states(np.array([t]))
        return q[0], v[0]


class _Steps(NamedTuple):
    """The steps of a motion, as the core has them."""

    times: np.ndarray
    before: np.ndarray
    shape: np.ndarray
    resting_state: list[int]
    resting_states: list[RestingState]


# Numbers by which a file keeps a resting point.
PACKED = 21


def _numbers(point: RestingContact) -> list[float]:
    feature = point.feature
    found: list[float] = [point.gap, int(feature.kind), *feature.piece, *feature.index]
    found += [*feature.fixed.tolist(), point.since]
    for slip in (point.slip, point.roll, point.spin):
        found += [float(slip.moves), *slip.direction.tolist()]
    return found


def _resting_contact(numbers: np.ndarray) -> RestingContact:
    gap, kind, *whole = (int(x) for x in numbers[:8])
    fixed = np.ascontiguousarray(numbers[8:11])
    feature = Feature(kind=FeatureKind(kind), piece=whole[:2], index=whole[2:], fixed=fixed)
    slips = [
        SlipState(moves=bool(own[0]), direction=own[1:].copy())
        for own in numbers[12:].reshape(3, 3)
    ]
    return RestingContact(
        gap=gap, feature=feature, since=float(numbers[11]),
        slip=slips[0], roll=slips[1], spin=slips[2],
    )  # fmt: skip


def _table(controls: Sequence[np.ndarray]) -> np.ndarray:
    """Torques that were set, (resting_states, nv), or (resting_states, 0) where none ever were."""
    size = max((own.size for own in controls), default=0)
    full = [own if own.size else np.zeros(size) for own in controls]
    return np.array(full, dtype=float).reshape(len(controls), size)
