"""Robots out of files and models: URDF, MJCF, SDF, example-robot-data, ``pin.Model``."""

from __future__ import annotations

import importlib
import os
import re
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pinocchio as pin

from ..errors import (
    InputError,
    MissingExtraError,
    UnknownNameError,
    UrdfError,
    a_thing,
    shown,
    warn_of_assumptions,
)
from ..files import path_of
from .model_checks import ROOTS, check_depth_first, check_finite, root_joint
from .named_states import RobotStates
from .robot_xml import content_of
from .source import RobotPart

if TYPE_CHECKING:
    import mujoco

    from .urdf import UrdfText

# The outermost element stands behind comments and the XML declaration.
_ASIDE = re.compile(rb"\s*(<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>]*>)", re.DOTALL)
_ELEMENT = re.compile(rb"\s*<([A-Za-z_][\w.-]*)")


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the format of a robot's file: "mjcf", "sdf", or else "urdf".

    Raises:
        UrdfError: it cannot be read.
    """
    element = outermost(content_of(path))
    if element == "mujoco":
        return "mjcf"
    return "sdf" if element in ("sdf", "model", "world") else "urdf"


def outermost(text: bytes) -> str:
    """Return the name of the outermost element of an XML text; "" where there is none."""
    text = text.removeprefix(b"\xef\xbb\xbf")
    start = 0
    while aside := _ASIDE.match(text, start):
        start = aside.end()
    found = _ELEMENT.match(text, start)
    return found.group(1).decode() if found else ""


def files_of_description(name: str) -> tuple[str | None, str, list[str]]:
    """Return the URDF or else the MJCF of a robot, and the folders of its meshes.

    Raises:
        As ``Robot.from_description``.
    """
    with MissingExtraError.unless(
        "robot_descriptions", "descriptions", "reading robots by description"
    ):
        from robot_descriptions import DESCRIPTIONS
    if name not in DESCRIPTIONS:
        raise UnknownNameError.among("robot description", str(name), sorted(DESCRIPTIONS))
    try:
        module = importlib.import_module(f"robot_descriptions.{name}")
    except Exception as error:  # git and the network fail in many ways
        reason = shown(" ".join(str(error).split()), 200)
        raise InputError(
            f'robot description "{name}": its files cannot be fetched: {reason}'
        ) from None
    folders = [getattr(module, key) for key in ("PACKAGE_PATH", "REPOSITORY_PATH")
               if hasattr(module, key)]  # fmt: skip
    return getattr(module, "URDF_PATH", None), getattr(module, "MJCF_PATH", ""), folders


class RobotReaders(RobotStates):
    """Constructors that read a robot."""

    @classmethod
    def from_urdf(
        cls,
        path_or_xml: str | os.PathLike[str],
        root: str | pin.JointModel = "fixed",
        *,
        mimic: bool = False,
        package_dirs: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
        srdf: str | os.PathLike[str] | None = None,
        xacro: bool = False,
    ) -> Self:
        """Return a robot from a URDF file or from URDF text (anything that starts with "<").

        Args:
            path_or_xml: the file, or the text itself.
            root: "fixed", "planar" (x, y and rotation about z), "sagittal" (x, z and pitch,
                rotation about y), "freeflyer", or any
                ``pin.JointModel``, between the world and the root link.
            mimic: True lets mimic joints follow their leader; False (Pinocchio's
                default) lets each move on its own.
            package_dirs: a folder, or folders, of packages, for "package://", and of other
                meshes, needed only when geometry is. Meshes are read from these, the URDF's
                own folder, the folder of the package that it is in (one with a package.xml)
                and ROS_PACKAGE_PATH, and from nowhere else.
            srdf: the SRDF file that goes with it: its named poses are ``poses``, and
                ``collisions`` leaves out the pairs that it disables.
            xacro: True expands a xacro file by the package xacro (``pip install ".[xacro]"``).
                Such a file is a program: its expressions run as Python with your rights and can
                read, change and send whatever you can. Give True for files that you would run.
                False (the default) refuses a xacro file and runs nothing.

        Rotor inertia and gear ratio in a <transmission> become the armature of its joint.
        Files as exporters write them are taken where their meaning is clear: an
        ``AssumptionWarning`` lists what was assumed, and so does ``assumptions``.

        Raises:
            UrdfError: it names the file, the element and the fault.

        Example:
            >>> from impulsekit import Robot
            >>> from impulsekit.models import chain_urdf
            >>> Robot.from_urdf(chain_urdf(links=10), root="planar").nv
            12
        """
        from .urdf import read_urdf

        urdf = read_urdf(path_or_xml, mimic=mimic, xacro=xacro)
        part = RobotPart(
            urdf.text,
            None if urdf.path is None else os.path.abspath(urdf.path),
            mimic=mimic,
            package_dirs=tuple(map(os.path.abspath, _folders(package_dirs))),
            assumptions=urdf.assumptions,
            srdf=None if srdf is None else os.path.abspath(srdf),
        )
        return cls._of_urdf(urdf, part, root)

    @classmethod
    def _of_urdf(cls, urdf: UrdfText, part: RobotPart, root: str | pin.JointModel) -> Self:
        """A robot of a URDF that has passed the check; ``part`` lacks its root."""
        joint, root_name = root_joint(root)
        assumptions, own_root = list(part.assumptions), "root_joint"
        if joint is not None and any(own_root == each.name for each in urdf.joints):
            own_root = "world_root_joint"
            assumptions.append(
                f'the robot has a joint "root_joint", so the root joint is named "{own_root}"'
            )
        part = replace(
            part, root=root_name, assumptions=tuple(assumptions), inertials=urdf.inertials
        )
        warn_of_assumptions(part.label, assumptions)
        arguments = (urdf.plain,) if joint is None else (urdf.plain, joint, own_root)
        try:
            model = pin.buildModelFromXML(*arguments, mimic=part.mimic)
        except (RuntimeError, ValueError) as error:
            raise UrdfError(f"{part.label}: {error}", source=part.label, element="") from None
        armature = np.array(model.armature)
        for name, value in urdf.rotors.items():
            armature[model.joints[model.getJointId(name)].idx_v] += value
        model.armature = armature
        return cls(model, (part,), urdf.name)

    @classmethod
    def from_example(
        cls, name: str, root: str | pin.JointModel = "fixed", *, mimic: bool = False
    ) -> Self:
        """Return a robot of the package example-robot-data, by its loader's name or file's stem.

        No geometry is read. ``impulsekit robots`` lists the names. The package's SRDF goes with
        the robot where it has one.

        Raises:
            UnknownNameError: it carries the nearest names.
        """
        from .examples import example_path, example_srdf, example_urdf

        path = example_path(name)
        text = example_urdf(name)
        folder = path.parents[len(path.parts) - path.parts.index("example-robot-data") - 2]
        return cls.from_urdf(
            path if text is None else text,
            root,
            mimic=mimic,
            package_dirs=(folder.parent, folder / "robots"),
            srdf=example_srdf(name),
        )

    @classmethod
    def from_mjcf(
        cls,
        source: str | os.PathLike[str] | mujoco.MjSpec | mujoco.MjModel,
        root: str | None = None,
    ) -> Self:
        """Return a robot from MJCF, compiled by MuJoCo (``pip install ".[mjcf]"``).

        The configuration is MuJoCo's ``qpos`` with quaternions as x, y, z, w instead of
        w, x, y, z; a free joint's linear velocity is in body axes instead of world axes.
        Joint limits, armature, damping and dry friction come along. ``loops`` holds the
        active equality constraints; ``Scene.of_robot(robot)`` makes constraints of them. What has
        no place in the model (tendons, springs, actuators, ...) is in ``assumptions`` by name.

        Args:
            source: a path, MJCF text, a ``mujoco.MjSpec`` or a ``mujoco.MjModel``.
            root: None keeps the joints of the file; as of ``from_urdf`` is what
                joins each tree to the world instead of a free joint, or of none.

        Raises:
            MjcfError: MuJoCo refuses the file, or it holds what a rigid-body model cannot.
            MissingExtraError: the package mujoco is not installed.

        Example:
            >>> from impulsekit import Robot
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
        package_dirs: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    ) -> Self:
        """Return a robot from a <model> of SDF, the format of Gazebo.

        Joints to a link that another joint carries, and
        gearboxes, are in ``loops``; ``Scene.of_robot(robot)`` makes constraints of them.

        Args:
            source: a path, or SDF text.
            root: as in ``from_urdf``; "fixed" holds the model's first link where it is.
            model: which model, where the file holds several.
            package_dirs: where "model://" and "package://" are looked up, as in ``from_urdf``.

        Raises:
            MjcfError: the file cannot be read or used; it names the element and the fault.

        Example:
            >>> from impulsekit import Robot
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
        folders = (*_folders(package_dirs), *folders_of_file(read.path))
        part = RobotPart(
            read.urdf.text,
            package_dirs=tuple(map(os.path.abspath, folders)),
            assumptions=read.assumptions,
            loops=read.loops,
            source=read.path or "SDF text",
        )
        return cls._of_urdf(read.urdf, part, root)

    @classmethod
    def from_file(
        cls,
        path: str | os.PathLike[str],
        root: str | None = None,
        *,
        package_dirs: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    ) -> Self:
        """Return a robot from a URDF, MJCF or SDF file, by its outermost element.

        Args:
            path: the file.
            root: as of ``from_urdf``; None for "fixed", or of MJCF for the
                joints of the file.
            package_dirs: as in ``from_urdf``.

        Raises:
            UrdfError, MjcfError: it names the file, the element and the fault.

        Example:
            >>> from impulsekit import Robot
            >>> Robot.from_file("models/four_bar.urdf").nv
            3
        """

        path = path_of(path, "the file of a robot")
        written = format_of(path)
        if written == "mjcf":
            return cls.from_mjcf(path, root)
        reader = cls.from_sdf if written == "sdf" else cls.from_urdf
        return reader(path, root or "fixed", package_dirs=package_dirs)

    @classmethod
    def from_description(cls, name: str, root: str | None = None) -> Self:
        """Return a robot of the package robot_descriptions, such as "panda_description".

        The package fetches the files by git on first use, and keeps them
        (``pip install ".[descriptions]"``).

        Raises:
            UnknownNameError: it carries the nearest names.
            MissingExtraError: the package is not installed.
            InputError: its files cannot be fetched.
        """

        urdf, mjcf, folders = files_of_description(name)
        if urdf is None:
            return cls.from_mjcf(mjcf, root)
        return cls.from_urdf(urdf, root or "fixed", package_dirs=folders)

    @classmethod
    def from_model(cls, model: pin.Model) -> Self:
        """Return a robot from a ``pin.Model``, which is copied and never changed.

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


def _folders(package_dirs: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[str]:
    """The folders; one alone may stand for a list of one."""
    if isinstance(package_dirs, str | os.PathLike):
        return [os.fspath(package_dirs)]
    given: list[Any] = list(package_dirs) if isinstance(package_dirs, Iterable) else [package_dirs]
    for folder in given:
        if not isinstance(folder, str | os.PathLike):
            raise InputError(f"package_dirs: {a_thing(folder)} is no folder; give paths of folders")
    return [os.fspath(folder) for folder in given]
