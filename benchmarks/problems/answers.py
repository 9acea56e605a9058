"""``python -m benchmarks.problems.answers``: work out kept answers that are missing or old."""

from __future__ import annotations

import json
import sys
from typing import Any

from .problem import FOLDER, digest, kept, path_of
from .registry import problems

# Integrated motions are not true to more.
DIGITS, DIGITS_OF_MOTIONS = 50, 22


def decimals(answer: Any, duration: float = 0.0) -> list[str]:
    """Numbers of mpmath as decimals of 50 digits, of motions 22."""
    from mpmath import nstr

    return [nstr(number, DIGITS_OF_MOTIONS if duration else DIGITS) for number in answer]


def main(families: list[str]) -> None:
    """Work out the answers that are missing or old, of some families or of all."""
    for problem in problems(families=families):
        derive = getattr(problem.exact, "derive", None)
        if derive is None:
            continue
        of = digest(problem.scene, problem.q, problem.v, problem.duration)
        known = dict(kept(problem.family))
        if known.get(str(problem.size), {}).get("of") == of:
            continue
        known[str(problem.size)] = {"of": of, "answer": decimals(derive(), problem.duration)}
        FOLDER.mkdir(exist_ok=True)
        ordered = {size: known[size] for size in sorted(known, key=int)}
        text = json.dumps(ordered, indent=1) + "\n"
        path_of(problem.family).write_text(text, encoding="utf-8")
        kept.cache_clear()
        sys.stdout.write(f"{problem.name}: worked out\n")


if __name__ == "__main__":
    main(sys.argv[1:])
