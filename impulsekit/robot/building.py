"""Robots out of robots: payloads, locked joints, rotors, a ground."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from .stating import RobotStates

if TYPE_CHECKING:
    from typing import Self

    from numpy.typing import ArrayLike

__all__ = ["RobotBuilding"]


class RobotBuilding(RobotStates):
    """What is built on a robot; none of it changes the robot itself."""

    def with_body(
        self,
        frame: str,
        *,
        mass: float,
        com: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike | None = None,
        name: str | None = None,
    ) -> Self:
        """A robot with a body welded to a link: a payload, a tool, a sensor.

        The same as another link behind a fixed joint in the URDF. It can be named in scenes,
        is checked, reported and written to scene files.

        Args:
            frame: the link that carries it.
            mass: [kg], 0 or more.
            com: (3,) mass centre in ``frame`` [m].
            inertia: about the mass centre, in the axes of ``frame`` [kg m²]: (3, 3), (6,) as
                ixx, ixy, ixz, iyy, iyz, izz, or (3,) principal moments; None for a point mass.
            name: of the new link; by default the frame's name and "_payload".

        Raises:
            UnknownNameError, InputError: no such link, or the name is taken.
            RangeError, ShapeError, NotFiniteError: of the numbers.

        Example:
            >>> from impulsekit import Robot
            >>> arm = Robot.from_example("panda")
            >>> round(arm.with_body("panda_hand", mass=2.0, com=[0, 0, 0.1]).mass - arm.mass, 9)
            2.0
        """
        from .changes import with_body

        return with_body(self, frame, mass=mass, com=com, inertia=inertia, name=name)

    def with_lock(self, joints: str | Iterable[str] | Mapping[str, float]) -> Self:
        """A robot in which joints are fixed: fewer degrees of freedom, the same links.

        Args:
            joints: names, locked at zero, or a mapping to the values to lock them at [rad, m].

        Raises:
            UnknownNameError: no such joint.
            InputError: the joint has several degrees of freedom, or none.

        Example:
            >>> from impulsekit import Robot
            >>> Robot.from_example("panda").with_lock({"panda_joint4": -1.8}).nv
            8
        """
        from .changes import with_lock

        return with_lock(self, joints)

    def with_armature(
        self, armature: Mapping[str, ArrayLike], *, gear: Mapping[str, float] | None = None
    ) -> Self:
        """A robot with rotor inertia in its joints, which adds to the diagonal of M.

        In geared arms it decides what an impact does: a rotor of inertia J behind a gear of
        ratio r counts as r² J on the joint's side.

        Args:
            armature: by joint, the inertia on the joint's side [kg m², kg]; or the rotor's own
                where ``gear`` names its ratio. One number, or one for each of its speeds.
            gear: by joint, the gear ratio.

        Raises:
            UnknownNameError: no such joint.
            RangeError, ShapeError, NotFiniteError, InputError: of the numbers.

        Example:
            >>> from impulsekit import Robot
            >>> arm = Robot.from_example("ur5").with_armature(
            ...     {"elbow_joint": 6e-5}, gear={"elbow_joint": 101})
            >>> arm.model.armature[2].round(3)
            np.float64(0.612)
        """
        from .changes import with_armature

        return with_armature(self, armature, gear or {})

    def with_ground(
        self, height: float = 0.0, *, normal: ArrayLike = (0.0, 0.0, 1.0), name: str = "ground"
    ) -> Self:
        """A robot with a plane in its world that ``Collision("ball", "ground")`` can name.

        Args:
            height: of the plane along the normal, from the world's origin [m].
            normal: (3,) out of the ground, world axes.
            name: of the collision geometry. In a combined world the ground belongs to the
                first robot, whose name stands before it: "arm/ground".

        Raises:
            InputError, RangeError, ShapeError, NotFiniteError: of the arguments.

        Example:
            >>> from impulsekit import Robot
            >>> robot = Robot.from_example("solo12", root="freeflyer").with_ground(-0.3)
            >>> robot.collision_model.geometryObjects[0].name
            'ground'
        """
        from .changes import with_ground

        return with_ground(self, height, normal, name)
