"""``contact_law``: a scene's law and the coefficients of its contacts, as the core takes them."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._core import BySpeed, ContactCoefficients, ContactLaw, Table
from ...errors import InputError
from ...scene import Restitution, RestitutionTable
from ...scene.coefficients import restitution_at, static_friction
from ...scene.functions import call
from ..contact_law import core_friction, core_law

if TYPE_CHECKING:
    from ...scene import Scene

__all__ = ["contact_law"]

_NUMBERS = {
    "tangential": "tangential_restitution",
    **{
        name: name
        for name in (
            "stiffness",
            "stiffness_ratio",
            "tangential_damping",
            "adhesion",
            "rolling",
            "torsion",
        )
    },
}


def contact_law(scene: Scene) -> ContactLaw:
    """Return the law of a scene with the coefficients of its contacts, as the core takes it."""
    contacts = []
    for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True):
        friction = getattr(entry, "friction", 0.0)
        numbers = {own: getattr(entry, of, None) for own, of in _NUMBERS.items()}
        contacts.append(
            ContactCoefficients(
                restitution=_restitution(entry.restitution, f"{name}: restitution"),
                friction=static_friction(friction),
                model=core_friction(friction),
                **{own: value for own, value in numbers.items() if value},
            )
        )
    return ContactLaw(core_law(scene.law), contacts)


def _restitution(value: Any, what: str) -> BySpeed:
    if isinstance(value, Restitution):
        return BySpeed(value=value.value, capture=value.capture_speed)
    if isinstance(value, RestitutionTable):
        return BySpeed(table=Table(list(value.speeds), list(value.values)))
    if callable(value):
        slope = getattr(value, "derivative", None)
        own = partial(_slope_at, slope, what) if callable(slope) else None
        return BySpeed(function=partial(_at, value, what), slope=own)
    return BySpeed(value=float(value))


def _at(value: Any, what: str, speed: float) -> float:
    return restitution_at(value, speed, what)


def _slope_at(slope: Any, what: str, speed: float) -> float:
    found = call(slope, f"{what}: derivative", speed)
    if not isinstance(found, int | float | np.floating) or not math.isfinite(found):
        raise InputError(f"{what}: the derivative of its restitution is {found!r}, no number")
    return float(found)
