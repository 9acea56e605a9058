"""Impacts as numbers and plain data, and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._core import Feature, FeatureKind
from ...impact.contact_law import ContactSolution
from ...impact.outcome import Outcome, Touch
from ...impact.result import Impact
from ...impact.status import Status
from .impact_scenes import is_soft, scene_of_impact

if TYPE_CHECKING:
    from ...scene import Scene

__all__ = ["impacts_of", "packed_impacts"]

_OUTCOME = ("constraint_impulses", "unique", "residuals")
_TOUCH = ("axes", "jacobian", "position")
_SOLUTION = tuple(
    item.name
    for item in fields(ContactSolution)
    if item.name not in ("status", "residual", "iterations", "tied")
)


def packed_impacts(
    scene: Scene, impacts: Sequence[tuple[float, Impact]]
) -> tuple[list[dict[str, Any]], np.ndarray]:
    """The impacts as data for JSON with shapes in the place of arrays, and their numbers."""
    numbers: list[np.ndarray] = []

    def put(array: Any) -> list[int] | None:
        if array is None:
            return None
        array = np.asarray(array, dtype=float)
        numbers.append(array.ravel())
        return list(array.shape)

    packed = []
    for time, impact in impacts:
        # Only at the start the scene's impulses strike; later ones are of a scene without.
        entry: dict[str, Any] = {
            "time": time,
            "struck": bool(impact.scene.impulses),
            "soft": is_soft(scene, impact.scene),
        }
        entry |= {name: put(getattr(impact, name)) for name in ("q", "v_before", "dv")}
        outcome = impact.outcome
        if outcome is not None:
            entry["outcome"] = {name: put(getattr(outcome, name)) for name in _OUTCOME}
            entry["nearly_dependent"] = bool(outcome.nearly_dependent)
            entry["touches"] = [
                {
                    "entry": int(touch.entry),
                    "joint_ids": [int(i) for i in touch.joint_ids],
                    "frame_ids": [int(i) for i in touch.frame_ids],
                    "gap": None if touch.gap is None else float(touch.gap),
                    **({"turns": int(touch.turns)} if touch.turns >= 0 else {}),
                    **_named(touch.feature),
                    **{name: put(getattr(touch, name)) for name in _TOUCH},
                }
                for touch in outcome.touches
            ]
            solution = outcome.contacts
            if solution is not None:
                entry["contacts"] = {
                    "status": solution.status.name,
                    "residual": float(solution.residual),
                    "iterations": int(solution.iterations),
                    "tied": bool(solution.tied),
                    **{name: put(getattr(solution, name)) for name in _SOLUTION},
                }
        packed.append(entry)
    return packed, np.concatenate([*numbers, np.zeros(0)])


def _named(feature: Feature | None) -> dict[str, Any]:
    if feature is None:
        return {}
    fixed = feature.fixed.tolist()
    own = {"kind": feature.kind.name, "piece": feature.piece, "index": feature.index}
    return {"feature": {**own, "fixed": fixed}}


def _feature_of(data: dict[str, Any]) -> Feature:
    own = {"kind": FeatureKind[data["kind"]], "fixed": np.array(data["fixed"], dtype=float)}
    return Feature(**{**data, **own})


def impacts_of(
    scene: Scene, packed: Sequence[dict[str, Any]], numbers: np.ndarray
) -> tuple[tuple[float, Impact], ...]:
    """The impacts that ``packed_impacts`` wrote.

    Raises:
        ValueError, KeyError, TypeError: something else stands there.
    """
    robot = scene.robot
    place = 0

    def take(shape: Any, *wanted: int | None) -> Any:
        nonlocal place
        if shape is None:
            return None
        if len(shape) != len(wanted) or any(
            type(n) is not int or n < 0 or (w is not None and n != w)
            for n, w in zip(shape, wanted, strict=True)
        ):
            raise ValueError(f"an array of an impact is of shape {shape}")
        size = int(np.prod(shape, dtype=object))
        if place + size > len(numbers):
            raise ValueError("numbers of an impact are missing")
        array = numbers[place : place + size].reshape(shape).copy()
        place += size
        return array

    def index(value: Any, count: int) -> int:
        if type(value) is not int or not 0 <= value < count:
            raise ValueError(f"an index of an impact is {value!r}")
        return value

    def pair(values: Any, count: int) -> tuple[int, int]:
        first, second = values
        return index(first, count), index(second, count)

    found = []
    for entry in packed:
        q = take(entry["q"], robot.nq)
        v, dv = (take(entry[name], robot.nv) for name in ("v_before", "dv"))
        outcome = None
        if "outcome" in entry:
            forces, unique, residuals = (take(entry["outcome"][name], None) for name in _OUTCOME)
            touches = tuple(
                Touch(
                    index(touch["entry"], len(scene.contacts)),
                    take(touch["axes"], 3, 3),
                    pair(touch["joint_ids"], robot.model.njoints),
                    pair(touch["frame_ids"], robot.model.nframes),
                    take(touch["jacobian"], 3, robot.nv),
                    take(touch["position"], 3),
                    None if touch["gap"] is None else float(touch["gap"]),
                    index(touch["turns"], len(entry["touches"])) if "turns" in touch else -1,
                    _feature_of(touch["feature"]) if "feature" in touch else None,
                )
                for touch in entry["touches"]
            )
            solution = None
            if "contacts" in entry:
                own = entry["contacts"]
                n = len(touches)
                arrays = {
                    name: take(
                        own.get(name),
                        n
                        if name in ("unique", "normal_work", "friction_work", "friction")
                        else 3 * n,
                    )
                    for name in _SOLUTION
                }
                if arrays["unique"] is not None:
                    arrays["unique"] = arrays["unique"] != 0.0
                solution = ContactSolution(
                    status=Status[own["status"]],
                    residual=float(own["residual"]),
                    iterations=int(own["iterations"]),
                    tied=bool(own["tied"]),
                    **arrays,
                )
            unique = None if unique is None else unique != 0.0
            left = (0.0, 0.0, 0.0) if residuals is None else tuple(residuals.tolist())
            nearly = entry.get("nearly_dependent") is True
            outcome = Outcome(forces, unique, touches, solution, nearly, left)
        time, own = float(entry["time"]), scene
        if entry["struck"] is not True:
            own = scene_of_impact(scene, time, soft=entry.get("soft") is True)
        found.append((time, Impact(own, q, v, dv, outcome)))
    return tuple(found)
