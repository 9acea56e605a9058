"""The rows of bilateral constraints: A v⁺ = b, one block of rows per constraint."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import pinocchio as pin

from ..laws.rank_tolerances import EXACT_RANK, RANK_TOLERANCE
from ..robot import Robot
from ..scene import Collision, GapConstraint, GapContact, Scene
from ..scene.constraints import KEPT
from .entries import FramePair, FunctionRows, JointRows, rows_of_entry, vectors_of_rows
from .origin import Places
from .pair import Pair, PointOnFrame, sizes_of_terms
from .reach import ReachedModel, branch_of

__all__ = ["ConstraintRows", "needs_places"]


class _OfPair:
    """The rows of two frames.

    Attributes:
        said: what the entry says.
        pair: it on the model; ``jacobian(data, q)`` is its own.
        faintest: (k,) rows without an entry above this may be zeros but for rounding; 0
            where they cannot be.
    """

    def __init__(self, reached: ReachedModel, said: FramePair) -> None:
        self.said, self.pair = said, Pair(reached, said)
        self.jacobian = self.pair.jacobian
        self._reach = sum(_reach(reached.model, end) for end in self.pair.ends_that_move)
        faintest = np.where(np.array(said.select) < 3, min(self._reach or 1.0, 1.0), 1.0)
        is_free = self.pair.is_free
        self.faintest = np.zeros(len(said.select)) if is_free else 10.0 * RANK_TOLERANCE * faintest

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(k,) the rates of the rows' velocities where no joint accelerates."""
        return self.pair.bias(data)

    def magnitude(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(k, nv) what the rows are differences of; tells a zero from rounding."""
        sizes = sizes_of_terms(*self.pair.ends(data, q), self._reach)
        return sizes[list(self.said.select)]


class _OfJoints:
    """Rows that do not depend on the configuration; attributes and methods as above."""

    pair = None

    def __init__(self, reached: ReachedModel, said: JointRows) -> None:
        self.said = said
        self._rows = said.matrix(reached.model, reached.joint_id)
        self.faintest = np.zeros(len(self._rows))

    def jacobian(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        return self._rows

    def magnitude(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        return np.abs(self._rows)

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.zeros(len(self._rows))


class _OfFunctions:
    """Rows by functions of the configuration; attributes and methods as above."""

    pair = None

    def __init__(self, said: FunctionRows) -> None:
        self.said = said
        self.faintest = np.zeros(len(said.labels))

    def jacobian(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        return self.said.matrix_at(q)

    def magnitude(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        return np.abs(self.said.matrix_at(q))

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return self.said.bias(q, v)


_Block = _OfPair | _OfJoints | _OfFunctions


@dataclass(frozen=True, eq=False)
class ConstraintRows:
    """All bilateral rows of a scene on a model.

    Attributes:
        blocks: the rows of each constraint.
        slices: where each constraint's rows stand.
        names: of each row, such as "constraints[0].x".
        velocity: (m,) the prescribed velocity of each row after the impact.
        kept: (m,) True where the row keeps its velocity instead; None where none does.
        faintest: (m,) of its blocks; None where no row can vanish.
        triples: (m,) a number for each row, the same for the axes of one linear or angular
            velocity.
        prescribed: entries of v that a row each prescribes, as locks do, and these rows; empty
            where there are none.
    """

    model: pin.Model
    blocks: tuple[_Block, ...]
    slices: tuple[slice, ...]
    names: tuple[str, ...]
    velocity: np.ndarray
    kept: np.ndarray | None
    faintest: tuple[float, ...] | None
    triples: tuple[int, ...]
    prescribed: tuple[list[int], list[int]] | tuple[()]

    @classmethod
    def of(
        cls, scene: Scene, reached: ReachedModel, kind: Literal["held", "constraints"] = "held"
    ) -> ConstraintRows:
        """The rows of a scene; frames for their points are added to the reached model.

        Args:
            kind: "held", all that holds in an impact, or "constraints", what holds in a motion.
        """
        blocks: list[_Block] = []
        slices: list[slice] = []
        names: list[str] = []
        velocity: list[float] = []
        kept: list[bool] = []
        prescribed: tuple[list[int], list[int]] = [], []
        for name, entry in zip(scene.entry_names(kind), getattr(scene, kind), strict=True):
            said = rows_of_entry(scene.robot, entry)
            block = _block_of(reached, said)
            count = len(said.labels)
            if isinstance(said, JointRows) and said.whole_joint:
                own = said.matrix(reached.model, reached.joint_id)
                prescribed[0].extend(own.argmax(axis=1).tolist())
                prescribed[1].extend(range(len(names), len(names) + count))
            blocks.append(block)
            slices.append(slice(len(names), len(names) + count))
            names.extend(f"{name}.{label}" for label in said.labels)
            keeps = entry.velocity == KEPT
            after = (
                entry.velocity if isinstance(entry.velocity, tuple) else (entry.velocity,) * count
            )
            velocity.extend((0.0,) * count if keeps else after)
            kept.extend([keeps] * count)
        faintest = np.concatenate([np.zeros(0), *(block.faintest for block in blocks)])
        return cls(
            reached.model,
            tuple(blocks),
            tuple(slices),
            tuple(names),
            np.array(velocity),
            np.array(kept) if any(kept) else None,
            tuple(faintest.tolist()) if faintest.any() else None,
            vectors_of_rows(block.said for block in blocks),
            prescribed if prescribed[0] else (),
        )

    @cached_property
    def _shape(self) -> tuple[int, int]:
        return len(self.names), self.model.nv

    @property
    def count(self) -> int:
        """How many rows there are."""
        return len(self.names)

    def matrix(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(m, nv) A at q; rows that are zero but for rounding are zero."""
        return self.matrix_and_doubt(data, q)[0]

    def matrix_and_doubt(self, data: pin.Data, q: np.ndarray) -> tuple[np.ndarray, bool]:
        """A at q, and whether a row was taken for zero that is more than rounding."""
        doubt = False
        rows = np.empty(self._shape)
        for block, where in zip(self.blocks, self.slices, strict=True):
            rows[where] = block.jacobian(data, q)
        if self.faintest is not None:
            largest = np.maximum.reduce(np.abs(rows), 1)
            # By far most rows are none of these: told apart without arrays.
            for size, faintest in zip(largest.tolist(), self.faintest, strict=True):
                if 0.0 < size <= faintest:
                    doubt = self._clear_faint(rows, largest, data, q)
                    break
        return rows, doubt

    def _clear_faint(
        self, rows: np.ndarray, largest: np.ndarray, data: pin.Data, q: np.ndarray
    ) -> bool:
        """Clear rows that are zero but for rounding; whether one was more than that.

        Args:
            largest: (m,) the largest entry of each row.
        """
        gross = self.magnitude(data, q)
        faint = (largest <= np.array(self.faintest)) & (largest > 0.0)
        faint &= (np.abs(rows) <= RANK_TOLERANCE * gross).all(axis=1)
        doubt = bool((np.abs(rows[faint]) > EXACT_RANK * gross[faint]).any())
        rows[faint] = 0.0
        return doubt

    def magnitude(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(m, nv) the size of the terms that make up A."""
        return np.vstack([block.magnitude(data, q) for block in self.blocks])

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(m,) Ȧ v; ``data`` with accelerations at zero joint acceleration."""
        return np.concatenate([block.bias(data, q, v) for block in self.blocks])

    @cached_property
    def passive(self) -> np.ndarray:
        """(m,) True where a row is brought to rest: nothing outside drives it."""
        still = self.velocity == 0.0
        return still if self.kept is None else still & ~self.kept

    def target(self, velocity_before: np.ndarray) -> np.ndarray:
        """(m,) b, given the rows' velocities A v⁻ before the impact."""
        if self.kept is None:
            return self.velocity
        return np.where(self.kept, velocity_before, self.velocity)


def _block_of(
    reached: ReachedModel, said: FramePair | JointRows | FunctionRows
) -> _OfPair | _OfJoints | _OfFunctions:
    if isinstance(said, FramePair):
        return _OfPair(reached, said)
    return _OfFunctions(said) if isinstance(said, FunctionRows) else _OfJoints(reached, said)


def _reach(model: pin.Model, end: PointOnFrame) -> float:
    """The way from the root of its tree to a point at most [m], displacements left out."""
    reach, joint_id = float(np.linalg.norm(end.placement.translation)), end.joint_id
    while model.parents[joint_id] > 0:
        reach += float(np.linalg.norm(model.jointPlacements[joint_id].translation))
        joint_id = model.parents[joint_id]
    return reach


def needs_places(robot: Robot, scene: Scene) -> Places:
    """Which places in the world the constraints and contacts of a scene depend on."""
    model = robot.model
    needed = Places.NONE
    for entry in (*scene.held, *scene.contacts):
        if isinstance(entry, Collision | GapConstraint | GapContact):
            return Places.IN_WORLD
        said = rows_of_entry(robot, entry)
        # A point of the first end is carried over to the other, if that moves.
        on_line = isinstance(said, FramePair) and said.carrier == "line"
        if not isinstance(said, FramePair) or not (said.coincides or on_line):
            continue
        first, other = (branch_of(model, site.joint_id) for site in (said.first, said.other))
        if first == other:
            continue
        if other == 0:
            # The points of the world that coincide are all alike; a line to one is not.
            if on_line:
                return Places.IN_WORLD
            continue
        if first == 0:
            return Places.IN_WORLD
        needed = Places.TO_EACH_OTHER
    return needed
