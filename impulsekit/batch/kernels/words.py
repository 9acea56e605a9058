"""The words of a ``Law`` as small numbers: restitution, slip, order."""

from __future__ import annotations

from ...scene.law import ORDERS, RESTITUTIONS, SLIPS, Law

__all__ = ["END", "NEWTON", "PATH", "POISSON", "SEQUENTIAL", "SIMULTANEOUS", "STRONGE", "words_of"]

NEWTON, POISSON, STRONGE = 0, 1, 2
END, PATH = 0, 1
SIMULTANEOUS, SEQUENTIAL = 0, 1


def words_of(law: Law) -> tuple[int, int, int]:
    """Restitution, slip and order of a law."""
    return (
        RESTITUTIONS.index(law.restitution),
        SLIPS.index(law.slip),
        ORDERS.index(law.order),
    )
