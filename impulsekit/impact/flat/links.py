"""``flat_links_of``: a robot's links and what its fixed joints hold, as the core takes them."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..._core import Link, Links, Loads, RigidPart
from ...robot.arrays import lock
from .model import flat_model_of

if TYPE_CHECKING:
    from ...robot import Robot

__all__ = ["FlatLinks", "flat_links_of"]

# Entries of an inertia as the core has them: xx, xy, xz, yy, yz, zz.
_UPPER = np.triu_indices(3)
_ZERO = np.zeros(3)


class FlatLinks:
    """The links of a robot in the core, and the rigid parts that fixed joints and bases carry.

    Attributes:
        joints: names of Pinocchio's joints, of fixed joints, and of the roots of fixed bases.
        rows: where each stands among the core's bodies and, behind these, its rigid parts.
    """

    def __init__(self, core: Links, joints: Sequence[str], rows: Sequence[int]) -> None:
        self.core, self.joints, self.rows = core, joints, np.array(rows, dtype=int)

    def reactions(self, loads: Loads) -> dict[str, np.ndarray]:
        """By joint name, (6,) the wrench that the parent gives the child; see ``Impact``."""
        found = np.concatenate([loads.joints, loads.parts]).reshape(-1, 6)[self.rows]
        lock(found)
        return dict(zip(self.joints, found, strict=True))


def flat_links_of(robot: Robot) -> FlatLinks:
    """The links of a robot in the core, made once."""
    found = _by_robot.get(id(robot))
    if found is None:
        found = _by_robot[id(robot)] = _flat_links(robot)
        weakref.finalize(robot, _by_robot.pop, id(robot), None)
    return found


_by_robot: dict[int, FlatLinks] = {}


class _Parts:
    """What fixed bases carry, and behind these what fixed joints do, in the order of frames.

    Attributes:
        parts, names: of them all.
        bases: how many are bases.
        of_frame, of_joint: the part that a frame belongs to, and that a joint hangs on; −1: none.
    """

    def __init__(self, robot: Robot, bodies: tuple[int, ...]) -> None:
        model, frames = robot.model, list(robot.model.frames)
        self.parts, self.names = list[RigidPart](), list[str]()
        taken = {frame.name for frame in frames}
        fixed = [part for part in robot.parts if part.root == "fixed"]
        self.bases = len(fixed)
        for own in fixed:
            place = _ZERO if own.placement is None else np.array(own.placement)[:3, 3].copy()
            root = own.prefix + "root_joint"
            self.names.append(root if root not in taken else own.prefix + "world_root_joint")
            self.parts.append(RigidPart(origin=place, middle=place))

        def base_of(name: str) -> int:
            own = [i for i, part in enumerate(fixed) if name.startswith(part.prefix)]
            return own[-1] if own else -1

        # Pinocchio has merged what stands behind fixed joints; a URDF tells the links apart.
        from_urdf = all(part.urdf is not None for part in robot.parts)
        self.of_frame = [-1] * len(frames)
        self.of_joint = [
            -1 if above else base_of(name)
            for name, above in zip(model.names, model.parents, strict=True)
        ]
        for i, frame in enumerate(frames[1:], 1):
            joint, holder = frame.parentJoint, self.of_frame[frame.parentFrame]
            if joint != frames[frame.parentFrame].parentJoint:
                if frame.type == pin.FrameType.JOINT and holder >= 0:
                    self.of_joint[joint] = holder
                continue
            holder = base_of(frame.name) if joint == 0 and holder < 0 else holder
            self.of_frame[i] = holder
            if from_urdf and frame.type == pin.FrameType.FIXED_JOINT:
                self.of_frame[i] = len(self.parts)
                self.names.append(frame.name)
                middle = self.parts[holder].middle if joint == 0 and holder >= 0 else _ZERO
                at = {"origin": frame.placement.translation, "middle": middle}
                self.parts.append(RigidPart(body=bodies[joint], holder=holder, **at))


def _flat_links(robot: Robot) -> FlatLinks:
    flat = flat_model_of(robot)
    bodies, own = flat.bodies, _Parts(robot, flat.bodies)
    # What a given model has in the world is no link of it.
    given = tuple(part.prefix for part in robot.parts if part.urdf is None)
    links = [
        Link(
            body=bodies[link.joint_id],
            part=own.of_frame[link.frame_id]
            if link.joint_id or not link.name.startswith(given)
            else -1,
            mass=link.mass, centre=link.com_in_joint, inertia=link.inertia_in_joint_axes[_UPPER],
        )
        for link in robot.links
    ]  # fmt: skip
    # A joint of several hangs on by its first.
    hanging = [-1] * (bodies[-1] + 1)
    for before, part in zip(bodies, own.of_joint[1:], strict=False):
        hanging[before + 1] = part
    order = [*range(own.bases, len(own.parts)), *range(own.bases)]
    return FlatLinks(
        Links(flat.core, links, own.parts, own.of_frame, hanging),
        [*list(robot.model.names)[1:], *[own.names[i] for i in order]],
        [body - 1 for body in bodies[1:]] + [bodies[-1] + i for i in order],
    )
