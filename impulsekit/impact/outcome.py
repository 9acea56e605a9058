"""What a solve found besides Δv: the impulses of constraints and of contacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..rows.contacts import Touch

if TYPE_CHECKING:
    from .contact_law import ContactSolution

__all__ = ["Outcome"]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a solve found besides Δv.

    Attributes:
        constraint_impulses: (m,) λ by row of the bilateral constraints.
        unique: (m,) whether each is determined; None where all are.
        touches: the points at which contacts touched.
        contacts: the impulses there, by the law; None where nothing touched.
        nearly_dependent: whether rows were taken for dependent that are so only nearly.
        residuals: of the momentum, the constraints and the contacts, relative.
    """

    constraint_impulses: np.ndarray
    unique: np.ndarray | None
    touches: tuple[Touch, ...] = ()
    contacts: ContactSolution | None = None
    nearly_dependent: bool = False
    residuals: tuple[float, float, float] = (0.0, 0.0, 0.0)
