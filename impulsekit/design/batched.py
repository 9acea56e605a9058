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
# The same where each impact has a point, and so a scene and a plan, of its own.
FEWEST_WITH_POINTS = 6
# Step of central differences [of a coefficient]: truncation 1e-10, rounding 1e-10 of the speed.
COEFFICIENT_STEP = 1e-5
# Derivatives below this share of the largest speed are rounding of differences.
NO_SLOPE = 1e-8


def is_batch(measurements: Sequence[Measurement]) -> bool:
    """Whether so many impacts share a scene that batches are faster than one by one."""
    fewest = FEWEST_WITH_POINTS if any(m.points for m in measurements) else FEWEST_FOR_BATCH
    return len(measurements) >= fewest * len({id(m.scene) for m in measurements})


class BatchedImpacts:
    """Measurements by scene, each solved as one batch at several values of the unknowns.

    Args:
        measurements: all of them.
        parameters: coefficients of contacts; none of an inertia.
    """

    def __init__(
        self, measurements: Sequence[Measurement], parameters: Sequence[Parameter]
    ) -> None:
        self._parameters, self._count = parameters, len(measurements)
        # Numbers vary by row; tables of e by speed need a scene for each value, and group.
        self._tables = any(each.speeds for each in parameters)
        parts: dict[Any, list[int]] = {}
        for k, m in enumerate(measurements):
            group = m.group if self._tables else None
            parts.setdefault((id(m.scene), group, tuple(sorted(m.points))), []).append(k)
        self._parts = []
        for (*_, names), rows in parts.items():
            own = [measurements[k] for k in rows]
            points = {name: np.array([m.points[name] for m in own], float) for name in names}
            q = np.array([m.q for m in own], dtype=float)
            v = np.array([m.v_before for m in own], dtype=float)
            groups = np.array([m.group for m in own], dtype=object)
            self._parts.append((own[0].scene, groups, np.array(rows), q, v, points))

    def v_after(self, x: np.ndarray) -> list[np.ndarray]:
        """(M,) of (nv,).

        Raises:
            InputError: an impact that has no valid solution.
        """
        return self._solved(x[None])[0]

    def _solved(self, several: np.ndarray) -> list[list[np.ndarray]]:
        """v⁺ at each of (K, P) values: K lists of (M,) of (nv,)."""
        found = [[np.empty(0)] * self._count for _ in several]
        for scene, groups, rows, q, v, points in self._parts:
            if self._tables:
                changed = [changed_scene(scene, self._parameters, x, groups[0]) for x in several]
                batches = [solve_batch(each, q, v, points=points or None) for each in changed]
                after = np.array([batch.v_after for batch in batches])
                status = np.array([batch.status for batch in batches])
            else:
                count = len(several)
                coefficients = self._coefficients(scene, groups, several)
                batch = solve_batch(
                    scene, np.tile(q, (count, 1)), np.tile(v, (count, 1)),
                    points={name: np.tile(own, (count, 1)) for name, own in points.items()} or None,
                    restitution=coefficients["restitution"] or None,
                    friction=coefficients["friction"] or None,
                )  # fmt: skip
                after = batch.v_after.reshape(count, len(rows), -1)
                status = np.array(batch.status).reshape(count, len(rows))
            bad = np.argwhere(~np.isfinite(after).all(axis=2))
            if len(bad):
                at, row = bad[0]
                raise InputError(f"measurements[{rows[row]}]: no valid impact, {status[at, row]}")
            for own, values in zip(found, after, strict=True):
                for k, each in zip(rows.tolist(), values, strict=True):
                    own[k] = each
        return found

    def _coefficients(
        self, scene: Scene, groups: np.ndarray, several: np.ndarray
    ) -> dict[str, dict[str, np.ndarray]]:
        """By kind and contact, (K · rows,) coefficients at each of (K, P) values."""
        found: dict[str, dict[str, np.ndarray]] = {"restitution": {}, "friction": {}}
        entries = dict(zip(scene.entry_names("contacts"), scene.contacts, strict=True))
        for parameter, values in zip(self._parameters, several.T, strict=True):
            chosen = np.ones(len(groups), dtype=bool)
            if parameter.group is not None:
                chosen = groups == parameter.group
            for name in parameter.contacts:
                own = getattr(entries.get(name), parameter.kind, None)
                if own is None:
                    continue
                if name not in found[parameter.kind]:
                    found[parameter.kind][name] = np.full((len(several), len(groups)), own)
                found[parameter.kind][name][:, chosen] = values[:, None]
        return {
            kind: {name: own.reshape(-1) for name, own in by_name.items()}
            for kind, by_name in found.items()
        }

    def __call__(self, x: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """By measurement: v⁺ (nv,) and its derivatives (nv, P), by differences."""
        low = np.maximum(x - COEFFICIENT_STEP, [p.low for p in self._parameters])
        high = np.minimum(x + COEFFICIENT_STEP, [p.high for p in self._parameters])
        several = np.tile(x, (1 + 2 * len(x), 1))
        for i in range(len(x)):
            several[1 + 2 * i, i], several[2 + 2 * i, i] = low[i], high[i]
        solved = self._solved(several)
        for k, own in enumerate(solved[0]):
            slopes = np.array(
                [
                    (solved[2 + 2 * i][k] - solved[1 + 2 * i][k]) / (high[i] - low[i])
                    for i in range(len(x))
                ]
            ).T
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
