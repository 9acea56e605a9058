"""An answer with what happened at each contact."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from ..named import Named
from .answer import Answer

if TYPE_CHECKING:
    from .contact_results import ContactResult

__all__ = ["TouchedAnswer"]


class TouchedAnswer(Answer):
    """The result of ``solve``, constraint by constraint and contact by contact."""

    @cached_property
    def contacts(self) -> Named[ContactResult]:
        """The result of each contact of the scene, in their order or by name."""
        from .contact_results import contact_results

        return Named(contact_results(self), "contact")
