"""All derivatives of an impact against the solve itself.

Run with ``python -m impulsekit.bench.derivatives``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np

from ..impact import solve
from ..impact.derivatives import derivatives
from ..robot import Robot
from ..scene import AppliedImpulse, Contact, FrameAnchor, Scene
from .claim import Claim
from .timing import time_in_turn

__all__ = ["claims", "main"]

SOLE = "left_sole_link"
CORNERS = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]
BOUND = 6.0


def claims() -> Iterator[Claim]:
    """A row for each kind of scene."""
    talos = Robot.from_example("talos", root="freeflyer")
    rng = np.random.default_rng(0)
    q = talos.neutral()
    q[7:] += rng.uniform(-0.1, 0.1, talos.nq - 7)
    v = 0.2 * rng.normal(size=talos.nv)
    v[2] -= 1.0
    blow = AppliedImpulse("arm_left_7_link", linear=(1.0, 0.0, 0.0), at=(0.1, 0.0, 0.0))
    scenes = {
        "Talos, one blow": Scene(talos, [blow]),
        "Talos, a foot that is held": Scene(talos, [blow], [FrameAnchor(SOLE)]),
        "Talos, one frictional contact": Scene(
            talos, contacts=[Contact(SOLE, at=CORNERS[0], friction=0.5)]
        ),
        "Talos, four frictional contacts": Scene(
            talos, contacts=[Contact(SOLE, at=corner, friction=0.5) for corner in CORNERS]
        ),
    }
    for label, scene in scenes.items():
        impact = solve(scene, q, v)
        times = time_in_turn(
            {
                "derivatives": lambda impact=impact: derivatives(impact),  # type: ignore[misc]
                "solve": lambda scene=scene: solve(scene, q, v),  # type: ignore[misc]
            }
        )
        yield Claim.of_ratio(label, times["derivatives"], times["solve"], BOUND)


def main() -> None:
    """Measure and write the rows."""
    for claim in claims():
        sys.stdout.write(claim.line())


if __name__ == "__main__":
    main()
