"""Impacts that have no derivatives of this kind."""

from __future__ import annotations

from ...errors import InputError
from ..result import Impact

__all__ = ["refuse_what_has_none"]


def refuse_what_has_none(impact: Impact) -> None:
    """Refuse what is not differentiated here.

    Raises:
        InputError: it says what, and what to do instead.
    """
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return
    if not impact.status.obeys_law:
        raise InputError(
            f"derivatives: the impact has no valid solution. {impact.describe_status()}"
        )
