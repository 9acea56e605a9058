"""Impacts that have no derivatives of this kind."""

from __future__ import annotations

from ...errors import InputError
from ..result import Impact
from ..status import Status

__all__ = ["has_no_answer", "refuse_what_has_none"]


def refuse_what_has_none(impact: Impact) -> None:
    """Refuse what is not differentiated here.

    Raises:
        InputError: it says what, and what to do instead.
    """
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return
    if has_no_answer(outcome.contacts.status):
        raise InputError(f"derivatives: the impact has no answer. {impact.status.value}")


def has_no_answer(status: Status) -> bool:
    """Whether a status says that the numbers solve nothing."""
    return status in (Status.NO_SOLUTION, Status.NOT_CONVERGED, Status.SEQUENCE_TOO_LONG)
