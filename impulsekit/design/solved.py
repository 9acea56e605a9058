"""Measured impacts solved at values of the unknowns: v⁺ and its derivatives, each found once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..impact.derivatives import derivatives
from ..impact.solver import solve_without_warnings
from ..scene import Scene
from .batched import BatchedImpacts, is_batch
from .differences import has_functions, slopes_by_differences
from .measurement import Measurement
from .parameters import Parameter, column_of, scene_of

__all__ = ["SolvedImpacts"]

# Values of the unknowns that are remembered: weights change where a fit has ended, the next one
# begins there, and a step or two may have been tried behind it.
REMEMBERED = 4

# Of a measurement: v⁺ (nv,), its derivatives (nv, P) by the unknowns; (nv, nv) by q and v⁻.
_Solved = tuple[np.ndarray, np.ndarray]
_Slopes = tuple[np.ndarray, np.ndarray]


class SolvedImpacts:
    """Measurements at values of the unknowns; the last few values are remembered.

    Args:
        measurements: all of them.
        parameters: what is fitted; inertias: whether one of them is of an inertia.
    """

    def __init__(
        self, measurements: Sequence[Measurement], parameters: Sequence[Parameter], inertias: bool
    ) -> None:
        self._measurements, self._parameters = tuple(measurements), parameters
        functions = any(has_functions(m.scene) for m in measurements)
        self._batched: BatchedImpacts | None = None
        if (functions or is_batch(measurements)) and not inertias:
            self._batched = BatchedImpacts(measurements, parameters)
        self._known: dict[bytes, tuple[list[_Solved], dict[int, _Slopes]]] = {}

    def at(self, x: np.ndarray) -> list[_Solved]:
        """By measurement: v⁺ (nv,) and its derivatives (nv, P) at values (P,)."""
        return self._of(x)[0]

    def slopes(self, x: np.ndarray) -> dict[int, _Slopes]:
        """Of measurements with a covariance: ∂v⁺/∂q and ∂v⁺/∂v⁻, each (nv, nv)."""
        slopes = self._of(x)[1] if self._batched is None else {}
        scenes: dict[Any, Scene] = {}
        for i, m in enumerate(self._measurements):
            if m.covariance is None or i in slopes:
                continue
            scene = scene_of(m, self._parameters, x, scenes)
            if has_functions(scene):
                slopes[i] = slopes_by_differences(scene, m.q, m.v_before)
            else:
                found = derivatives(solve_without_warnings(scene, m.q, m.v_before))
                slopes[i] = found.dv_after_dq, found.dv_after_dv
        return slopes

    def _of(self, x: np.ndarray) -> tuple[list[_Solved], dict[int, _Slopes]]:
        key = x.tobytes()
        if key not in self._known:
            slopes: dict[int, _Slopes] = {}
            found = self._batched(x) if self._batched is not None else self._each(x, slopes)
            # Nothing is remembered of values that are refused.
            self._known[key] = list(found), slopes
            if len(self._known) > REMEMBERED:
                del self._known[next(iter(self._known))]
        return self._known[key]

    def _each(self, x: np.ndarray, slopes: dict[int, _Slopes]) -> Iterator[_Solved]:
        scenes: dict[Any, Scene] = {}
        for i, m in enumerate(self._measurements):
            scene = scene_of(m, self._parameters, x, scenes)
            impact = solve_without_warnings(scene, m.q, m.v_before)
            found = derivatives(impact)
            if m.covariance is not None:
                slopes[i] = found.dv_after_dq, found.dv_after_dv
            columns = [column_of(parameter, found, m.group) for parameter in self._parameters]
            yield impact.v_after, np.array(columns).T
