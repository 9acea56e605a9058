"""``Robot``: a Pinocchio model with its names, its root and its states by joint name."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..display import Displayed, one_line
from ..errors import (
    AssumptionWarning,
    InputError,
    MjcfError,
    UnknownNameError,
    UrdfError,
    a_thing,
    warn_of_assumptions,
    warn_of_setup,
)
from .model_checks import ROOTS, check_depth_first, check_finite, root_joint
from .source import RobotPart

if TYPE_CHECKING:
    from typing import Unpack

    import mujoco
    from numpy.typing import ArrayLike

    from ..scene import Scene
    from ..scene.of_robot import FromFile
    from .links import Link
    from .loop import Loop
    from .massless import Massless
    from .mjcf_pairs import TouchingPair
    from .placing import FrameVelocity, Placement

__all__ = ["WORLD", "WORLD_LINK", "Robot"]

WORLD = "world"
# What scenes call a moving link that its file calls "world", which is the fixed frame here.
WORLD_LINK = "world_link"


class Robot(Displayed):
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

    def __init__(self, model: pin.Model, parts: Iterable[RobotPart], name: str) -> None:
        self.model = model
        self.parts = tuple(parts)
        self.name = name

    @classmethod
    def from_urdf(
        cls,
        path_or_xml: str | os.PathLike[str],
        root: str | pin.JointModel = "fixed",
        *,
        mimic: bool = False,
        package_dirs: Iterable[str | os.PathLike[str]] = (),
    ) -> Robot:
        """A robot from a URDF file or from URDF text (anything that starts with "<").

        Args:
            path_or_xml: the file, or the text itself.
            root: "fixed", "planar" (x, y and rotation about z), "sagittal" (x, z and pitch,
                rotation about y), "freeflyer", or any
                ``pin.JointModel``, between the world and the root link.
            mimic: True lets mimic joints follow their leader; False (Pinocchio's
                default) lets each move on its own.
            package_dirs: folders of packages, for "package://", and of other meshes, needed
                only when geometry is. Meshes are read from these, the URDF's own folder, the
                folder of the package that it is in (one with a package.xml) and
                ROS_PACKAGE_PATH, and from nowhere else.

        Rotor inertia and gear ratio in a <transmission> become the armature of its joint.
        Files as exporters write them are taken where their meaning is clear: an
        ``AssumptionWarning`` lists what was assumed, and so does ``assumptions``.

        Raises:
            UrdfError: it names the file, the element and the fault.

        Example:
            >>> from impulsekit.models import chain_urdf
            >>> Robot.from_urdf(chain_urdf(links=10), root="planar").nv
            12
        """
        from .urdf import read_urdf

        urdf = read_urdf(path_or_xml, mimic=mimic)
        joint, root_name = root_joint(root)
        assumptions, own_root = list(urdf.assumptions), "root_joint"
        if joint is not None and any(own_root == each.name for each in urdf.joints):
            own_root = "world_root_joint"
            assumptions.append(
                f'the robot has a joint "root_joint", so the root joint is named "{own_root}"'
            )
        part = RobotPart(
            urdf.text,
            None if urdf.path is None else os.path.abspath(urdf.path),
            root_name,
            mimic,
            package_dirs=tuple(os.path.abspath(os.fspath(folder)) for folder in package_dirs),
            assumptions=tuple(assumptions),
        )
        warn_of_assumptions(part.label, assumptions)
        arguments = (urdf.plain,) if joint is None else (urdf.plain, joint, own_root)
        try:
            model = pin.buildModelFromXML(*arguments, mimic=mimic)
        except (RuntimeError, ValueError) as error:
            raise UrdfError(f"{part.label}: {error}", source=part.label, element="") from None
        if urdf.rotors:
            armature = np.array(model.armature)
            for name, value in urdf.rotors.items():
                armature[model.joints[model.getJointId(name)].idx_v] += value
            model.armature = armature
        return cls(model, (part,), urdf.name)

    @classmethod
    def from_example(
        cls, name: str, root: str | pin.JointModel = "fixed", *, mimic: bool = False
    ) -> Robot:
        """A robot of the package example-robot-data, by its loader's name or its file's stem.

        No geometry is read. ``impulsekit robots`` lists the names.

        Raises:
            UnknownNameError: it carries the nearest names.
        """
        from .examples import example_path, example_urdf

        path = example_path(name)
        text = example_urdf(name)
        folder = path.parents[len(path.parts) - path.parts.index("example-robot-data") - 2]
        return cls.from_urdf(
            path if text is None else text,
            root,
            mimic=mimic,
            package_dirs=(folder.parent, folder / "robots"),
        )

    @classmethod
    def from_mjcf(
        cls,
        source: str | os.PathLike[str] | mujoco.MjSpec | mujoco.MjModel,
        root: str | None = None,
    ) -> Robot:
        """A robot from MJCF, compiled by MuJoCo (``pip install "impulsekit[mjcf]"``).

        The configuration is MuJoCo's ``qpos`` with quaternions as x, y, z, w instead of
        w, x, y, z; a free joint's linear velocity is in body axes instead of world axes.
        Joint limits, armature, damping and dry friction come along. ``loops`` holds the
        active equality constraints; ``robot.scene()`` makes constraints of them. What has
        no place in the model (tendons, springs, actuators, ...) is in ``assumptions`` by name.

        Args:
            source: a path, MJCF text, a ``mujoco.MjSpec`` or a ``mujoco.MjModel``.
            root: None keeps the joints of the file; "fixed", "planar" or "freeflyer" is what
                joins each tree to the world instead of a free joint, or of none.

        Raises:
            MjcfError: MuJoCo refuses the file, or it holds what a rigid-body model cannot.
            MissingExtraError: the package mujoco is not installed.

        Example:
            >>> ball = "<body><freejoint/><geom size='0.1'/></body>"
            >>> Robot.from_mjcf(f"<mujoco><worldbody>{ball}</worldbody></mujoco>").nv
            6
        """
        from .mjcf import MjcfRobot, read_mjcf

        if root is not None and root not in ROOTS:
            raise UnknownNameError.among("root", str(root), ROOTS)
        mj, path = read_mjcf(source)
        read = MjcfRobot(mj, root)
        part = RobotPart(
            None,
            path,
            root or "as in the file",
            assumptions=tuple(read.assumptions),
            loops=read.loops,
            shapes=read.shapes,
            pairs=read.pairs,
        )
        warn_of_assumptions(path or read.name, read.assumptions)
        return cls(read.model, (part,), read.name)

    @classmethod
    def from_sdf(
        cls,
        source: str | os.PathLike[str],
        root: str | pin.JointModel = "fixed",
        *,
        model: str | None = None,
        package_dirs: Iterable[str | os.PathLike[str]] = (),
    ) -> Robot:
        """A robot from a <model> of SDF, the format of Gazebo.

        The model is written anew as a URDF. Joints to a link that another joint carries, and
        gearboxes, are in ``loops``; ``robot.scene()`` makes constraints of them.

        Args:
            source: a path, or SDF text.
            root: as in ``from_urdf``; "fixed" holds the model's first link where it is.
            model: which model, where the file holds several.
            package_dirs: where "model://" and "package://" are looked up, as in ``from_urdf``.

        Raises:
            MjcfError: the file cannot be read or used; it names the element and the fault.

        Example:
            >>> spin = ("<joint name='spin' type='revolute'><parent>world</parent>"
            ...     "<child>body</child><axis><xyz>0 0 1</xyz></axis></joint>")
            >>> body = "<link name='body'><inertial><mass>1</mass></inertial></link>"
            >>> top = f"<sdf version='1.9'><model name='top'>{body}{spin}</model></sdf>"
            >>> Robot.from_sdf(top).joint_names
            ('spin',)
        """
        from .geometry import folders_of_file
        from .sdf import read_sdf

        read = read_sdf(source, model)
        package_dirs = (*package_dirs, *folders_of_file(read.path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AssumptionWarning)
            try:
                robot = cls.from_urdf(read.urdf, root, package_dirs=package_dirs)
            except UrdfError as error:
                source = read.path or "SDF text"
                words = str(error).replace("URDF text", source).replace("a URDF", "a robot")
                raise MjcfError(words, source=source, element=error.element) from None
        part = robot.parts[0]
        assumptions = (*read.assumptions, *part.assumptions)
        warn_of_assumptions(read.path or part.label, assumptions)
        new = replace(part, assumptions=assumptions, loops=read.loops)
        return cls(robot.model, (new,), robot.name)

    @classmethod
    def from_file(
        cls,
        path: str | os.PathLike[str],
        root: str | None = None,
        *,
        package_dirs: Iterable[str | os.PathLike[str]] = (),
    ) -> Robot:
        """A robot from a URDF, xacro, MJCF or SDF file, told apart by the outermost element.

        Args:
            path: the file.
            root: "fixed", "planar" or "freeflyer"; None for "fixed", or of MJCF for the
                joints of the file.
            package_dirs: as in ``from_urdf``.

        Raises:
            UrdfError, MjcfError: it names the file, the element and the fault.

        Example:
            >>> Robot.from_file("models/four_bar.urdf").nv
            3
        """
        from .any_file import robot_from_file

        return robot_from_file(path, root, package_dirs=package_dirs)

    @classmethod
    def from_description(cls, name: str, root: str | None = None) -> Robot:
        """A robot of the package robot_descriptions, such as "panda_description".

        The package fetches the files by git on first use, and keeps them
        (``pip install "impulsekit[descriptions]"``).

        Raises:
            UnknownNameError: it carries the nearest names.
            MissingExtraError: the package is not installed.
            InputError: its files cannot be fetched.
        """
        from .descriptions import robot_from_description

        return robot_from_description(name, root)

    @classmethod
    def from_model(cls, model: pin.Model) -> Robot:
        """A robot from a ``pin.Model``, which is copied and never changed.

        Pinocchio keeps one inertia a joint: where a model has several links on a
        joint, the first stands for all of them in ``links``. Of the numbers that a model
        has for its joints ``armature`` alone is part of the generalized masses; damping,
        friction, limits and gravity do not enter an impact, and the rotors' own inertias and
        gear ratios count only as far as ``armature`` holds them.

        Raises:
            InputError: it is no ``pin.Model``, its joints are not numbered depth first, for
                which Pinocchio's mass matrix is wrong, or an axis or pitch is not a number.
        """
        if not isinstance(model, pin.Model):
            raise InputError(f"from_model takes a pin.Model, not {a_thing(model)}")
        check_depth_first(model)
        check_finite(model)
        root = model.joints[1].shortname() if model.njoints > 1 else "fixed"
        return cls(pin.Model(model), (RobotPart(None, root=root),), model.name or "robot")

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
        """The geoms that may touch by the robot's file: names, friction, second one fixed."""
        return tuple(
            (part.prefix + first, part.prefix + second, friction, fixed)
            for part in self.parts
            for first, second, friction, fixed in part.pairs
        )

    def scene(self, **entries: Unpack[FromFile]) -> Scene:
        """A scene with the loops, and on request the contacts, of the robot's file.

        The same as ``impulsekit.scene.of_robot.scene_of(robot, ...)``, which see.
        """
        from ..scene.of_robot import scene_of

        return scene_of(self, **entries)

    def with_body(
        self,
        frame: str,
        *,
        mass: float,
        com: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike | None = None,
        name: str | None = None,
    ) -> Robot:
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
            >>> arm = Robot.from_example("panda")
            >>> round(arm.with_body("panda_hand", mass=2.0, com=[0, 0, 0.1]).mass - arm.mass, 9)
            2.0
        """
        from .changes import with_body

        return with_body(self, frame, mass=mass, com=com, inertia=inertia, name=name)

    def with_lock(self, joints: str | Iterable[str] | Mapping[str, float]) -> Robot:
        """A robot in which joints are fixed: fewer degrees of freedom, the same links.

        Args:
            joints: names, locked at zero, or a mapping to the values to lock them at [rad, m].

        Raises:
            UnknownNameError: no such joint.
            InputError: the joint has several degrees of freedom, or none.

        Example:
            >>> Robot.from_example("panda").with_lock({"panda_joint4": -1.8}).nv
            8
        """
        from .changes import with_lock

        return with_lock(self, joints)

    def with_armature(
        self, armature: Mapping[str, ArrayLike], *, gear: Mapping[str, float] | None = None
    ) -> Robot:
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
            >>> arm = Robot.from_example("ur5").with_armature(
            ...     {"elbow_joint": 6e-5}, gear={"elbow_joint": 101})
            >>> arm.model.armature[2].round(3)
            np.float64(0.612)
        """
        from .changes import with_armature

        return with_armature(self, armature, gear or {})

    def with_ground(
        self, height: float = 0.0, *, normal: ArrayLike = (0.0, 0.0, 1.0), name: str = "ground"
    ) -> Robot:
        """A robot with a plane in its world that ``Collision("ball", "ground")`` can name.

        Args:
            height: of the plane along the normal, from the world's origin [m].
            normal: (3,) out of the ground, world axes.
            name: of the collision geometry. In a combined world the ground belongs to the
                first robot, whose name stands before it: "arm/ground".

        Raises:
            InputError, RangeError, ShapeError, NotFiniteError: of the arguments.

        Example:
            >>> robot = Robot.from_example("solo12", root="freeflyer").with_ground(-0.3)
            >>> robot.collision_model.geometryObjects[0].name
            'ground'
        """
        from .changes import with_ground

        return with_ground(self, height, normal, name)

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

    def neutral(self) -> np.ndarray:
        """(nq,) Pinocchio's neutral configuration."""
        return pin.neutral(self.model)

    def configuration(
        self, by_name: Mapping[str, ArrayLike] | None = None, /, **joints: ArrayLike
    ) -> np.ndarray:
        """(nq,) a configuration by joint name, neutral elsewhere.

        Angles [rad] and lengths [m]. A continuous joint takes its angle, a planar root
        (x, y, angle), a free-flyer x, y, z and the quaternion x, y, z, w. Names that are
        no Python identifiers go in a mapping: ``configuration({"arm/elbow": 0.3})``.

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Warns:
            SetupWarning: a named joint is outside its limits, or reads like degrees.
        """
        from . import state
        from .limits import likely_degrees, outside_limits

        values = {**(by_name or {}), **joints}
        q = state.configuration(self.model, values)
        warn_of_setup([*outside_limits(self, q, values), *likely_degrees(self, values)])
        return q

    def velocity(
        self, by_name: Mapping[str, ArrayLike] | None = None, /, **joints: ArrayLike
    ) -> np.ndarray:
        """(nv,) a velocity by joint name, zero elsewhere [rad/s, m/s].

        Raises:
            UnknownNameError, ShapeError, NotFiniteError.
        """
        from . import state

        return state.velocity(self.model, {**(by_name or {}), **joints})

    def placement(self, q: ArrayLike, frame: str) -> Placement:
        """Where a frame is at q: ``matrix`` (4, 4), ``position`` (3,), ``rotation`` (3, 3).

        In the world; ``point(at)`` of it is where a point of the frame is.

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Example:
            >>> panda = Robot.from_example("panda")
            >>> panda.placement(panda.neutral(), "panda_hand").position.round(3)[2]
            np.float64(0.926)
        """
        from .placing import Posture

        return Posture(self, q).placement(frame)

    def velocity_of(
        self, q: ArrayLike, v: ArrayLike, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)
    ) -> FrameVelocity:
        """How fast a frame moves at q with v, world axes.

        Args:
            q: (nq,) configuration. v: (nv,) velocity.
            frame: the frame.
            at: (3,) the point in it [m] whose velocity ``linear`` is.

        Returns:
            ``linear`` (3,) of the point [m/s] and ``angular`` (3,) of the frame [rad/s].

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Example:
            >>> panda = Robot.from_example("panda")
            >>> v = panda.velocity(panda_joint1=2.0)
            >>> hand = panda.velocity_of(panda.neutral(), v, "panda_hand")
            >>> hand.linear.round(3).tolist(), hand.angular.round(3).tolist()
            ([0.0, 0.176, 0.0], [0.0, 0.0, 2.0])
        """
        from .placing import Posture

        posture = Posture(self, q, v)
        return posture.velocity(frame, posture.placement(frame).point(at))

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

    def __getstate__(self) -> dict[str, Any]:
        # Cached geometry and tables are made again on the other side.
        return {"model": self.model, "parts": self.parts, "name": self.name}

    def __repr__(self) -> str:
        roots = "/".join(dict.fromkeys(part.root for part in self.parts))
        return one_line("Robot", repr(self.name), root=roots, nq=self.nq, nv=self.nv)
