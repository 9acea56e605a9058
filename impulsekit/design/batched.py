"""v⁺ of many measured impacts and its derivatives by the unknowns, by ``solve_batch``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..batch.solve import solve_batch
from ..errors import InputError
from ..impact.solver import solve_without_warnings
from ..scene import Scene
from ..tolerances import NONZERO
from .measurement import Measurement
from .parameters import Parameter, changed_scene, scene_of

__all__ = ["BatchedImpacts", "is_batch", "predicted"]

# Below so many impacts a scene, one by one takes less than a compilation, with exact derivatives.
FEWEST_FOR_BATCH = 24
# Step of central differences [of a coefficient]: truncation 1e-10, rounding 1e-10 of the speed.
STEP = 1e-5
# Derivatives below this share of the largest speed are rounding of differences.
NO_SLOPE = 1e-8


def is_batch(measurements: Sequence[Measurement]) -> bool:
    """Whether so many impacts share a scene that batches are faster than one by one."""
    parts = {(id(m.scene), m.group) for m in measurements}
    return len(measurements) >= FEWEST_FOR_BATCH * len(parts)


class BatchedImpacts:
    """Measurements by scene and group, each solved as one batch.

    Args:
        measurements: all of them.
        parameters: coefficients of contacts; none of an inertia.
    """

    def __init__(
        self, measurements: Sequence[Measurement], parameters: Sequence[Parameter]
    ) -> None:
        self._parameters, self._count = parameters, len(measurements)
        parts: dict[Any, list[int]] = {}
        for k, m in enumerate(measurements):
            parts.setdefault((id(m.scene), m.group, tuple(sorted(m.points))), []).append(k)
        self._parts = []
        for (_, group, names), rows in parts.items():
            own = [measurements[k] for k in rows]
            points = {name: np.array([m.points[name] for m in own], float) for name in names}
            q = np.array([m.q for m in own], dtype=float)
            v = np.array([m.v_before for m in own], dtype=float)
            self._parts.append((own[0].scene, group, np.array(rows), q, v, points))

    def v_after(self, x: np.ndarray) -> list[np.ndarray]:
        """(M,) of (nv,).

        Raises:
            InputError: an impact that has no valid solution.
        """
        found: list[np.ndarray] = [np.empty(0)] * self._count
        for scene, group, rows, q, v, points in self._parts:
            changed = changed_scene(scene, self._parameters, x, group)
            batch = solve_batch(changed, q, v, points=points or None)
            bad = np.flatnonzero(~np.isfinite(batch.v_after).all(axis=1))
            if len(bad):
                raise InputError(
                    f"measurements[{rows[bad[0]]}]: no valid impact, {batch.status[bad[0]]}"
                )
            for k, after in zip(rows.tolist(), batch.v_after, strict=True):
                found[k] = after
        return found

    def __call__(self, x: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """By measurement: v⁺ (nv,) and its derivatives (nv, P), by differences."""
        after = self.v_after(x)
        columns = []
        for i, parameter in enumerate(self._parameters):
            low, high = x.copy(), x.copy()
            low[i] = max(x[i] - STEP, parameter.low)
            high[i] = min(x[i] + STEP, parameter.high)
            pairs = zip(self.v_after(low), self.v_after(high), strict=True)
            columns.append([(b - a) / (high[i] - low[i]) for a, b in pairs])
        for k, own in enumerate(after):
            slopes = np.array([column[k] for column in columns]).T
            slopes[np.abs(slopes) < NO_SLOPE * max(float(np.abs(own).max()), NONZERO)] = 0.0
            yield own, slopes


def predicted(
    measurements: Sequence[Measurement], parameters: Sequence[Parameter], x: np.ndarray
) -> list[np.ndarray]:
    """(M,) of (nv,) v⁺ at values x (P,) of the unknowns.

    Raises:
        InputError: an impact that has no valid solution.
    """
    if is_batch(measurements):
        return BatchedImpacts(measurements, parameters).v_after(x)
    kept: dict[Any, Scene] = {}
    return [
        solve_without_warnings(scene_of(m, parameters, x, kept), m.q, m.v_before).v_after
        for m in measurements
    ]
