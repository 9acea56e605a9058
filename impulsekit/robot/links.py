"""Links as their URDF has them, each with its own mass centre.

Pinocchio merges the links behind a fixed joint into one inertia; what a link
does by itself is read from the URDF again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .arrays import lock
from .source import RobotPart
from .urdf import LinkInertial, read_urdf

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
        """Its inertia in the frame of the joint, mass and moments ``factor`` times as large.

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
    """All links of a model, in the order of its frames."""
    inertials: dict[str, LinkInertial] = {}
    for part in parts:
        if part.urdf is not None:
            own = read_urdf(part.urdf).inertials
            inertials.update({part.prefix + name: inertial for name, inertial in own.items()})
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
            inertia = _inertia_in_joint_axes(inertial, frame.placement.rotation)
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
        lock(com, inertia)
        links.append(Link(frame.name, frame_id, joint_id, mass, com, inertia))
    return tuple(links)


def _joints_whose_frames_carry_inertia(model: pin.Model) -> set[int]:
    """The joints whose inertia is the sum of those that their frames hold."""
    mass = np.zeros(model.njoints)
    for frame in model.frames:
        mass[frame.parentJoint] += frame.inertia.mass
    whole = np.array([inertia.mass for inertia in model.inertias])
    return set(np.flatnonzero((mass > 0.0) & (abs(mass - whole) <= SAME_MASS * whole)).tolist())


def _inertia_in_joint_axes(inertial: LinkInertial, link_rotation: np.ndarray) -> np.ndarray:
    """(3, 3) the inertia of a link about its mass centre, in the axes of its joint."""
    ixx, ixy, ixz, iyy, iyz, izz = inertial.moments
    own = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    rotation = link_rotation @ pin.rpy.rpyToMatrix(*inertial.rpy)
    return rotation @ own @ rotation.T
