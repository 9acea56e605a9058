"""``Robot``: a Pinocchio model with its names, its root and its states by joint name."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import pinocchio as pin

from .changes import RobotBuilding
from .reading import RobotReaders

if TYPE_CHECKING:
    from .mjcf_shapes import TouchingPair
    from .source import Loop


class Robot(RobotReaders, RobotBuilding):
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
    def collision_model(self) -> pin.GeometryModel:
        """The collision geometry, read on first access."""
        from .geometry import geometry_of

        return geometry_of(self, pin.GeometryType.COLLISION)

    @cached_property
    def visual_model(self) -> pin.GeometryModel:
        """The visual geometry, read on first access."""
        from .geometry import geometry_of

        return geometry_of(self, pin.GeometryType.VISUAL)
