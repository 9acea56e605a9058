"""``Program``: a scene as the kernels take it, made once for all states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..impact.plan import is_always_regular
from ..impact.reach import branch_of, touched_joints
from ..scene import AppliedImpulse, Law, Scene
from .followers import Follower, freed_model
from .kernels import layout
from .masses import link_inertia
from .rows import NoKernelError, RowMaker, RowTables, row_tables
from .tree import KINDS, Tree, tree_of, weights

__all__ = ["BatchPlan", "Program", "compiled"]


@dataclass(frozen=True)
class BatchPlan:
    """How a batch is solved.

    Attributes:
        kernel: whether compiled kernels do it; False: ``solve``, one row after the other,
            as under laws of contact other than the default, with tables of restitution or
            with a ``Collision``. Threads gain nothing there, the workers of a client do.
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
        own_rows: how many rows are not the scene's: those of joints that follow others.
        columns: of each known impulse by entry name: first column and how many.
        given: (columns,) the impulses of the scene itself.
        restitution, friction: (contacts,) those of the scene itself.
    """

    tree: Tree
    sizes: tuple[int, ...]
    tables: tuple[np.ndarray, ...]
    sets: tuple[np.ndarray, ...]
    known: tuple[np.ndarray, ...]
    loads: tuple[np.ndarray, ...]
    rows: tuple[np.ndarray, ...]
    meetings: tuple[np.ndarray, ...]
    held: tuple[np.ndarray, ...]
    contacts: tuple[np.ndarray, ...]
    columns: dict[str, tuple[int, int]]
    given: np.ndarray
    restitution: np.ndarray
    friction: np.ndarray
    own_rows: int

    @property
    def needs_law(self) -> bool:
        """Whether there is more to the rows than one contact on a plane."""
        count = len(self.rows[2]) - 1
        stops = self.contacts[0][2 :: layout.CONTACT_INTS]
        return count > 0 and (len(self.held[0]) > 0 or len(stops) != 1 or stops[0] >= 0)

    def places(self) -> tuple[int, ...]:
        """Where in the work array things begin."""
        tree, rows = self.tree, len(self.rows[2]) - 1
        loads = len(set(self.loads[0][:: layout.LOAD_INTS].tolist()))
        meetings = len(self.meetings[0]) // layout.MEETING_INTS
        terms = len(self.rows[0]) // layout.TERM_INTS
        return layout.places(tree.bodies, tree.nq, tree.nv, rows, loads, meetings, terms)


def compiled(
    scene: Scene, *, frictional: bool, links: Sequence[str] = ()
) -> tuple[Program | None, BatchPlan]:
    """The program of a scene, or None where the kernels do not know how, and the plan.

    Args:
        frictional: whether frictions are given that may be more than 0 where the scene's are 0.
        links: those whose masses vary.
    """
    try:
        program = _program(scene, frictional, links)
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


def _program(scene: Scene, frictional: bool, links: Sequence[str]) -> Program:
    robot = scene.robot
    if scene.contacts and scene.law != Law():
        raise NoKernelError("a law of contact other than Law()")
    try:
        model, followers = freed_model(robot.model)
    except KeyError as kind:
        raise NoKernelError(f"joints of the kind {kind.args[0]}") from None
    unknown = {joint.shortname() for joint in list(model.joints)[1:]} - KINDS.keys()
    if unknown:
        raise NoKernelError(f"joints of the kind {', '.join(sorted(unknown))}")
    branches = {branch_of(model, joint_id) for joint_id in touched_joints(scene)} - {0}
    joints = [
        j
        for j in range(1, model.njoints)
        if (branches and followers) or branch_of(model, j) in branches
    ]
    if not joints:
        raise NoKernelError("nothing acts")
    if not is_always_regular(model):
        raise NoKernelError("joints without inertia of their own, whose pivots are watched")
    tree = tree_of(model, joints, robot.model)
    loads = _loads(scene, tree, links)
    tables = row_tables(scene, tree, frictional=frictional, followers=followers)
    known, given, columns, struck = _known(scene, tree, tables)
    rows, passed = _rows(tree, tables)
    loaded = _mask(tree, struck | passed)
    sets = (
        loaded,
        np.flatnonzero(loaded),
        _mask(tree, struck),
        np.flatnonzero(_mask(tree, struck | passed)),
    )
    is_part = len(set(tree.q_index.tolist())) < robot.nq
    sizes = (
        tree.bodies,
        tree.nq,
        tree.nv,
        robot.nq,
        robot.nv,
        len(given),
        len(links),
        int(is_part),
    )
    return Program(
        tree,
        sizes,
        _tree_tables(tree, robot.model, followers),
        sets,
        known,
        loads,
        rows,
        (
            np.array(tables.meeting_ints, dtype=np.int64).ravel(),
            np.concatenate([*tables.meeting_floats, np.zeros(0)]),
            np.array(tables.ways, dtype=np.int64),
        ),
        (np.array(tables.target), np.array(tables.keeps, dtype=bool)),
        (
            np.array(tables.contact_ints, dtype=np.int64).ravel(),
            np.concatenate([*tables.contact_floats, np.zeros(0)]),
        ),
        columns,
        given,
        np.array(tables.restitution, dtype=float),
        np.array(tables.friction, dtype=float),
        len(followers),
    )


def _tree_tables(tree: Tree, model: Any, followers: Sequence[Follower]) -> tuple[np.ndarray, ...]:
    """The tables of the tree and of what its vectors have to do with the robot's."""
    table = tree.ints.reshape(-1, layout.BODY_INTS)[1:]
    angles = np.zeros(tree.nq, dtype=bool)
    angles[table[table[:, 1] == layout.ANGLE, 2]] = True
    v_out = tree.v_index.copy()
    follow: list[int] = []
    ratios: list[float] = []
    for one in followers:
        entry = int(tree.ints[tree.body(one.joint_id) * layout.BODY_INTS + 2])
        own = tree.first_dof(one.joint_id)
        # What is multiplied may not lose its turns before.
        angles[entry], v_out[own] = False, -1
        follow.extend((entry, own, tree.first_dof(one.leader_id)))
        ratios.extend((one.ratio, one.offset))
    return (
        tree.ints,
        tree.floats,
        tree.dofs,
        tree.q_index,
        tree.v_index,
        v_out,
        angles,
        np.zeros(tree.nv, dtype=bool),
        _units(model),
        np.array(follow, dtype=np.int64),
        np.array(ratios, dtype=float),
    )


def _loads(scene: Scene, tree: Tree, links: Sequence[str]) -> tuple[np.ndarray, ...]:
    """Tables of the links whose masses vary; their bodies are marked in those of the tree."""
    ints: list[int] = []
    floats: list[np.ndarray] = []
    table = tree.ints.reshape(-1, layout.BODY_INTS)
    count = 0
    for column, name in enumerate(links):
        joint_id, inertia = link_inertia(scene.robot, name)
        if joint_id not in tree.joint_ids:
            continue
        body = tree.body(joint_id)
        if table[body, 7] < 0:
            table[body, 7] = count
            count += 1
        ints.extend((int(table[body, 7]), column))
        floats.append(weights(inertia, tree.turns[body]))
    return np.array(ints, dtype=np.int64), np.concatenate([*floats, np.zeros(0)])


def _known(
    scene: Scene, tree: Tree, tables: RowTables
) -> tuple[tuple[np.ndarray, ...], np.ndarray, dict[str, tuple[int, int]], set[int]]:
    """Tables of the known impulses, their numbers, whose columns are whose, bodies struck."""
    maker = RowMaker(scene.robot, tree, tables)
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
    known = (
        np.array(ints, dtype=np.int64),
        np.concatenate([*floats, np.zeros(0)]),
        np.array(kicks, dtype=np.int64),
    )
    return known, np.array(given, dtype=float), columns, struck


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
            kind, body, _, dof, *_ = numbers
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
        _alike(tables),
        reach,
        reach_first,
        np.array(masks, dtype=bool).ravel(),
        dofs,
        dof_first,
        np.array(dof_masks, dtype=bool).ravel(),
    ), passed


def _alike(tables: RowTables) -> np.ndarray:
    """(rows,) 3 where three rows are forces at one point of one body, then 0, 0; else 1."""
    where: list[Any] = []
    for terms in tables.terms:
        numbers, values = terms[0]
        single = len(terms) == 1 and numbers[0] == layout.FORCE_AT
        where.append((numbers[1], numbers[4], *values[:3].tolist()) if single else None)
    found = np.ones(len(where), dtype=np.int64)
    row = 0
    while row < len(where):
        three = where[row : row + 3]
        if len(three) == 3 and three[0] is not None and three[0] == three[1] == three[2]:
            found[row : row + 3] = 3, 0, 0
            row += 3
        else:
            row += 1
    return found


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
        kind = KINDS.get(joint.shortname(), -1)
        size = {layout.CIRCLE: 2, layout.PLANAR: 2, layout.QUATERNION: 4, layout.FREE: 4}.get(
            kind, 0
        )
        if size:
            found.extend((joint.idx_q + joint.nq - size, size))
    return np.array(found, dtype=np.int64)
