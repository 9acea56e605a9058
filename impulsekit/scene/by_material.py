"""Coefficients of contacts that are left to a table of pairs of materials."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

# Of each coefficient that a table gave: its name, what the user gave, and the table's number.
ByTable = tuple[tuple[str, Any, Any], ...]
# What a contact gives instead of a coefficient that the table of pairs has.
BY_MATERIAL = "material"


def is_by_material(value: Any) -> bool:
    """Return whether a coefficient is left to the table of pairs."""
    return isinstance(value, str) and value == BY_MATERIAL


def asks_for_materials(contact: Any) -> bool:
    """Return whether a contact leaves a coefficient to the table of pairs."""
    given = getattr(contact, "restitution", 0.0), getattr(contact, "friction", 0.0)
    return any(map(is_by_material, given))


def keep_table(contact: Any, by_table: ByTable) -> None:
    """Keep which coefficients of a contact its table of pairs gave: those that are not replaced."""
    kept = tuple(one for one in by_table if getattr(contact, one[0]) == one[2])
    object.__setattr__(contact, "_by_table", kept)


def as_given(contact: Any) -> Any:
    """A contact of a scene as the user gave it, with "material" in place of the pair's numbers."""
    by_table = getattr(contact, "_by_table", ())
    if not by_table:
        return contact
    return replace(contact, _by_table=(), **{name: given for name, given, _ in by_table})
