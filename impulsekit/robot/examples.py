"""The robots of the package example-robot-data, by short name."""

from __future__ import annotations

import functools
import pathlib
from xml.etree import ElementTree

from ..errors import MissingExtraError, UnknownNameError, UrdfError
from ..errors.calls import public

# Names of the package's own loaders where they differ from the file's stem.
_LOADER_NAMES = {
    "alexander": "alexander_description/alexander_v1.lowerBodyOnly",
    "anymal": "anymal_b_simple_description/anymal",
    "anymal_c": "anymal_c_simple_description/anymal",
    "anymal_kinova": "anymal_b_simple_description/anymal-kinova",
    "asr_twodof": "asr_twodof_description/TwoDofs",
    "b1_z1": "b1_description/b1-z1",
    "borinot": "borinot_description/borinot_flying_arm_2",
    "g1": "g1_description/g1_29dof_rev_1_0",
    "g1_with_hands": "g1_description/g1_29dof_with_hand_rev_1_0",
    "hector": "hector_description/quadrotor_base",
    "hextilt": "hextilt_description/hextilt_flying_arm_5",
    "hyq": "hyq_description/hyq_no_sensors",
    "iris": "iris_description/iris_simple",
    "solo8": "solo_description/solo",
    "talos": "talos_data/talos_reduced",
    "talos_arm": "talos_data/talos_left_arm",
    "talos_box": "talos_data/talos_reduced_box",
    "talos_full": "talos_data/talos_full_v2",
    "talos_full_box": "talos_data/talos_full_v2_box",
    "talos_legs": "talos_data/talos_reduced",
    "ur10": "ur_description/ur10_robot",
    "ur10_limited": "ur_description/ur10_joint_limited_robot",
    "ur3": "ur_description/ur3_robot",
    "ur3_limited": "ur_description/ur3_joint_limited_robot",
    "ur5": "ur_description/ur5_robot",
    "ur5_limited": "ur_description/ur5_joint_limited_robot",
}
# Loader names that stand for a file with everything behind one joint taken away.
_CUT_AT = {"talos_legs": "torso_1_joint"}
_NO_URDF = {
    "cassie": "the package has it as SDF only",
    "ur_description/ur3": 'its file holds macros and no link; the robot is "ur3"',
}
# Inertias of rotors at the output, ratio² J [kg m²], that makers of these robots publish.
_FR3 = (0.605721456, 0.605721456, 0.462474144, 0.462474144, *[0.205544064] * 3)
_PANDA = {f"panda_joint{i + 1}": value for i, value in enumerate(_FR3)}
_SOLO12 = {
    f"{leg}_{joint}": 4.5e-6 * 9**2
    for leg in ("FL", "FR", "HL", "HR")
    for joint in ("HAA", "HFE", "KFE")
}
_SOLO8 = {name: value for name, value in _SOLO12.items() if not name.endswith("HAA")}
_SO101 = dict.fromkeys(
    ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper"), 0.028
)
_ROTORS = {
    "panda": _PANDA,
    "panda_collision": _PANDA,
    "so101": _SO101,
    "solo": _SOLO8,
    "solo8": _SOLO8,
    "solo12": _SOLO12,
}


@functools.cache
def data_folder() -> pathlib.Path:
    """Return the folder "example-robot-data" that the package installed."""
    # Imported here: it takes as long as a third of numpy.
    import importlib.metadata

    try:
        distribution = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        raise MissingExtraError(
            "robots by name need example-robot-data: pip install example-robot-data",
            package="example-robot-data",
            extra="",
        ) from None
    return pathlib.Path(
        str(distribution.locate_file("cmeel.prefix/share/example-robot-data"))
    ).resolve()


@functools.cache
def _paths() -> dict[str, pathlib.Path]:
    """Every name and the file behind it."""
    by_place: dict[str, pathlib.Path] = {}
    robots = data_folder() / "robots"
    for path in sorted(robots.rglob("*.urdf")):
        by_place[f"{path.relative_to(robots).parts[0]}/{path.stem}"] = path
    names: dict[str, pathlib.Path] = {}
    for path in by_place.values():
        names.setdefault(path.stem, path)
    names.update({n: by_place[place] for n, place in _LOADER_NAMES.items() if place in by_place})
    # Files that a shorter name hides keep their place as a name.
    reached = set(names.values())
    names.update({place: path for place, path in by_place.items() if path not in reached})
    return {name: path for name, path in names.items() if name not in _NO_URDF}


@public
def example_names() -> tuple[str, ...]:
    """Return all names that ``Robot.from_example`` knows, sorted.

    Example:
        >>> "panda" in example_names()
        True
    """
    return tuple(sorted(_paths()))


@public
def rotor_inertias(name: str) -> dict[str, float]:
    """Return the inertias of rotors at the output [kg m²] that a robot's makers publish, by joint.

    For ``Robot.with_armature``; the URDF files themselves have none.

    - "panda": those of its successor FR3, by Franka (in Drake's ``franka_description/README.md``).
    - "solo8", "solo12": 4.5e-6 kg m² behind a ratio of 9, by the Open Dynamic Robot Initiative
      (``robot_properties_solo/config.py``, BSD-3).
    - "so101": 0.028, by The Robot Studio (``SO-ARM100``, ``joints_properties.xml``, Apache-2.0).

    Raises:
        UnknownNameError: no published inertias of rotors are known; it carries the nearest names.

    Example:
        >>> from impulsekit import Robot
        >>> Robot.from_example("panda").with_armature(rotor_inertias("panda")).nv
        9
    """
    if name not in _ROTORS:
        raise UnknownNameError.among("published rotor inertias", str(name), sorted(_ROTORS))
    return dict(_ROTORS[name])


def example_path(name: str) -> pathlib.Path:
    """Return the URDF file behind a name.

    Raises:
        UnknownNameError: the name is unknown; it carries the nearest names.
        UrdfError: the package has the robot, but not as a URDF.
    """
    try:
        return _paths()[name]
    except (KeyError, TypeError):
        if isinstance(name, str) and name in _NO_URDF:
            raise UrdfError(
                f'example robot "{name}": {_NO_URDF[name]}, expected a URDF',
                source=str(name),
                element="",
            ) from None
        raise UnknownNameError.among("example robot", str(name), example_names()) from None


def example_srdf(name: str) -> str | None:
    """Return the SRDF that goes with a robot, or None: that whose name begins the URDF's.

    Example:
        >>> str(example_srdf("talos")).endswith("talos.srdf")
        True
    """
    path = example_path(name)
    package = data_folder() / "robots" / path.relative_to(data_folder() / "robots").parts[0]
    files = [f for f in (package / "srdf").glob("*.srdf") if path.stem.startswith(f.stem)]
    return str(max(files, key=lambda file: len(file.stem))) if files else None


def example_urdf(name: str) -> str | None:
    """Return the text of a robot that is part of a file, or None where the file is the robot."""
    if name not in _CUT_AT:
        return None
    robot = ElementTree.fromstring(example_path(name).read_text(encoding="utf-8"))
    joints = {joint.get("name"): joint for joint in robot.findall("joint")}
    children: dict[str | None, list[ElementTree.Element]] = {}
    for joint in joints.values():
        children.setdefault(_link(joint, "parent"), []).append(joint)
    doomed = [joints[_CUT_AT[name]]]
    while doomed:
        joint = doomed.pop()
        link = _link(joint, "child")
        doomed.extend(children.get(link, []))
        robot.remove(joint)
        robot.remove(next(e for e in robot.findall("link") if e.get("name") == link))
    return ElementTree.tostring(robot, encoding="unicode")


def _link(joint: ElementTree.Element, tag: str) -> str | None:
    end = joint.find(tag)
    return None if end is None else end.get("link")
