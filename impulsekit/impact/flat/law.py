"""``contact_law``: a scene's law and the coefficients of its contacts, as the core takes them."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._core import ContactLaw
from ...errors import InputError
from ...scene import Restitution, RestitutionTable
from ...scene.coefficients import restitution_at, static_friction
from ...scene.functions import call
from ..contact_law import friction_models, law_codes

if TYPE_CHECKING:
    from ...scene import Scene

__all__ = ["contact_law"]

_NUMBERS = "tangential_restitution", "stiffness", "adhesion", "rolling", "torsion"


def contact_law(scene: Scene) -> ContactLaw:
    """Return the law of a scene with the coefficients of its contacts, as the core takes it."""
    law = ContactLaw(*law_codes(scene.law))
    for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True):
        model = getattr(entry, "friction", 0.0)
        law.add(
            _restitution(entry.restitution, f"{name}: restitution"),
            friction_models([model], [None])[0],
            static_friction(model),
            *(getattr(entry, what, 0.0) or 0.0 for what in _NUMBERS),
        )
    return law


def _restitution(value: Any, what: str) -> tuple[Any, ...]:
    """Value, capture speed, speeds and values of a table, a function of the speed, its slope."""
    if isinstance(value, Restitution):
        return value.value, value.capture_speed, [], [], None, None
    if isinstance(value, RestitutionTable):
        return 0.0, 0.0, list(value.speeds), list(value.values), None, None
    if callable(value):
        slope = getattr(value, "derivative", None)
        own = partial(_slope_at, slope, what) if callable(slope) else None
        return 0.0, 0.0, [], [], partial(_at, value, what), own
    return float(value), 0.0, [], [], None, None


def _at(value: Any, what: str, speed: float) -> float:
    return restitution_at(value, speed, what)


def _slope_at(slope: Any, what: str, speed: float) -> float:
    found = call(slope, f"{what}: derivative", speed)
    if not isinstance(found, int | float | np.floating) or not math.isfinite(found):
        raise InputError(f"{what}: the derivative of its restitution is {found!r}, no number")
    return float(found)
