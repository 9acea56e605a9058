"""The words of a ``Law`` as those of ``laws.words``."""

from __future__ import annotations

from ...scene.law import ORDERS, RESTITUTIONS, SLIPS, Law

__all__ = ["words_of"]


def words_of(law: Law) -> tuple[int, int, int]:
    """Restitution, slip and order of a law."""
    return (
        RESTITUTIONS.index(law.restitution),
        SLIPS.index(law.slip),
        ORDERS.index(law.order),
    )
