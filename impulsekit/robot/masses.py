"""Links with their masses, the mass matrix, and joints that move no mass.

Pinocchio merges the links behind a fixed joint into one inertia; what a link does by itself was
read from the URDF.

M(q) is singular at every q where some motion leaves all bodies still that have inertia. That
depends on the null spaces of the bodies' inertias and on the joints alone, not on how heavy
anything is. So every inertia is brought to the size of the robot, which leaves a matrix whose
rank is plain at configurations taken at random: what is singular there is so everywhere.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ..tolerances import NONZERO
from .arrays import lock
from .model_checks import check_capacity
from .source import WHOLE, RobotPart


def crba_of(model: pin.Model) -> Callable[[pin.Model, Any, np.ndarray], np.ndarray]:
    """Return the function of (model, data, q) that writes the upper triangle of M to ``data.M``.

    Pinocchio 4.1's ``crba`` in the joints' own axes adds to what its last call left in the columns
    of joints behind one that mimics another; in world axes it does not.
    """
    if not len(model.mimicking_joints):
        return pin.crba
    return _in_world_axes


def _in_world_axes(model: pin.Model, data: Any, q: np.ndarray) -> np.ndarray:
    return pin.crba(model, data, q, pin.Convention.WORLD)


def symmetric(upper: np.ndarray) -> np.ndarray:
    """Return the whole of a symmetric matrix of which Pinocchio filled the upper triangle."""
    return np.where(_below(len(upper)), upper.T, upper)


@functools.cache
def _below(size: int) -> np.ndarray:
    """(size, size) mask of what is below the diagonal."""
    return np.tri(size, k=-1, dtype=bool)


# Eigenvalues of the inertia, its diagonal being 1, below which a motion moves no mass.
WITHOUT_MASS = 1e-9

# A principal moment this far below the largest is that of a line or a point: rounding of
# three moments that differ is some 1e-16.
NO_MOMENT = 1e-14
# Eigenvalues of the matrix of sizes, on a unit diagonal: rounding is 1e-15, and what is
# regular has 1e-6 or more at one of the configurations, long chains of point masses less.
NO_MASS = 1e-11
# Entries of a null vector at rounding level.
NO_PART = 1e-5
TRIALS = 3


@dataclass(frozen=True)
class Massless:
    """A motion that moves no mass.

    Attributes:
        joint: the joint to lock, the outermost of those that take part.
        link: the link without inertia that moves, by its frame's name or its joint's.
        has_mass: whether it has mass all the same, and turns about a line through that.
    """

    joint: str
    link: str
    has_mass: bool = False

    def __str__(self) -> str:
        if self.has_mass:
            return (
                f'joint "{self.joint}" turns link "{self.link}" about an axis about which it has '
                "no moment of inertia: correct its <inertia>, or lock the joint"
            )
        return (
            f'joint "{self.joint}" moves no mass: give link "{self.link}" an <inertial>, or lock '
            "the joint"
        )


def massless_motions(model: pin.Model) -> tuple[Massless, ...]:
    """Return joint and link of each motion without inertia; none where M is regular."""
    if model.nv == 0 or is_always_regular(model):
        return ()
    check_capacity(model)
    sizes = _of_one_size(model)
    data, crba = sizes.createData(), crba_of(sizes)
    rng = np.random.default_rng(0)
    null = np.eye(model.nv)
    there = neutral = pin.neutral(model)
    for _ in range(TRIALS):
        q = pin.integrate(model, neutral, rng.uniform(-1.0, 1.0, model.nv))
        upper = np.triu(crba(sizes, data, q).reshape(model.nv, model.nv))
        found = _null_vectors(upper + np.triu(upper, 1).T)
        if found.shape[1] < null.shape[1]:
            null, there = found, q
        if not found.shape[1]:
            return ()
    return tuple(_massless_motion(model, there, null, dof) for dof in _outermost(null))


def _of_one_size(model: pin.Model) -> pin.Model:
    """The model with inertias of the same null spaces, all of the size of the robot."""
    sizes = pin.Model(model)
    steps = [float(np.linalg.norm(place.translation)) for place in model.jointPlacements]
    levers = [float(np.linalg.norm(body.lever)) for body in model.inertias if body.mass > 0.0]
    length = max([*steps, *levers]) or 1.0
    for joint_id in range(1, model.njoints):
        own = model.inertias[joint_id]
        body = pin.Inertia.Zero()
        if own.mass > 0.0:
            body.mass, body.lever = 1.0, own.lever
        moments, axes = np.linalg.eigh(own.inertia)
        live = np.abs(moments) > NO_MOMENT * np.abs(moments).max()
        # Set, not given to the constructor, which refuses a moment of -1e-17.
        body.inertia = length**2 * (axes * live) @ axes.T
        sizes.inertias[joint_id] = body
    sizes.armature = np.where(model.armature > 0.0, length**2, 0.0)
    return sizes


def _null_vectors(matrix: np.ndarray) -> np.ndarray:
    """(nv, k) what a positive semidefinite matrix takes to zero, largest entries 1."""
    scale = 1.0 / np.sqrt(np.where((diagonal := matrix.diagonal()) > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(matrix * scale * scale[:, None])
    null = scale[:, None] * vectors[:, values < NO_MASS]
    return null / np.abs(null).max(axis=0, initial=NONZERO)


def _outermost(null: np.ndarray) -> list[int]:
    """Degrees of freedom whose locking leaves no null vector, from the tips inwards."""
    left, found = null.copy(), []
    for dof in range(len(null) - 1, -1, -1):
        if left.shape[1] == 0:
            break
        column = int(np.abs(left[dof]).argmax())
        if abs(left[dof, column]) > NO_PART:
            found.append(dof)
            taken = left[:, [column]]
            left = np.delete(left - taken * (left[dof] / taken[dof]), column, axis=1)
    return found


def _massless_motion(model: pin.Model, q: np.ndarray, null: np.ndarray, dof: int) -> Massless:
    """The joint of a degree of freedom and the link that moves in its motion."""
    joint_id = int(np.searchsorted(model.idx_vs[1:], dof, side="right"))
    while model.nvs[joint_id] == 0:
        joint_id -= 1
    # The motion that has this degree of freedom and as little of the others as there is.
    v = null @ np.linalg.pinv(null[[dof]])[:, 0]
    data = model.createData()
    pin.forwardKinematics(model, data, q, v)
    moving = [
        i
        for i in range(1, model.njoints)
        if np.abs(data.v[i].vector).max() > NO_PART and model.inertias[i].mass == 0.0
    ]
    own = joint_id if joint_id in moving or not moving else moving[-1]
    links = [
        frame.name
        for frame in model.frames
        if frame.type == pin.FrameType.BODY and frame.parentJoint == own
    ]
    link = links[-1] if links else model.names[own]
    return Massless(model.names[joint_id], link, bool(model.inertias[own].mass > 0.0))


def is_always_regular(model: pin.Model) -> bool:
    """Return whether every joint moves inertia of its own, so that M is regular everywhere.

    A pivot of M is Sᵀ Yᴬ S with the articulated inertia Yᴬ, which is never below the
    body's own inertia Y, with the armature beside it. Joints whose S depends on q are taken
    as undecided.
    """
    if any(joint.shortname() in _VARYING_SUBSPACE for joint in model.joints):
        return False
    # Numbers at the edge of the range overflow here, and are found undecided.
    with np.errstate(all="ignore"):
        return _moves_own_inertia(model)


def _moves_own_inertia(model: pin.Model) -> bool:
    q = pin.neutral(model)
    behind = [inertia.matrix() for inertia in model.inertias]
    for joint_id in range(model.njoints - 1, 0, -1):
        joint = model.joints[joint_id]
        data = joint.createData()
        joint.calc(data, q)
        subspace = np.asarray(data.S).reshape(6, joint.nv)
        whole = np.diagonal(subspace.T @ behind[joint_id] @ subspace)
        # An armature is inertia of the joint's own, whatever hangs on it.
        armature = model.armature[joint.idx_v : joint.idx_v + joint.nv]
        whole = whole + armature
        if not (np.isfinite(whole) & (whole > 0.0)).all():
            return False
        scale = 1.0 / np.sqrt(whole)
        own = subspace.T @ model.inertias[joint_id].matrix() @ subspace + np.diag(armature)
        if np.linalg.eigvalsh(own * scale * scale[:, None])[0] < WITHOUT_MASS:
            return False
        to_parent = (model.jointPlacements[joint_id] * data.M).toActionMatrixInverse()
        behind[model.parents[joint_id]] += to_parent.T @ behind[joint_id] @ to_parent
    return True


_VARYING_SUBSPACE = frozenset(
    {
        "JointModelComposite",
        "JointModelSphericalZYX",
        "JointModelEllipsoid",
        "JointModelUniversal",
        "JointModelMimic",
    }
)


# Masses that differ by less than this share are the same: sums of a model's masses, rounded.
SAME_MASS = 1e-12


@dataclass(frozen=True, eq=False)
class Link:
    """A link and how it sits on the joint that moves it.

    Attributes:
        name: with the prefix of its part in a combined world.
        frame_id: the frame of the link in the model.
        joint_id: the joint that carries it; 0 for a link fixed to the world.
        mass: [kg]
        com_in_joint: (3,) mass centre in the joint's frame [m], read-only. A link
            without inertia has its frame's origin here.
        inertia_in_joint_axes: (3, 3) about the mass centre [kg m²], read-only.
    """

    name: str
    frame_id: int
    joint_id: int
    mass: float
    com_in_joint: np.ndarray
    inertia_in_joint_axes: np.ndarray

    def spatial_inertia(self, factor: float = 1.0) -> pin.Inertia:
        """Return its inertia in the frame of the joint, mass and moments ``factor`` times.

        Turned into other axes, the moments of a thin or point-like link can have an eigenvalue
        of -1e-22, which Pinocchio's constructor refuses and its attributes take, and be symmetric
        but for rounding.
        """
        inertia = pin.Inertia.Zero()
        inertia.mass = factor * self.mass
        inertia.lever = self.com_in_joint
        moments = self.inertia_in_joint_axes
        inertia.inertia = 0.5 * factor * (moments + moments.T)
        return inertia


def links_of(model: pin.Model, parts: Sequence[RobotPart]) -> tuple[Link, ...]:
    """Return all links of a model, in the order of its frames."""
    inertials = {
        part.prefix + name: inertial for part in parts for name, inertial in part.inertials.items()
    }
    own_inertias = _joints_whose_frames_carry_inertia(model)
    links = []
    seen_joints: set[int] = set()
    for frame_id, frame in enumerate(model.frames):
        if frame.type != pin.FrameType.BODY:
            continue
        joint_id = frame.parentJoint
        inertial = inertials.get(frame.name)
        if inertial is not None:
            mass = inertial.mass
            com = frame.placement.act(np.array(inertial.com))
            turn = frame.placement.rotation @ pin.rpy.rpyToMatrix(*inertial.rpy)
            inertia = turn @ np.array(inertial.moments)[WHOLE] @ turn.T
        elif joint_id in own_inertias:
            mass = float(frame.inertia.mass)
            com = frame.placement.act(np.array(frame.inertia.lever))
            turn = frame.placement.rotation
            inertia = turn @ np.array(frame.inertia.inertia) @ turn.T
        elif joint_id not in seen_joints and joint_id > 0:
            # A given model knows one inertia a joint; the joint's first link stands for it.
            mass = float(model.inertias[joint_id].mass)
            com = np.array(model.inertias[joint_id].lever)
            inertia = np.array(model.inertias[joint_id].inertia)
        else:
            mass = 0.0
            com = np.array(frame.placement.translation)
            inertia = np.zeros((3, 3))
        seen_joints.add(joint_id)
        links.append(Link(frame.name, frame_id, joint_id, mass, com, inertia))
    lock(*[link.com_in_joint for link in links], *[link.inertia_in_joint_axes for link in links])
    return tuple(links)


def _joints_whose_frames_carry_inertia(model: pin.Model) -> set[int]:
    """The joints whose inertia is the sum of those that their frames hold."""
    mass = np.zeros(model.njoints)
    for frame in model.frames:
        mass[frame.parentJoint] += frame.inertia.mass
    whole = np.array([inertia.mass for inertia in model.inertias])
    return set(np.flatnonzero((mass > 0.0) & (abs(mass - whole) <= SAME_MASS * whole)).tolist())
