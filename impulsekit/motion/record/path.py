"""The whole motion between samples: one polynomial in a chart for every step."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import pinocchio as pin

from ..rest.footing import NOTHING, Footing
from ..tree.chart import Chart

__all__ = ["NODES", "Interpolant", "Path", "Piece", "interpolated"]

# A place this near to a node, as a part of the step, is the node.
AT_ONCE = 1e-14
# DOP853's dense output has degree 7, the others less: eight values hold each of them.
NODES = 0.5 * (1.0 - np.cos(np.pi * np.arange(8) / 7.0))
_WEIGHTS = np.array([0.5, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -0.5])


def interpolated(parts: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(m, k) the polynomial through values (8, k) at ``NODES``, at other parts (m,) of a step.

    Barycentric (Berrut & Trefethen 2004).
    """
    differences = parts[:, None] - NODES
    hits = np.abs(differences) < AT_ONCE
    weights = _WEIGHTS / np.where(hits, 1.0, differences)
    weights = np.where(hits.any(axis=1)[:, None], hits.astype(float), weights)
    return weights.dot(values) / weights.sum(axis=1)[:, None]


@dataclass(frozen=True, eq=False)
class Piece:
    """One step: y = (x, v) as a function of time, in the chart around ``reference``."""

    start: float
    end: float
    reference: np.ndarray
    dense: Callable[[float], np.ndarray]
    footing: Footing


class Interpolant:
    """The polynomial through eight values of a step; see ``interpolated``."""

    def __init__(self, start: float, end: float, values: np.ndarray) -> None:
        self._start, self._length, self._values = start, end - start, values

    def __call__(self, t: float) -> np.ndarray:
        if not self._length:
            return self._values[0]
        part = (t - self._start) / self._length
        return interpolated(np.array([part]), self._values)[0]


class Path:
    """Pieces in order of time; where two meet, the later one counts."""

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        self._chart = Chart(model)
        self._starts: list[float] = []
        # What is not asked for is not made.
        self._pieces: list[Piece | Callable[[], Piece]] = []

    def append(
        self,
        start: float,
        end: float,
        reference: np.ndarray,
        dense: Callable[[float], np.ndarray],
        footing: Footing = NOTHING,
    ) -> None:
        """Add the piece that follows."""
        self._starts.append(start)
        self._pieces.append(Piece(start, end, reference, dense, footing))

    def extend(self, starts: list[float], piece: Callable[[int], Piece]) -> None:
        """Add pieces that begin then [s] and are made by number when they are asked for."""
        self._starts += starts
        self._pieces += [partial(piece, k) for k in range(len(starts))]

    def _at(self, i: int) -> Piece:
        piece = self._pieces[i]
        if not isinstance(piece, Piece):
            piece = self._pieces[i] = piece()
        return piece

    def _all(self) -> list[Piece]:
        return [self._at(i) for i in range(len(self._pieces))]

    def shorten(self, count: int) -> None:
        """Keep the first ``count`` pieces only."""
        del self._starts[count:], self._pieces[count:]

    def __len__(self) -> int:
        return len(self._pieces)

    @property
    def end(self) -> float:
        """Where the last piece ends [s]."""
        return self._at(len(self._pieces) - 1).end

    @property
    def step_times(self) -> np.ndarray:
        """(S,) where the pieces begin [s]."""
        return np.array(self._starts)

    def piece(self, t: float) -> Piece:
        """The one that counts at a time: the later one where two meet."""
        return self._at(max(bisect_right(self._starts, t) - 1, 0))

    def between(self, start: float, end: float) -> Iterator[tuple[float, float]]:
        """From when to when pieces reach, within a span of time [s]."""
        for piece in self._all():
            a, b = max(piece.start, start), min(piece.end, end)
            if a < b:
                yield a, b

    @property
    def footings(self) -> list[Footing]:
        """Of every piece, what rested in it."""
        return [piece.footing for piece in self._all()]

    def state(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """q (nq,) and v (nv,) at a time; just after it where an impact happened."""
        piece = self.piece(t)
        y = piece.dense(min(max(t, piece.start), piece.end))
        nv = self._model.nv
        return np.array(self._chart.configuration(y[:nv], piece.reference)), y[nv:].copy()

    def arrays(self) -> dict[str, np.ndarray]:
        """The pieces as plain arrays."""
        nv = self._model.nv
        values = np.empty((len(self._pieces), len(NODES), 2 * nv))
        for piece, own in zip(self._all(), values, strict=True):
            for s, row in zip(NODES, own, strict=True):
                row[:] = piece.dense(piece.start + s * (piece.end - piece.start))
        references = [piece.reference for piece in self._all()]
        return {
            "path_start": self.step_times,
            "path_end": np.array([piece.end for piece in self._all()]),
            "path_reference": np.array(references).reshape(len(self._pieces), self._model.nq),
            "path_values": values,
        }

    @classmethod
    def of_arrays(
        cls, model: pin.Model, arrays: dict[str, np.ndarray], footings: Sequence[Footing]
    ) -> Path:
        """The path that ``arrays`` tells of, with what rested in each of its pieces."""
        path = cls(model)
        for start, end, reference, values, footing in zip(
            arrays["path_start"].tolist(),
            arrays["path_end"].tolist(),
            arrays["path_reference"],
            arrays["path_values"],
            footings,
            strict=True,
        ):
            path.append(start, end, reference, Interpolant(start, end, values), footing)
        return path
