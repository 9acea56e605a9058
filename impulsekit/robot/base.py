"""A robot's model and sources, and its joints, links and frames by name."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..errors import InputError, UnknownNameError
from ..formatting import Displayed, one_line
from .source import RobotPart

if TYPE_CHECKING:
    from .masses import Link, Massless
    from .mjcf_shapes import TouchingPair
    from .source import Loop
    from .urdf import Srdf

WORLD = "world"
# What scenes call a moving link that its file calls "world", which is the fixed frame here.
WORLD_LINK = "world_link"


class RobotFrame(NamedTuple):
    """A frame of a robot.

    Attributes:
        frame_id, joint_id: its number in the model, and that of the joint that carries it; 0 for
            the world.
        placement: in the joint.
        rotation, origin: (3, 3), (3,) of the placement.
    """

    frame_id: int
    joint_id: int
    placement: pin.SE3
    rotation: np.ndarray
    origin: np.ndarray

    @classmethod
    def of(cls, frame_id: int, joint_id: int, placement: pin.SE3) -> RobotFrame:
        """A frame at a placement, which is copied."""
        own = pin.SE3(placement)
        return cls(frame_id, joint_id, own, own.rotation, own.translation)


class RobotBase(Displayed):
    """The model, the sources it was made from, and the names of a robot."""

    # ``RobotStates`` reads it on first access.
    collision_model: pin.GeometryModel

    def __init__(
        self, model: pin.Model, parts: Iterable[RobotPart] = (), name: str = "robot"
    ) -> None:
        self.model = model
        self.parts = tuple(parts)
        if not self.parts:
            raise InputError(
                "Robot has no such constructor: Robot.from_file reads a URDF, MJCF or SDF file, "
                "Robot.from_example an example, Robot.from_model a pin.Model"
            )
        self.name = name
        # By name, the frames asked for so far; by index in ``collision_model``, corners and hulls
        # of the meshes; by name, what ``geometry_ids`` found; coal's readers of the meshes of
        # ``visual_model``.
        self._frames: dict[str, RobotFrame] = {}
        self._hulls: dict[int, Any] = {}
        self._geometry_ids: dict[str, tuple[tuple[int, ...], int]] = {}
        self._mesh_loaders: list[Any] = []

    @property
    def nq(self) -> int:
        """The number of entries of a configuration."""
        return self.model.nq

    @property
    def nv(self) -> int:
        """The number of degrees of freedom."""
        return self.model.nv

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """The moving joints, in Pinocchio's order; the root joint is "root_joint"."""
        return tuple(self.model.names)[1:]

    @cached_property
    def frame_names(self) -> tuple[str, ...]:
        """All frames that a scene may name, without the fixed one called "world"."""
        return tuple(name for name in self._frame_ids if name != WORLD)

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """Every link of the URDF, links behind fixed joints too, with its own mass centre."""
        from .masses import links_of

        return links_of(self.model, self.parts)

    @property
    def link_names(self) -> tuple[str, ...]:
        """The names of ``links``, in the order of the model's frames."""
        return tuple(link.name for link in self.links)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Sentences on all that was assumed where the robot's file leaves something open."""
        return tuple(sentence for part in self.parts for sentence in part.assumptions)

    @property
    def loops(self) -> tuple[Loop, ...]:
        """The equality constraints of the robot's file, names as in the robot."""
        return tuple(loop.within(part.prefix) for part in self.parts for loop in part.loops)

    @property
    def touching_pairs(self) -> tuple[TouchingPair, ...]:
        """The pairs of geoms that may touch by the robot's file, and their friction."""
        return tuple(pair.within(part.prefix) for part in self.parts for pair in part.pairs)

    @cached_property
    def _srdfs(self) -> tuple[tuple[str, Srdf], ...]:
        """The SRDF of each part that has one, behind the part's prefix."""
        from .urdf import read_srdf

        return tuple((part.prefix, read_srdf(part.srdf)) for part in self.parts if part.srdf)

    @property
    def disabled_pairs(self) -> frozenset[frozenset[str]]:
        """The pairs of links whose collisions the robot's SRDF disables."""
        return frozenset(
            frozenset(prefix + name for name in pair)
            for prefix, srdf in self._srdfs
            for pair in srdf.disabled
        )

    @cached_property
    def mass(self) -> float:
        """The mass of all that moves [kg]."""
        return float(pin.computeTotalMass(self.model))

    @cached_property
    def massless_motions(self) -> tuple[Massless, ...]:
        """Each independent motion that moves no mass at any configuration: its joint and link."""
        from .masses import massless_motions

        return massless_motions(self.model)

    @cached_property
    def is_always_regular(self) -> bool:
        """True where every joint moves inertia of its own, so that M is regular everywhere.

        Joints that borrow inertia from what hangs on them are not decided so: see
        ``massless_joints``.
        """
        from .masses import is_always_regular

        return is_always_regular(self.model)

    @property
    def massless_joints(self) -> tuple[str, ...]:
        """Joints that move no mass, whatever the configuration; empty for most robots.

        While they move freely the mass matrix is singular and no impact is determined: give
        their links an inertia, or lock them with ``JointLock``.

        Example:
            >>> from impulsekit import Robot
            >>> link = "<link name='{}'/>"
            >>> hinge = "<joint name='hinge' type='continuous'><parent link='a'/><child link='b'/>"
            >>> links = link.format("a") + link.format("b")
            >>> text = f"<robot name='r'>{links}{hinge}</joint></robot>"
            >>> Robot.from_urdf(text).massless_joints
            ('hinge',)
        """
        return tuple(dict.fromkeys(motion.joint for motion in self.massless_motions))

    def frame_id(self, name: str, where: str = "") -> int:
        """Return the index of a frame by name: a link, an extra frame or a joint, in this order.

        A link that moves and is called "world" in its file goes by "world_link".

        Raises:
            UnknownNameError: the robot has no such frame; ``where`` begins the sentence.
        """
        try:
            return self._frame_ids[name]
        except (KeyError, TypeError):
            known = (WORLD, *self.frame_names)
            raise UnknownNameError.among("frame", str(name), known, where) from None

    def frame(self, name: str, where: str = "") -> RobotFrame:
        """Return a frame by name, as ``frame_id``: its numbers and its place in its joint.

        Raises:
            UnknownNameError: the robot has no such frame; ``where`` begins the sentence.

        Example:
            >>> from impulsekit import Robot
            >>> hand = Robot.from_example("panda").frame("panda_hand")
            >>> hand.joint_id, hand.origin.round(3).tolist()
            (7, [0.0, 0.0, 0.107])
        """
        try:
            return self._frames[name]
        except (KeyError, TypeError):
            frame_id = self.frame_id(name, where)
        frame = self.model.frames[frame_id]
        found = RobotFrame.of(frame_id, frame.parentJoint, frame.placement)
        self._frames[name] = found
        return found

    def joint_id(self, name: str, where: str = "") -> int:
        """Return the index of a moving joint by name.

        Raises:
            UnknownNameError: the robot has no such joint; ``where`` begins the sentence.
        """
        try:
            return self._joint_ids[name]
        except (KeyError, TypeError):
            frame = self._frame_ids.get(name, 0) if isinstance(name, str) else 0
            if frame and self.model.frames[frame].type == pin.FrameType.FIXED_JOINT:
                place = f"{where}: " if where else ""
                raise InputError(f'{place}joint "{name}" is fixed, it has no motion') from None
            raise UnknownNameError.among("joint", str(name), self.joint_names, where) from None

    @cached_property
    def quaternions(self) -> tuple[tuple[str, int], ...]:
        """The free-flyers and ball joints, and where in q the quaternion of each starts."""
        model = self.model
        joints = zip(model.names, model.nqs, model.nvs, model.idx_qs, strict=True)
        return tuple(
            (name, first + nq - 4) for name, nq, nv, first in joints if nq - nv == 1 and nq >= 4
        )

    @cached_property
    def _frame_ids(self) -> dict[str, int]:
        rank = {pin.FrameType.BODY: 0, pin.FrameType.OP_FRAME: 1, pin.FrameType.JOINT: 2}
        frames = sorted(enumerate(self.model.frames), key=lambda item: rank.get(item[1].type, 3))
        ids: dict[str, int] = {WORLD: 0}
        for frame_id, frame in frames:
            if frame_id > 0:
                ids.setdefault(frame.name, frame_id)
        for frame_id, frame in frames:
            if frame.name == WORLD and frame.parentJoint > 0:
                ids.setdefault(WORLD_LINK, frame_id)
        return ids

    @cached_property
    def _joint_ids(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.model.names) if i > 0}

    def __reduce__(self) -> Any:
        # Cached geometry and tables are made again on the other side.
        return type(self), (self.model, self.parts, self.name)

    def __repr__(self) -> str:
        roots = "/".join(dict.fromkeys(part.root for part in self.parts))
        return one_line("Robot", repr(self.name), root=roots, nq=self.model.nq, nv=self.model.nv)
