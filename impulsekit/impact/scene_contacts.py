"""The contacts of a scene under its law: rows, and coefficients as the core has them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..rows.contacts import ContactRows, Touch, ellipse_axis
from ..rows.reach import ReachedModel
from ..scene import Scene
from ..scene.coefficients import is_plain, restitution_at, static_friction
from ..scene.contacts import turns
from .contact_law import FrictionModel, friction_models

__all__ = ["SceneContacts"]


class SceneContacts:
    """The contacts of a scene.

    Attributes:
        rows: of the contacts.
    """

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        self.rows = ContactRows(scene, reached)
        entries = scene.contacts
        self._restitution = [entry.restitution for entry in entries]
        self._varying = any(callable(e) for e in self._restitution)
        self._names = scene.entry_names("contacts")
        models = [getattr(entry, "friction", 0.0) for entry in entries]
        self._models = None if all(map(is_plain, models)) else models

        def numbers(name: str) -> np.ndarray:
            return np.array([getattr(entry, name, 0.0) or 0.0 for entry in entries], dtype=float)

        self._friction = np.array([static_friction(model) for model in models], dtype=float)
        self._tangential = numbers("tangential_restitution")
        self._stiffness = numbers("stiffness") if scene.law.restitution == "lzb" else None
        adhesion = numbers("adhesion")
        self._adhesion = adhesion if adhesion.any() else None
        resists = np.array([numbers("rolling"), numbers("torsion")])
        self._resists = resists if any(map(turns, entries)) else None
        self._fixed = None if self._varying else np.array(self._restitution, dtype=float)
        # Nearly always each contact touches at one point.
        self._each_once = list(range(len(entries)))
        self._once = (
            self._fixed, self._friction, self._tangential, self._stiffness, self._adhesion,
            None, None, None,
        )  # fmt: skip

    def coefficients(
        self, touches: list[Touch], jacobian: np.ndarray, v: np.ndarray
    ) -> tuple[tuple[Any, ...], list[FrictionModel]]:
        """Return the coefficients of the touching points, and friction that is more than numbers.

        Args:
            touches: points, and after them the turning of those that resist it.
            jacobian: (3 touches, nv) their rows. v: (nv,) v⁻.
        """
        points = [touch.entry for touch in touches if touch.turns < 0]
        models: list[FrictionModel] = []
        if self._models is not None:
            own = [touch for touch in touches if touch.turns < 0]
            chosen = [self._models[touch.entry] for touch in own]
            axes = [ellipse_axis(model, touch) for model, touch in zip(chosen, own, strict=True)]
            models = friction_models(chosen, axes)
        if points == self._each_once and self._fixed is not None and self._resists is None:
            return self._once, models
        turning: tuple[Any, ...] = (None, None, None)
        if self._resists is not None:
            turned = [touch for touch in touches if touch.turns >= 0]
            rolling, torsion = self._resists[:, [touch.entry for touch in turned]]
            of = np.array([touch.turns for touch in turned], dtype=np.int32)
            turning = (of, np.ascontiguousarray(rolling), np.ascontiguousarray(torsion))
        restitution = (
            self._varied(points, jacobian, v) if self._fixed is None else self._fixed[points]
        )
        stiffness, adhesion = self._stiffness, self._adhesion
        return (
            restitution, self._friction[points], self._tangential[points],
            None if stiffness is None else stiffness[points],
            None if adhesion is None else adhesion[points],
            *turning,
        ), models  # fmt: skip

    def _varied(self, points: list[int], jacobian: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(n,) e at the approach speed of each point."""
        approach = np.maximum(-jacobian[2 : 3 * len(points) : 3].dot(v), 0.0)
        return np.array(
            [
                restitution_at(
                    self._restitution[entry], float(speed), f"{self._names[entry]}: restitution"
                )
                for entry, speed in zip(points, approach, strict=True)
            ]
        )
