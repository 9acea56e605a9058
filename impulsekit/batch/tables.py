"""The tables of a ``Program``: flat arrays out of a scene, its tree and its rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..rows.entries import frame_pair
from ..scene import AppliedImpulse, Scene
from .followers import Follower
from .kernels import layout
from .masses import link_inertia
from .rows import RowMaker, RowTables
from .tree import KINDS, Tree, weights

__all__ = ["in_world", "known_tables", "load_tables", "path_mask", "row_arrays", "tree_tables"]


def tree_tables(tree: Tree, model: Any, followers: Sequence[Follower]) -> tuple[np.ndarray, ...]:
    """The tables of the tree and of what its vectors have to do with the robot's."""
    table = tree.ints.reshape(-1, layout.BODY_INTS)[1:]
    angles = np.zeros(tree.nq, dtype=bool)
    angles[table[np.isin(table[:, 1], (layout.ANGLE, layout.GEARED_ANGLE)), 2]] = True
    # Places of points that vary are no entries of v.
    v_out = np.where(tree.v_index < model.nv, tree.v_index, -1)
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
        tree.armature,
        tree.q_index,
        tree.v_index,
        v_out,
        angles,
        np.zeros(tree.nv, dtype=bool),
        _units(model),
        np.array(follow, dtype=np.int64),
        np.array(ratios, dtype=float),
    )


def load_tables(scene: Scene, tree: Tree, links: Sequence[str]) -> tuple[np.ndarray, ...]:
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


def known_tables(
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
            body, point, axes = maker.site(frame_pair(scene.robot, entry).first)
            ints.extend((body, int(entry.axes == "local"), first))
            floats.extend((point, axes.ravel()))
            given.extend((*entry.linear, *entry.angular))
            struck.add(body)
        else:
            start, size = maker.dof(entry.joint)
            for k in range(size):
                kicks.extend((start + k, first + k))
            given.extend(entry.values)
            struck.add(_body_of_dof(tree, start))
        columns[name] = (first, len(given) - first)
    known = (
        np.array(ints, dtype=np.int64),
        np.concatenate([*floats, np.zeros(0)]),
        np.array(kicks, dtype=np.int64),
    )
    return known, np.array(given, dtype=float), columns, struck


def row_arrays(tree: Tree, tables: RowTables) -> tuple[tuple[np.ndarray, ...], set[int]]:
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
        mask = path_mask(tree, own)
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
        _levers(tree, tables),
    ), passed


def _levers(tree: Tree, tables: RowTables) -> np.ndarray:
    """(rows · nv,) what each degree of freedom moves the terms of each row by at most.

    Levers are the way from joint to joint at rest; nothing cancels, so that rows can be told
    from rounding by it.
    """
    found = np.zeros((len(tables.terms), tree.nv))
    offsets = np.linalg.norm(tree.floats.reshape(-1, layout.BODY_FLOATS)[:, 9:12], axis=1)
    for row, terms in enumerate(tables.terms):
        for (kind, body, _, dof, meeting, _), values in terms:
            if kind == layout.ALONG_DOF:
                found[row, dof] += abs(values[3])
                continue
            arm, size = float(np.linalg.norm(values[:3])), float(np.linalg.norm(values[3:]))
            if meeting >= 0:
                _, _, begin, _, end, _ = tables.meeting_ints[meeting]
                arm = float(np.linalg.norm(tables.meeting_floats[meeting][:3]))
                arm += float(offsets[tables.ways[begin:end]].sum())
            for one in tree.path(body)[::-1]:
                first, count = tree.ints[one * layout.BODY_INTS + 3 : one * layout.BODY_INTS + 5]
                for k in range(first, first + count):
                    turns = tree.dofs[k * layout.DOF_INTS] == 1
                    if kind == layout.COUPLE:
                        found[row, k] += size if turns else 0.0
                    else:
                        found[row, k] += size * arm if turns else size
                arm += float(offsets[one])
    return found.ravel()


def in_world(
    known: tuple[np.ndarray, ...], rows: tuple[np.ndarray, ...], tables: RowTables
) -> set[int]:
    """The bodies that have to do with the world's axes or with those of another body."""
    blows = known[0].reshape(-1, layout.BLOW_INTS)
    terms = rows[0].reshape(-1, layout.TERM_INTS)
    terms = terms[terms[:, 0] != layout.ALONG_DOF]
    own = (terms[:, 1] == terms[:, 2]) & (terms[:, 4:] < 0).all(axis=1)
    found = {*blows[blows[:, 1] == 0, 0].tolist(), *terms[~own, 1:3].ravel().tolist()}
    for first, other, *_ in tables.meeting_ints:
        found |= {first, other}
    return found - {0}


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


def path_mask(tree: Tree, bodies: set[int]) -> np.ndarray:
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
