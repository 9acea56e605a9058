"""``Program``: a scene as the kernels take it, made once for all states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..impact.plan import is_always_regular
from ..impact.reach import branch_of, touched_joints
from ..scene import AppliedImpulse, Law, Scene
from .kernels import layout
from .rows import NoKernelError, RowMaker, RowTables, row_tables
from .tree import KINDS, Tree, tree_of

__all__ = ["BatchPlan", "Program", "compiled"]


@dataclass(frozen=True)
class BatchPlan:
    """How a batch is solved.

    Attributes:
        kernel: whether compiled kernels do it; False: the solver of single states, row by
            row, in threads of its own where there are several.
        rows: how many rows of constraints and contacts a state has.
        why: a sentence for each choice.
    """

    kernel: bool
    rows: int
    why: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Program:
    """The tables of a scene; see ``kernels.block.solve_blocks`` for the tuples.

    Attributes:
        columns: of each known impulse by entry name: first column and how many.
        given: (columns,) the impulses of the scene itself.
        restitution, friction: (contacts,) those of the scene itself.
    """

    tree: Tree
    sizes: tuple[int, ...]
    tables: tuple[np.ndarray, ...]
    sets: tuple[np.ndarray, ...]
    known: tuple[np.ndarray, ...]
    rows: tuple[np.ndarray, ...]
    held: tuple[np.ndarray, ...]
    contacts: tuple[np.ndarray, ...]
    columns: dict[str, tuple[int, int]]
    given: np.ndarray
    restitution: np.ndarray
    friction: np.ndarray


def compiled(scene: Scene, *, frictional: bool) -> tuple[Program | None, BatchPlan]:
    """The program of a scene, or None where the kernels do not know how, and the plan.

    Args:
        frictional: whether frictions are given that may be more than 0 where the scene's are 0.
    """
    try:
        program = _program(scene, frictional)
    except NoKernelError as reason:
        return None, BatchPlan(False, 0, (f"state by state: {reason}",))
    count = len(program.rows[2]) - 1
    why = [
        f"kernel: articulated bodies over {program.tree.bodies} joints, "
        f"{scene.robot.model.njoints - 1 - program.tree.bodies} left out"
    ]
    if count:
        why.append(f"{count} rows of constraints and contacts, Delassus matrix by response")
    return program, BatchPlan(True, count, tuple(why))


def _program(scene: Scene, frictional: bool) -> Program:
    robot, model = scene.robot, scene.robot.model
    if scene.contacts and scene.law != Law():
        raise NoKernelError("a law of contact other than Law()")
    unknown = {joint.shortname() for joint in list(model.joints)[1:]} - KINDS.keys()
    if unknown:
        raise NoKernelError(f"joints of the kind {', '.join(sorted(unknown))}")
    branches = {branch_of(model, joint_id) for joint_id in touched_joints(scene)} - {0}
    joints = [j for j in range(1, model.njoints) if branch_of(model, j) in branches]
    if not joints:
        raise NoKernelError("nothing acts")
    if not is_always_regular(model):
        raise NoKernelError("joints without inertia of their own, whose pivots are watched")
    tree = tree_of(model, joints)
    tables = row_tables(scene, tree, frictional=frictional)
    known, given, columns, struck = _known(scene, tree)
    rows, passed = _rows(tree, tables)
    loaded = _mask(tree, struck | passed)
    sets = (
        loaded,
        np.flatnonzero(loaded),
        _mask(tree, struck),
        np.flatnonzero(_mask(tree, struck | passed)),
    )
    sizes = (tree.bodies, tree.nq, tree.nv, robot.nq, robot.nv, len(given))
    return Program(
        tree,
        sizes,
        (tree.ints, tree.floats, tree.dofs, tree.q_index, tree.v_index, _units(model)),
        sets,
        known,
        rows,
        (np.array(tables.target), np.array(tables.keeps, dtype=bool)),
        (
            np.array(tables.contact_ints, dtype=np.int64).ravel(),
            np.concatenate([*tables.contact_floats, np.zeros(0)]),
        ),
        columns,
        given,
        np.array(tables.restitution, dtype=float),
        np.array(tables.friction, dtype=float),
    )


def _known(
    scene: Scene, tree: Tree
) -> tuple[tuple[np.ndarray, ...], np.ndarray, dict[str, tuple[int, int]], set[int]]:
    """Tables of the known impulses, their numbers, whose columns are whose, bodies struck."""
    maker = RowMaker(scene.robot, tree)
    ints: list[int] = []
    floats: list[np.ndarray] = []
    kicks: list[int] = []
    given: list[float] = []
    columns: dict[str, tuple[int, int]] = {}
    struck: set[int] = set()
    for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
        first = len(given)
        if isinstance(entry, AppliedImpulse):
            body, point, axes = maker.site(entry.frame, entry.at)
            ints.extend((body, int(entry.axes == "local"), first))
            floats.extend((point, axes.ravel()))
            given.extend((*entry.linear, *entry.angular))
            struck.add(body)
        else:
            start, size = maker.dof(entry.joint)
            for k in range(size):
                kicks.extend((start + k, first + k))
            given.extend(entry.impulse)
            struck.add(_body_of_dof(tree, start))
        columns[name] = (first, len(given) - first)
    tables = (
        np.array(ints, dtype=np.int64),
        np.concatenate([*floats, np.zeros(0)]),
        np.array(kicks, dtype=np.int64),
    )
    return tables, np.array(given, dtype=float), columns, struck


def _rows(tree: Tree, tables: RowTables) -> tuple[tuple[np.ndarray, ...], set[int]]:
    """The tables of rows, and the bodies they act on."""
    ints: list[int] = []
    floats: list[np.ndarray] = []
    first = [0]
    masks, dof_masks = [], []
    passed: set[int] = set()
    body_of_dof = [_body_of_dof(tree, dof) for dof in range(tree.nv)]
    for terms in tables.terms:
        own = set()
        for numbers, values in terms:
            ints.extend(numbers)
            floats.append(values)
            kind, body, _, dof = numbers
            own.add(body_of_dof[dof] if kind == layout.ALONG_DOF else body)
        first.append(first[-1] + len(terms))
        mask = _mask(tree, own)
        masks.append(mask)
        dof_masks.append(mask[body_of_dof])
        passed |= own
    reach, reach_first = _lists(masks)
    dofs, dof_first = _lists(dof_masks)
    return (
        np.array(ints, dtype=np.int64),
        np.concatenate([*floats, np.zeros(0)]),
        np.array(first, dtype=np.int64),
        reach,
        reach_first,
        np.array(masks, dtype=bool).ravel(),
        dofs,
        dof_first,
        np.array(dof_masks, dtype=bool).ravel(),
    ), passed


def _lists(masks: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The true entries of all masks, one list after the other, and where each begins."""
    lists = [np.flatnonzero(mask) for mask in masks]
    first = np.cumsum([0, *(len(one) for one in lists)])
    return np.concatenate([*lists, np.zeros(0, dtype=np.int64)]).astype(np.int64), first


def _mask(tree: Tree, bodies: set[int]) -> np.ndarray:
    """(bodies + 1,) True for those bodies and all between them and the world."""
    mask = np.zeros(tree.bodies + 1, dtype=bool)
    for body in bodies:
        mask[tree.path(body)] = True
    return mask


def _body_of_dof(tree: Tree, dof: int) -> int:
    table = tree.ints.reshape(-1, layout.BODY_INTS)
    return int(np.flatnonzero((table[:, 3] <= dof) & (dof < table[:, 3] + table[:, 4]))[0])


def _units(model: Any) -> np.ndarray:
    """(2k,) where unit vectors stand in q, and how long they are."""
    found: list[int] = []
    for joint in list(model.joints)[1:]:
        size = {layout.CIRCLE: 2, layout.PLANAR: 2, layout.QUATERNION: 4, layout.FREE: 4}.get(
            KINDS[joint.shortname()], 0
        )
        if size:
            found.extend((joint.idx_q + joint.nq - size, size))
    return np.array(found, dtype=np.int64)
