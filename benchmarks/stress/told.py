"""What ``solve`` and ``solve_batch`` say of a state, errors included, told alike."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from impulsekit.batch.solve import solve_batch
from impulsekit.errors import ImpulsekitError
from impulsekit.impact import Impact
from impulsekit.laws.status import Status
from impulsekit.scene import Scene

__all__ = ["Told", "told", "told_by_batch"]

SEVERAL = 2


@dataclass(frozen=True)
class Told:
    """An answer.

    Attributes:
        status: name of the status or of the error.
        valid, lawful: whether it is valid, and whether it obeys the law.
        several: whether other answers are told of; where that is asked for.
        after: (nv,) v⁺; None for an error.
        seconds: of the call; of a batch, per state.
    """

    status: str
    valid: bool
    lawful: bool
    several: bool
    after: np.ndarray | None
    seconds: float = 0.0


def told(call: Callable[[], Impact], *, others: bool = False) -> Told:
    """What an impact, or an error of ours, says; ``others``: look for other answers, too."""
    start = time.perf_counter()
    try:
        impact = call()
        status, after = impact.status, np.array(impact.v_after)
        seconds = time.perf_counter() - start
    except ImpulsekitError as error:
        return Told(type(error).__name__, False, False, False, None, time.perf_counter() - start)
    several = others and status.obeys_law and impact.uniqueness.several
    return Told(status.name, impact.is_valid(), status.obeys_law, several, after, seconds)


def told_by_batch(scene: Scene, q: np.ndarray, v: np.ndarray) -> list[Told]:
    """What ``solve_batch`` says of states q (B, nq), v (B, nv)."""
    start = time.perf_counter()
    outputs = ["dv", "contact_impulses", "uniqueness"]
    batch = solve_batch(scene, q, v, outputs=outputs, threads=1)
    seconds = (time.perf_counter() - start) / len(v)
    others = batch.uniqueness
    found = zip(map(Status, batch.status.tolist()), others, v + batch.dv, strict=True)
    return [
        Told(status.name, status.valid, status.obeys_law, int(other) == SEVERAL, after, seconds)
        for status, other, after in found
    ]
