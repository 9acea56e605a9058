"""Measured impacts solved at values of the unknowns: v⁺ and its derivatives, each found once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..batch.derivatives import derivatives_batch
from ..batch.solve import solve_batch
from ..errors import InputError
from ..impact.solver import solve_without_warnings
from ..scene import GapConstraint, GapContact, Scene
from ..tolerances import NONZERO
from .parameters import Measurement, Parameter, changed_scene, scene_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# Step of central differences [of a parameter's scale]: truncation and rounding 1e-10 of the speed.
PARAMETER_STEP = 1e-5
# Derivatives below this share of the largest speed are rounding of differences.
NO_SLOPE = 1e-8
# Values of the unknowns that are remembered: weights change where a fit has ended, the next one
# begins there, and a step or two may have been tried behind it.
REMEMBERED = 4

# Of a measurement: v⁺ (nv,), its derivatives (nv, P) by the unknowns; (nv, nv) by q and v⁻.
_Solved = tuple[np.ndarray, np.ndarray]
_Slopes = tuple[np.ndarray, np.ndarray]


class SolvedImpacts:
    """Measurements by scene, each solved as one batch at several values of the unknowns.

    Args:
        measurements: all of them.
        parameters: what is fitted.
    """

    def __init__(
        self, measurements: Sequence[Measurement], parameters: Sequence[Parameter]
    ) -> None:
        self._measurements, self._parameters = tuple(measurements), parameters
        # Numbers vary by row; e by speed and inertias need a scene for each value, and group.
        self._varies_scene = any(
            each.speeds or each.kind in ("inertia", "stiffness_ratio") for each in parameters
        )
        parts: dict[Any, list[int]] = {}
        for k, m in enumerate(measurements):
            group = m.group if self._varies_scene else None
            parts.setdefault((id(m.scene), group, tuple(sorted(m.points))), []).append(k)
        self._parts = []
        for (*_, names), rows in parts.items():
            own = [measurements[k] for k in rows]
            points = {name: np.array([m.points[name] for m in own], float) for name in names}
            q = np.array([m.q for m in own], dtype=float)
            v = np.array([m.v_before for m in own], dtype=float)
            groups = np.array([m.group for m in own], dtype=object)
            # Where contacts were measured they touched: their gaps are no news here.
            scene = own[0].scene.replace(gap_bound=np.inf)
            self._parts.append((scene, groups, np.array(rows), q, v, points))
        self._known: dict[bytes, list[_Solved]] = {}

    def v_after(self, x: np.ndarray) -> list[np.ndarray]:
        """Return (M,) of (nv,) v⁺ at values x (P,) of the unknowns.

        Raises:
            InputError: an impact that has no valid solution.
        """
        return self._solved(x[None])[0]

    def at(self, x: np.ndarray) -> list[_Solved]:
        """Return v⁺ (nv,) and its derivatives (nv, P) of each measurement, at values (P,)."""
        key = x.tobytes()
        if key not in self._known:
            # Nothing is remembered of values that are refused.
            self._known[key] = self._with_derivatives(x)
            if len(self._known) > REMEMBERED:
                del self._known[next(iter(self._known))]
        return self._known[key]

    def slopes(self, x: np.ndarray) -> dict[int, _Slopes]:
        """Return ∂v⁺/∂q and ∂v⁺/∂v⁻, each (nv, nv), of measurements with a covariance."""
        found: dict[int, _Slopes] = {}
        for scene, groups, rows, q, v, points in self._parts:
            noisy = [self._measurements[k].covariance is not None for k in rows]
            own, varied = scene, self._coefficients(scene, groups, x[None])
            if self._varies_scene:
                own, varied = changed_scene(scene, self._parameters, x, groups[0]), {}
            if not any(noisy):
                continue
            if has_functions(scene):
                scenes: dict[Any, Scene] = {}
                for k in rows[noisy].tolist():
                    m = self._measurements[k]
                    each = scene_of(m, self._parameters, x, scenes)
                    found[k] = slopes_by_differences(each, m.q, m.v_before)
                continue
            given: dict[str, Any] = {kind: each for kind, each in varied.items() if each}
            if points:
                given["points"] = points
            batch = derivatives_batch(own, q, v, **given)
            by_q, by_v = batch["v_after", "q"], batch["v_after", "v"]
            found |= {int(k): (by_q[i], by_v[i]) for i, k in enumerate(rows) if noisy[i]}
        return found

    def _with_derivatives(self, x: np.ndarray) -> list[_Solved]:
        scales = np.array([each.scale for each in self._parameters])
        low = np.maximum(x - PARAMETER_STEP * scales, [each.low for each in self._parameters])
        high = np.minimum(x + PARAMETER_STEP * scales, [each.high for each in self._parameters])
        several = np.tile(x, (1 + 2 * len(x), 1))
        for i in range(len(x)):
            several[1 + 2 * i, i], several[2 + 2 * i, i] = low[i], high[i]
        found = []
        for here, *sides in zip(*self._solved(several), strict=True):
            changes = np.array(sides[1::2]) - np.array(sides[::2])
            slopes = changes.T / (high - low)
            largest = max(float(np.abs(here).max()), NONZERO)
            slopes[np.abs(slopes) * scales < NO_SLOPE * largest] = 0.0
            found.append((here, slopes))
        return found

    def _solved(self, several: np.ndarray) -> list[list[np.ndarray]]:
        """Return v⁺ at each of (K, P) values: K lists of (M,) of (nv,)."""
        found = [[np.empty(0)] * len(self._measurements) for _ in several]
        for scene, groups, rows, q, v, points in self._parts:
            if self._varies_scene:
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
        """Return, by kind and contact, (K · rows,) coefficients at each of (K, P) values."""
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


# Step of central differences [m, rad, m/s, rad/s]: truncation 1e-10 of the speeds, and rounding
# 1e-10, or 1e-7 where gradients are differences of gaps themselves.
STEP = 1e-5
# What touches is held to touch at all states of the differences: gaps are less by this [m, rad],
# more than the fastest gap changes in a step.
HELD_TOUCHING = 1.0


def has_functions(scene: Scene) -> bool:
    """Return whether rows of a scene are functions of q, without second derivatives."""
    entries = (*scene.contacts, *scene.constraints)
    return any(isinstance(entry, GapContact | GapConstraint) for entry in entries)


@dataclass(frozen=True)
class _Lowered:
    """A gap that is less by ``HELD_TOUCHING``: its gradient, and so every impact, is the same."""

    gap: Callable[[Any], Any]

    def __call__(self, q: np.ndarray) -> Any:
        return np.asarray(self.gap(q), dtype=float) - HELD_TOUCHING


def slopes_by_differences(
    scene: Scene, q: ArrayLike, v: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Return ∂v⁺/∂q on its tangent and ∂v⁺/∂v⁻, each (nv, nv); what touches at q goes on touching.

    By central differences, which lie between both sides where the mode changes at (q, v).
    """
    place, speed = np.array(q, dtype=float), np.array(v, dtype=float)
    touching = {c.name for c in solve_without_warnings(scene, q, v).contacts if c.touching}
    contacts = [
        replace(entry, gap=_Lowered(entry.gap))
        if isinstance(entry, GapContact) and name in touching
        else entry
        for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True)
    ]
    held, model = replace(scene, contacts=contacts), scene.robot.model

    def after(way: np.ndarray, faster: np.ndarray) -> np.ndarray:
        return solve_without_warnings(
            held, pin.integrate(model, place, way), speed + faster
        ).v_after

    none, steps = np.zeros(len(speed)), STEP * np.eye(len(speed))
    by_q = [(after(step, none) - after(-step, none)) / (2 * STEP) for step in steps]
    by_v = [(after(none, step) - after(none, -step)) / (2 * STEP) for step in steps]
    return np.array(by_q).T, np.array(by_v).T
