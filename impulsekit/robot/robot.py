"""``Robot``: a Pinocchio model with its names, its root and its states by joint name."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import pinocchio as pin

from ..errors import InputError, UnknownNameError
from .building import RobotBuilding
from .reading import RobotReaders
from .stating import RobotStates

if TYPE_CHECKING:
    from .links import Link
    from .loop import Loop
    from .massless import Massless
    from .mjcf_pairs import TouchingPair

__all__ = ["WORLD", "WORLD_LINK", "Robot"]

WORLD = "world"
# What scenes call a moving link that its file calls "world", which is the fixed frame here.
WORLD_LINK = "world_link"


class Robot(RobotReaders, RobotBuilding, RobotStates):
    """A rigid multibody system: a Pinocchio model with the names of its joints, links and frames.

    Created by ``from_urdf``, ``from_example``, ``from_model`` or ``combine``. q and v
    follow Pinocchio: a free-flyer's velocity is in the body frame, linear before
    angular; quaternions are x, y, z, w; a continuous joint has two entries in q.

    Attributes:
        model: the ``pin.Model``, a copy; do not change it.
        name: the robot's name.
        parts: the sources that the robot was made from.

    Example:
        >>> robot = Robot.from_example("panda")
        >>> robot.nv
        9
        >>> robot.configuration(panda_joint2=-0.5)[1]
        np.float64(-0.5)
    """

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What was assumed where the robot's file leaves something open, one sentence each."""
        return tuple(sentence for part in self.parts for sentence in part.assumptions)

    @property
    def loops(self) -> tuple[Loop, ...]:
        """The equality constraints of the robot's file, names as in the robot."""
        return tuple(loop.within(part.prefix) for part in self.parts for loop in part.loops)

    @property
    def touching_pairs(self) -> tuple[TouchingPair, ...]:
        """The pairs of geoms that may touch by the robot's file, and their friction."""
        return tuple(pair.within(part.prefix) for part in self.parts for pair in part.pairs)

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
        from .links import links_of

        return links_of(self.model, self.parts)

    @cached_property
    def mass(self) -> float:
        """The mass of all that moves [kg]."""
        return float(pin.computeTotalMass(self.model))

    @cached_property
    def collision_model(self) -> pin.GeometryModel:
        """The collision geometry, read when first asked for."""
        from .geometry import geometry_of

        return geometry_of(self, pin.GeometryType.COLLISION)

    @cached_property
    def kept_hulls(self) -> dict[int, Any]:
        """By index in ``collision_model``, corners and hulls of the meshes asked for so far."""
        return {}

    @cached_property
    def kept_loaders(self) -> list[Any]:
        """What has read the meshes of ``visual_model``."""
        return []

    @cached_property
    def visual_model(self) -> pin.GeometryModel:
        """The visual geometry, read when first asked for."""
        from .geometry import geometry_of

        return geometry_of(self, pin.GeometryType.VISUAL)

    @cached_property
    def massless_motions(self) -> tuple[Massless, ...]:
        """Each independent motion that moves no mass at any configuration: its joint and link."""
        from .massless import massless_motions

        return massless_motions(self.model)

    @property
    def massless_joints(self) -> tuple[str, ...]:
        """Joints that move no mass, whatever the configuration; empty for most robots.

        While they move freely the mass matrix is singular and no impact is determined: give
        their links an inertia, or lock them with ``JointLock``.

        Example:
            >>> link = "<link name='{}'/>"
            >>> hinge = "<joint name='hinge' type='continuous'><parent link='a'/><child link='b'/>"
            >>> links = link.format("a") + link.format("b")
            >>> text = f"<robot name='r'>{links}{hinge}</joint></robot>"
            >>> Robot.from_urdf(text).massless_joints
            ('hinge',)
        """
        return tuple(dict.fromkeys(motion.joint for motion in self.massless_motions))

    def frame_id(self, name: str, where: str = "") -> int:
        """The index of a frame by name: a link, an extra frame or a joint, in this order.

        A link that moves and is called "world" in its file goes by "world_link".

        Raises:
            UnknownNameError: there is no such frame; ``where`` begins the sentence.
        """
        try:
            return self._frame_ids[name]
        except (KeyError, TypeError):
            known = (WORLD, *self.frame_names)
            raise UnknownNameError.among("frame", str(name), known, where) from None

    def joint_id(self, name: str, where: str = "") -> int:
        """The index of a moving joint by name.

        Raises:
            UnknownNameError: there is no such joint; ``where`` begins the sentence.
        """
        try:
            return self._joint_ids[name]
        except (KeyError, TypeError):
            if isinstance(name, str) and self.has_fixed_joint(name):
                place = f"{where}: " if where else ""
                raise InputError(f'{place}joint "{name}" is fixed, it has no motion') from None
            raise UnknownNameError.among("joint", str(name), self.joint_names, where) from None

    def has_fixed_joint(self, name: str) -> bool:
        """Whether a joint of this name holds two links together without any motion."""
        frame_id = self._frame_ids.get(name, 0)
        return frame_id > 0 and self.model.frames[frame_id].type == pin.FrameType.FIXED_JOINT

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
