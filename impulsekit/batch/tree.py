"""``Tree``: a robot's joints and inertias as plain tables for the kernels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..motion.tree import bodies, of_model
from .kernels import layout

__all__ = ["KINDS", "Tree", "joined_tree", "part_turns", "tree_of", "weights"]

_OF_KIND = {
    bodies.TURN: layout.ANGLE, bodies.CIRCLE: layout.CIRCLE, bodies.SLIDE: layout.SLIDE,
    bodies.BALL: layout.QUATERNION, bodies.FREE: layout.FREE, bodies.PLANAR: layout.PLANAR,
    bodies.TRANSLATION: layout.TRANSLATION,
}  # fmt: skip
# By Pinocchio's names of joints; what is not here, no kernel knows.
KINDS = {name: _OF_KIND[kind] for name, kind in of_model.KINDS.items()}

# Sines below this are rounding. Axes that differ by less do not say well what is across them.
ROUNDING, SMALLEST_ANGLE = 4e-16, 1e-6

# A moment of inertia about the mass centre, over what the way to the joint adds to it.
POINT = 1e-3

# What turns about z alone, with an armature.
_GEARED = {layout.ANGLE: layout.GEARED_ANGLE, layout.CIRCLE: layout.GEARED_CIRCLE}

_DOFS = {
    layout.ANGLE: ((1, 2),),
    layout.CIRCLE: ((1, 2),),
    layout.GEARED_ANGLE: ((1, 2),),
    layout.GEARED_CIRCLE: ((1, 2),),
    layout.SLIDE: ((0, 2),),
    layout.QUATERNION: ((1, 0), (1, 1), (1, 2)),
    layout.FREE: ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)),
    layout.PLANAR: ((0, 0), (0, 1), (1, 2)),
    layout.TRANSLATION: ((0, 0), (0, 1), (0, 2)),
}


@dataclass(frozen=True, eq=False)
class Tree:
    """The tables of a tree of bodies, numbered from 1; 0 is the world.

    Attributes:
        bodies: how many.
        ints, floats, dofs: the flat tables, see ``kernels.layout``.
        armature: (nv,) what each degree of freedom adds to its own entry of M.
        nq, nv: of the tree's own vectors.
        q_index, v_index: where its entries stand in the robot's q and v.
        joint_ids: (bodies + 1,) the robot's joint behind each body.
        turns: (bodies + 1, 3, 3) from the axes of a body here to those of its joint there.
    """

    bodies: int
    ints: np.ndarray
    floats: np.ndarray
    dofs: np.ndarray
    armature: np.ndarray
    nq: int
    nv: int
    q_index: np.ndarray
    v_index: np.ndarray
    joint_ids: tuple[int, ...]
    turns: np.ndarray

    def body(self, joint_id: int) -> int:
        """The body behind a joint of the robot."""
        return self.joint_ids.index(joint_id)

    def first_dof(self, joint_id: int) -> int:
        """The first degree of freedom of the body behind a joint of the robot."""
        return int(self.ints[self.body(joint_id) * layout.BODY_INTS + 3])

    def parent(self, body: int) -> int:
        """The body that a body hangs on."""
        return int(self.ints[body * layout.BODY_INTS])

    @property
    def has_points(self) -> bool:
        """Whether bodies are so nearly points, away from their joints, that digits are lost."""
        table = self.ints.reshape(-1, layout.BODY_INTS)[1:]
        weights = self.floats.reshape(-1, layout.BODY_FLOATS)[1:, 12:]
        heavy = weights[:, 0] > 0.0
        kinds, weights = table[heavy, 1], weights[heavy]
        mass, x, y = weights[:, :3].T
        about_z = np.isin(kinds, (*_GEARED, *_GEARED.values(), layout.PLANAR))
        away = (x * x + y * y) / mass
        if (weights[about_z, 9] - away[about_z] < POINT * away[about_z]).any():
            return True
        for k in np.flatnonzero(np.isin(kinds, (layout.QUATERNION, layout.FREE))):
            away = (weights[k, 1:4] @ weights[k, 1:4]) / mass[k]
            about = np.zeros((3, 3))
            about[np.triu_indices(3)] = weights[k, 4:]
            about += np.triu(about, 1).T
            about -= away * np.eye(3) - np.outer(weights[k, 1:4], weights[k, 1:4]) / mass[k]
            if np.linalg.eigvalsh(about)[0] < POINT * away:
                return True
        return False

    def path(self, body: int) -> list[int]:
        """From the body at the world to this one."""
        found = []
        while body > 0:
            found.append(body)
            body = self.parent(body)
        return found[::-1]


def tree_of(model: pin.Model, joints: Sequence[int], whole: pin.Model | None = None) -> Tree:
    """The tables for those joints of a model, parents first; whole branches from the world on.

    ``whole``: the model in whose vectors entries are counted, if it is another one.

    Raises:
        KeyError: a joint of a kind that the kernels do not know.
    """
    neutral = pin.neutral(model)
    bodies = len(joints)
    ids = (0, *joints)
    ints = np.zeros((bodies + 1, layout.BODY_INTS), dtype=np.int64)
    floats = np.zeros((bodies + 1, layout.BODY_FLOATS))
    turns = np.zeros((bodies + 1, 3, 3))
    turns[0] = np.eye(3)
    dofs: list[tuple[int, int]] = []
    q_index: list[int] = []
    v_index: list[int] = []
    armature: list[float] = []
    place = {joint_id: body for body, joint_id in enumerate(ids)}
    joint_axes = {i: _axis(model.joints[i], neutral) for i in joints if model.joints[i].nv == 1}
    for body, joint_id in enumerate(ids[1:], start=1):
        joint = model.joints[joint_id]
        kind = KINDS[joint.shortname()]
        own_armature = model.armature[joint.idx_v : joint.idx_v + joint.nv]
        if own_armature.any():
            kind = _GEARED.get(kind, kind)
        parent = place[model.parents[joint_id]]
        turns[body] = _axes(model, joint_id, joint_axes)
        ints[body] = (parent, kind, len(q_index), len(dofs), joint.nv, 0, 0, -1, 0)
        shift_q = shift_v = 0
        place_in = joint
        if whole is not None and joint_id < whole.njoints:
            place_in = whole.joints[joint_id]
        elif whole is not None:
            # Joints that the whole has not stand behind its own.
            first = model.joints[whole.njoints]
            shift_q, shift_v = whole.nq - first.idx_q, whole.nv - first.idx_v
        begin_q, begin_v = place_in.idx_q + shift_q, place_in.idx_v + shift_v
        q_index.extend(range(begin_q, begin_q + joint.nq))
        v_index.extend(range(begin_v, begin_v + joint.nv))
        dofs.extend(_DOFS[kind])
        armature.extend(own_armature.tolist())
        placement = model.jointPlacements[joint_id]
        turn = turns[body]
        floats[body, 12:] = weights(model.inertias[joint_id], turn)
        floats[body, :9] = (turns[parent].T @ placement.rotation @ turn).ravel()
        floats[body, 9:12] = turns[parent].T @ placement.translation
    mark_children(ints)
    part_turns(ints, floats)
    return Tree(
        bodies,
        ints.ravel(),
        floats.ravel(),
        np.array(dofs, dtype=np.int64).reshape(-1, layout.DOF_INTS).ravel(),
        np.array(armature, dtype=float),
        len(q_index),
        len(v_index),
        np.array(q_index, dtype=np.int64),
        np.array(v_index, dtype=np.int64),
        ids,
        turns,
    )


def weights(inertia: pin.Inertia, turn: np.ndarray) -> np.ndarray:
    """(10,) mass, first moment and inertia about the joint, in the axes of a body here."""
    about_joint = turn.T @ inertia.matrix()[3:, 3:] @ turn
    first = turn.T @ (inertia.mass * inertia.lever)
    return np.array([inertia.mass, *first, *about_joint[np.triu_indices(3)]])


def joined_tree(
    parents: np.ndarray,
    kinds: np.ndarray,
    axes: np.ndarray,
    rotations: np.ndarray,
    translations: np.ndarray,
    masses: np.ndarray,
    centres: np.ndarray,
    inertias: np.ndarray,
) -> Tree:
    """The tables for bodies given by arrays; parents are counted from 0, -1 is the world."""
    n = len(parents)
    lengths = {kind: len(dofs) for kind, dofs in _DOFS.items()}
    sizes = np.array([lengths.get(kind, 0) for kind in range(max(lengths) + 1)])[kinds]
    extra = np.isin(kinds, (layout.QUATERNION, layout.FREE, layout.PLANAR))
    ints = np.zeros((n + 1, layout.BODY_INTS), dtype=np.int64)
    ints[1:, 0], ints[1:, 1], ints[1:, 4] = parents + 1, kinds, sizes
    ints[1:, 7] = -1
    ints[1:, 2] = np.cumsum(sizes + extra) - (sizes + extra)
    ints[1:, 3] = np.cumsum(sizes) - sizes
    mark_children(ints)
    turns = np.empty((n + 1, 3, 3))
    turns[:] = np.eye(3)
    distinct, which = np.unique(axes, axis=0, return_inverse=True)
    single = np.array([_to_z(axis) for axis in distinct])[which.reshape(-1)]
    has_axis = np.isin(kinds, (layout.ANGLE, layout.SLIDE))
    turns[1:][has_axis] = single[has_axis]
    above = turns[parents + 1].transpose(0, 2, 1)
    back = turns[1:].transpose(0, 2, 1)
    floats = np.zeros((n + 1, layout.BODY_FLOATS))
    floats[1:, :9] = (above @ rotations @ turns[1:]).reshape(n, 9)
    floats[1:, 9:12] = (above @ translations[:, :, None])[:, :, 0]
    floats[1:, 12] = masses
    floats[1:, 13:16] = masses[:, None] * (back @ centres[:, :, None])[:, :, 0]
    square = (centres**2).sum(axis=1)[:, None, None] * np.eye(3)
    outer = centres[:, :, None] * centres[:, None, :]
    about_joint = back @ (inertias + masses[:, None, None] * (square - outer)) @ turns[1:]
    rows, columns = np.triu_indices(3)
    floats[1:, 16:] = about_joint[:, rows, columns]
    part_turns(ints, floats)
    dofs = np.concatenate([np.array(_DOFS[kind]) for kind in kinds.tolist()])
    nq, nv = int((sizes + extra).sum()), int(sizes.sum())
    index = np.arange(nq), np.arange(nv)
    tables = ints.ravel(), floats.ravel(), dofs.astype(np.int64).ravel(), np.zeros(nv)
    return Tree(n, *tables, nq, nv, *index, tuple(range(n + 1)), turns)


def mark_children(ints: np.ndarray) -> None:
    """Fill in who has children, and which child its parent hears from first."""
    parents = ints[1:, 0]
    ints[parents[parents > 0], 5] = 1
    # Bodies are gone through from the last to the first.
    last, index = np.unique(parents[::-1], return_index=True)
    ints[len(parents) - index[last > 0], 6] = 1


def part_turns(ints: np.ndarray, floats: np.ndarray) -> None:
    """Put Rz(β) Rx(α) Rz(γ) in the place of the rotations of joints that turn about z alone.

    Of each angle cosine and sine; and mark which of the first two are not nothing.
    """
    about_z = np.isin(ints[:, 1], (layout.ANGLE, layout.CIRCLE))
    about_z[0] = False
    f = floats[about_z, :9].reshape(-1, 3, 3)
    x, y, cos_a = f[:, 0, 2], -f[:, 1, 2], f[:, 2, 2]
    sin_a = np.hypot(x, y)
    aligned = sin_a < ROUNDING
    size = np.where(aligned, 1.0, sin_a)
    straight = aligned | (np.abs(x) < ROUNDING)
    cos_b, sin_b = np.where(straight, 1.0, y / size), np.where(straight, 0.0, x / size)
    sin_a = np.where(aligned, 0.0, np.where(straight, y, sin_a))
    cos_a = np.where(aligned, np.sign(cos_a), cos_a)
    cos_c = cos_b * f[:, 0, 0] + sin_b * f[:, 1, 0]
    sin_c = -(cos_b * f[:, 0, 1] + sin_b * f[:, 1, 1])
    none = np.zeros_like(x)
    parts = np.column_stack([cos_b, sin_b, cos_a, sin_a, cos_c, sin_c, none, none, none])
    floats[about_z, :9] = parts
    # A small angle has a cosine of 1.
    about_x, again = (cos_a != 1.0) | (sin_a != 0.0), (cos_b != 1.0) | (sin_b != 0.0)
    ints[about_z, 8] = layout.ABOUT_X * about_x + layout.ABOUT_Z * again


def _axes(model: pin.Model, joint_id: int, joint_axes: dict[int, np.ndarray]) -> np.ndarray:
    """(3, 3) from axes in which the joint's own axis is z to those of the joint.

    x is across the axis of the first joint that hangs on it, as far as the two differ: then
    the one is turned about x alone to become the other.
    """
    if joint_id not in joint_axes:
        return np.eye(3)
    axis = joint_axes[joint_id]
    for child in model.children[joint_id]:
        if child in joint_axes:
            next_axis = model.jointPlacements[child].rotation @ joint_axes[child]
            across = np.cross(axis, next_axis)
            if np.linalg.norm(across) > SMALLEST_ANGLE:
                # Of axes close together the product is not quite across.
                across -= axis * (axis @ across)
                across /= np.linalg.norm(across)
                return np.column_stack([across, np.cross(axis, across), axis])
    return _to_z(axis)


def _axis(joint: pin.JointModel, neutral: np.ndarray) -> np.ndarray:
    """(3,) the axis of a joint that has one."""
    data = joint.createData()
    joint.calc(data, neutral)
    subspace = np.asarray(data.S).reshape(6)
    return subspace[3:] if np.abs(subspace[3:]).max() > 0.5 else subspace[:3]


def _to_z(axis: np.ndarray) -> np.ndarray:
    """(3, 3) from axes in which a unit vector is z."""
    if np.count_nonzero(axis) == 1 and axis.max() == 1.0:
        # The axes in another order: no rounding.
        shift = int(axis.argmax()) + 1
        return np.roll(np.eye(3), shift, axis=0)
    across = np.zeros(3)
    across[np.abs(axis).argmin()] = 1.0
    first = np.cross(across, axis)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])
