"""Impacts that have no derivatives of this kind."""

from __future__ import annotations

from ...errors import InputError
from ...scene.contacts import turns
from ...scene.friction import is_plain
from ..result import Impact

__all__ = ["refuse_what_has_none"]


def refuse_what_has_none(impact: Impact) -> None:
    """Refuse what is not differentiated here.

    Raises:
        InputError: it says what, and what to do instead.
    """
    if impact.scene.law.restitution == "lzb" and impact.scene.contacts:
        raise InputError(
            'derivatives: of impacts under restitution="lzb" there are none here: where waves '
            "meet, contacts part and close again; use differences of solve"
        )
    if any(getattr(contact, "adhesion", 0.0) for contact in impact.scene.contacts):
        raise InputError(
            "derivatives: of contacts with adhesion there are none here; where they hold, use a "
            "PointAnchor or FrameAnchor instead, or differences of solve"
        )
    if any(map(turns, impact.scene.contacts)):
        raise InputError(
            "derivatives: of contacts that resist rolling or spin there are none here; use "
            "differences of solve"
        )
    if not all(is_plain(getattr(c, "friction", 0.0)) for c in impact.scene.contacts):
        raise InputError(
            "derivatives: of friction that is no number there are none here; use differences of "
            "solve"
        )
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return
    if not impact.status.obeys_law:
        raise InputError(
            f"derivatives: the impact has no valid solution. {impact.describe_status()}"
        )
