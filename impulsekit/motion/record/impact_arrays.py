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

_BY_POINT = ("unique", "normal_work", "friction_work", "friction")


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


class _Reader:
    """The numbers of packed impacts, taken one array after the other."""

    def __init__(self, scene: Scene, numbers: np.ndarray) -> None:
        self.scene, self._numbers, self._place = scene, numbers, 0

    def take(self, shape: Any, *expected: int | None) -> Any:
        """Return the next array, of this shape; None where none was written."""
        if shape is None:
            return None
        if len(shape) != len(expected) or any(
            type(n) is not int or n < 0 or (e is not None and n != e)
            for n, e in zip(shape, expected, strict=True)
        ):
            raise ValueError(f"an array of an impact is of shape {shape}")
        end = self._place + int(np.prod(shape, dtype=object))
        if end > len(self._numbers):
            raise ValueError("numbers of an impact are missing")
        array = self._numbers[self._place : end].reshape(shape).copy()
        self._place = end
        return array

    def outcome(self, entry: dict[str, Any]) -> Outcome:
        shapes = entry["outcome"]
        forces, unique, residuals = (self.take(shapes[name], None) for name in _OUTCOME)
        count = len(entry["touches"])
        touches = tuple(self._touch(touch, count) for touch in entry["touches"])
        solution = self._solution(entry["contacts"], count) if "contacts" in entry else None
        unique = None if unique is None else unique != 0.0
        left = (0.0, 0.0, 0.0) if residuals is None else tuple(residuals.tolist())
        return Outcome(
            forces, unique, touches, solution, entry.get("nearly_dependent") is True, left
        )

    def _touch(self, touch: dict[str, Any], count: int) -> Touch:
        robot = self.scene.robot
        return Touch(
            _index(touch["entry"], len(self.scene.contacts)),
            self.take(touch["axes"], 3, 3),
            _pair(touch["joint_ids"], robot.model.njoints),
            _pair(touch["frame_ids"], robot.model.nframes),
            self.take(touch["jacobian"], 3, robot.nv),
            self.take(touch["position"], 3),
            None if touch["gap"] is None else float(touch["gap"]),
            _index(touch["turns"], count) if "turns" in touch else -1,
            _feature_of(touch["feature"]) if "feature" in touch else None,
        )

    def _solution(self, own: dict[str, Any], count: int) -> ContactSolution:
        arrays = {
            name: self.take(own.get(name), count if name in _BY_POINT else 3 * count)
            for name in _SOLUTION
        }
        if arrays["unique"] is not None:
            arrays["unique"] = arrays["unique"] != 0.0
        return ContactSolution(
            status=Status[own["status"]],
            residual=float(own["residual"]),
            iterations=int(own["iterations"]),
            tied=bool(own["tied"]),
            **arrays,
        )


def _index(value: Any, count: int) -> int:
    if type(value) is not int or not 0 <= value < count:
        raise ValueError(f"an index of an impact is {value!r}")
    return value


def _pair(values: Any, count: int) -> tuple[int, int]:
    first, second = values
    return _index(first, count), _index(second, count)


def impacts_of(
    scene: Scene, packed: Sequence[dict[str, Any]], numbers: np.ndarray
) -> tuple[tuple[float, Impact], ...]:
    """The impacts that ``packed_impacts`` wrote.

    Raises:
        ValueError, KeyError, TypeError: something else stands there.
    """
    reader, found = _Reader(scene, numbers), []
    for entry in packed:
        q = reader.take(entry["q"], scene.robot.nq)
        v, dv = (reader.take(entry[name], scene.robot.nv) for name in ("v_before", "dv"))
        outcome = reader.outcome(entry) if "outcome" in entry else None
        time, own = float(entry["time"]), scene
        if entry["struck"] is not True:
            own = scene_of_impact(scene, time, soft=entry.get("soft") is True)
        found.append((time, Impact(own, q, v, dv, outcome)))
    return tuple(found)
