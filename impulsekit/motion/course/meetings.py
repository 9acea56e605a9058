"""What compiled code is told of the points that rest, and where it notes them."""

from __future__ import annotations

import numpy as np

from ..travel.journey import Hold, Ledger
from .present import Present

__all__ = ["hold_of", "ledger_of"]


def ledger_of(now: Present, steps: int) -> Ledger:
    """Room for so many steps."""
    m = len(now.base)
    return Ledger(
        np.zeros(steps, dtype=np.int64), np.zeros((steps, m), dtype=np.int64), np.zeros((steps, m))
    )


def hold_of(now: Present) -> Hold:
    """What rests now."""
    m, contacts = len(now.base), now.resting.contacts
    n = len(contacts)
    hold = Hold(
        np.array([n]),
        np.zeros(m, dtype=np.int64),
        np.zeros(m),
        np.zeros((m, 3)),
        now.base.copy(),
    )
    if n:
        hold.gaps[:n] = [contact.gap for contact in contacts]
        hold.since[:n] = [contact.since for contact in contacts]
    return hold
