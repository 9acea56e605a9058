"""Every claim about time, measured in one place.

Run with ``python -m impulsekit.bench.claims [SECTION ...]``.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable, Iterator

from ..errors import UnknownNameError
from .claim import Claim

__all__ = ["SECTIONS", "claims", "main"]

# By title, the file of this folder that measures them by a function ``claims``.
SECTIONS = {
    "known blow": "known_blow",
    "constraints": "constrained",
    "contacts": "contacts",
    "derivatives": "derivatives",
    "batch": "batch",
    "motion": "integrators",
    "whole jobs": "whole_jobs",
}


def claims(sections: Iterable[str] = ()) -> Iterator[tuple[str, Claim]]:
    """Section and claim, of some sections or all.

    Raises:
        UnknownNameError: no such section.
    """
    chosen = list(sections) or list(SECTIONS)
    for section in chosen:
        if section not in SECTIONS:
            raise UnknownNameError.among("section of claims", section, SECTIONS)
    for section in chosen:
        room = importlib.import_module(f".{SECTIONS[section]}", __package__)
        for claim in room.claims():
            yield section, claim


def main(sections: list[str]) -> None:
    """Measure and write the rows."""
    title = ""
    for section, claim in claims(sections):
        if section != title:
            title = section
            sys.stdout.write(f"{section}\n")
        sys.stdout.write(f"  {claim.line()}")


if __name__ == "__main__":
    main(sys.argv[1:])
