"""Impulses of bilateral constraints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..formatting import OneLine
from ..robot.arrays import lock
from ..robot.placing import Posture
from ..scene import Scene

if TYPE_CHECKING:
    from .mechanics import Mechanics
    from .outcome import Outcome

__all__ = ["ConstraintResult", "constraint_results"]


@dataclass(frozen=True, eq=False, repr=False)
class ConstraintResult(OneLine):
    """One constraint after the solve.

    Attributes:
        name: the entry's name.
        rows: the names of its rows, such as "x" or "rz".
        impulse: (rows,) the impulse that the first frame, or the joint, receives
            [N s, N m s].
        unique: False where rows are redundant and only the resultant is determined.
        unique_rows: (rows,) which of its rows are determined all the same.
        velocity_before, velocity_after: (rows,) of the first frame relative to the
            other, or of the joint [m/s, rad/s].
        work: impulse · (velocity_before + velocity_after)/2 [J].
        measure: gives the gap; called when it is first asked for.
    """

    name: str
    rows: tuple[str, ...]
    impulse: np.ndarray
    unique: bool
    unique_rows: tuple[bool, ...]
    velocity_before: np.ndarray
    velocity_after: np.ndarray
    work: float
    measure: Callable[[], float] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "name": self.name,
            "rows": list(self.rows),
            "impulse": self.impulse.tolist(),
            "unique": self.unique,
            "gap": self.gap,
            "velocity_before": self.velocity_before.tolist(),
            "velocity_after": self.velocity_after.tolist(),
            "work": self.work,
        }

    @cached_property
    def gap(self) -> float:
        """The distance between the two points of an anchor in the directions that it holds [m].

        0 where there is nothing to be open: a lock, a coupling, an anchor at whatever point of
        the other frame coincides.
        """
        return self.measure()


def _gap(scene: Scene, q: np.ndarray, index: int) -> float:
    from .gaps import anchor_openings

    return anchor_openings(scene, Posture(scene.robot, q), (index,))[0].gap


def constraint_results(
    mechanics: Mechanics, outcome: Outcome | None, v_before: np.ndarray, v_after: np.ndarray
) -> tuple[ConstraintResult, ...]:
    """The results of a scene's constraints, in their order."""
    scene = mechanics.scene
    if outcome is None or not scene.held:
        return ()
    flat, matrix = mechanics.flat, mechanics.constraint_matrix
    before, after = matrix @ v_before, matrix @ v_after
    results = []
    names = scene.entry_names("held")
    unique = outcome.unique if outcome.unique is not None else np.ones(len(matrix), dtype=bool)
    for i, (name, where) in enumerate(zip(names, flat.slices, strict=True)):
        impulse = outcome.constraint_impulses[where].copy()
        arrays = (impulse, before[where].copy(), after[where].copy())
        lock(*arrays)
        results.append(
            ConstraintResult(
                name=name,
                rows=tuple(row.removeprefix(f"{name}.") for row in flat.names[where]),
                impulse=arrays[0],
                unique=bool(unique[where].all()),
                unique_rows=tuple(unique[where].tolist()),
                velocity_before=arrays[1],
                velocity_after=arrays[2],
                work=float(impulse @ (0.5 * (arrays[1] + arrays[2]))),
                measure=partial(_gap, scene, mechanics.q, i),
            )
        )
    return tuple(results)
