"""Impacts that have no derivatives of this kind."""

from __future__ import annotations

from ...errors import InputError
from ...scene.coefficients import is_plain
from ...scene.contacts import turns
from ..result import Impact

__all__ = ["refuse_what_has_none"]


def refuse_what_has_none(impact: Impact) -> None:
    """Refuse what is not differentiated here.

    Raises:
        InputError: it says what, and what to do instead.
    """
    if impact.scene.law.restitution == "lzb" and impact.scene.contacts:
        raise InputError(
            'derivatives: not available for restitution="lzb", where contacts part and close '
            "again as waves meet; use finite differences of solve"
        )
    if any(getattr(contact, "adhesion", 0.0) for contact in impact.scene.contacts):
        raise InputError(
            "derivatives: not available for contacts with adhesion; where they hold, use a "
            "PointAnchor or FrameAnchor instead, or finite differences of solve"
        )
    if any(map(turns, impact.scene.contacts)):
        raise InputError(
            "derivatives: not available for contacts with rolling or torsion; use finite "
            "differences of solve"
        )
    if not all(is_plain(getattr(c, "friction", 0.0)) for c in impact.scene.contacts):
        raise InputError(
            "derivatives: not available for friction other than a number; use finite differences "
            "of solve"
        )
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return
    # Others that obey the law as well do not matter here: the derivatives are of the v⁺ shown.
    if not impact.status.obeys_law:
        raise InputError(
            f"derivatives: the impact has no valid solution. {impact.describe_status()}"
        )
