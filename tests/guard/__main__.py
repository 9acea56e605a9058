"""``python -m tests.guard``: the guard against getting slower, by ratios, never by times.

Solves are timed against bare Pinocchio in turn and held to bounds of about twice what the ratios
are; a ratio that is above is measured again, up to three times in all, for the machine may be
loaded.
"""

from __future__ import annotations

import sys
from functools import partial

from benchmarks import jobs
from benchmarks.claims import ADMM, CRBA, DYNAMICS, SOLVE, OfJob, OfProblem

__all__ = ["GUARDED", "main"]

TRIES = 3
SOLVING = "from impulsekit import Robot, Scene, solve"
GUARDED = (
    OfProblem("known blow", "struck robot", "struck robot 9", SOLVE, CRBA, 3.0),
    OfProblem("known blow", "struck robot", "struck robot 38", SOLVE, CRBA, 2.5),
    OfProblem("constraints", "held robot", "held robot 12", SOLVE, DYNAMICS, 3.5),
    OfProblem("contacts", "foot", "foot that sticks 38", SOLVE, DYNAMICS, 5.5),
    OfProblem("contacts", "feet", "feet 8", SOLVE, ADMM, 0.9),
    OfJob("import", f"{jobs.BARE} / {jobs.PINOCCHIO}", partial(jobs.importing, jobs.BARE), 0.2),
    OfJob("import", f"{SOLVING} / {jobs.PINOCCHIO}", partial(jobs.importing, SOLVING), 2.0),
)


def main() -> int:
    """Write a line for each ratio; 1 if one stays above its bound."""
    kept = True
    for row in GUARDED:
        for _ in range(TRIES):
            (claim,) = row.claims()
            if claim.met:
                break
        sys.stdout.write(claim.line())
        kept = kept and claim.met
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
