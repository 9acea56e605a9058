"""A URDF is read and checked here before Pinocchio sees it.

Pinocchio's reader is C++: a broken file gets one sentence for all faults there, and some
take the interpreter down. This check names the element that is wrong, and Pinocchio gets
only what has passed it, written anew: two readers of one text may understand it differently.
"""

from __future__ import annotations

import io
import os
import shlex
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import shown
from .robot_xml import Place, parsed_xml, text_of, xml_of
from .source import WHOLE
from .urdf_elements import (
    LinkInertial,
    UrdfJoint,
    check_tree,
    plain_urdf,
    read_joints,
    read_links,
)
from .urdf_repairs import is_expanded, repair_text, repair_tree, uses_xacro

# A principal moment may exceed the sum of the others by this share of it: files round to few
# digits.
EXCESS = 1e-2
# Links whose largest moment is below this share of the robot's largest are markers and dummies.
DUMMY = 1e-4
# So many links are named.
NAMED = 3
# The readers of other formats, by outermost element.
_READERS = {
    "mujoco": "; this is MJCF: Robot.from_mjcf reads it",
    "sdf": "; this is SDF: Robot.from_sdf reads it",
}
_INERTIA = ("rotor_inertia", "rotorinertia", "motor_inertia", "motorinertia")
_RATIO = ("gear_ratio", "gearratio", "mechanicalreduction", "mechanical_reduction")


@dataclass(frozen=True)
class UrdfText:
    """A URDF that has passed the check.

    Attributes:
        text: the XML.
        path: the file it came from, or None.
        name: the robot's name.
        inertials: mass and mass centre of every link.
        joints: the joints, in the order of the file.
        root: the parsed <robot>.
        assumptions: what was assumed where the file leaves something open, one sentence each.
        rotors: by joint, what the rotor of its <transmission> adds to the diagonal of M.
    """

    text: str
    path: str | None
    name: str
    inertials: dict[str, LinkInertial]
    joints: tuple[UrdfJoint, ...]
    root: Element
    assumptions: tuple[str, ...]
    rotors: Mapping[str, float]

    @property
    def plain(self) -> str:
        """The text that Pinocchio reads: links and joints, without geometry."""
        return plain_urdf(self.name, self.inertials, self.joints)


def read_urdf(
    path_or_xml: str | os.PathLike[str], *, mimic: bool = False, xacro: bool = False
) -> UrdfText:
    """Read a URDF from a file, or take it as XML text if it starts with "<", and check it.

    Files as exporters write them are repaired where the meaning is clear; ``assumptions``
    lists the repairs, and ``text`` is then the repaired URDF.

    Args:
        path_or_xml: the file or the text.
        mimic: whether mimic joints will follow their leaders, which must then exist.
        xacro: True runs a xacro file, which is a program; False refuses it.

    Raises:
        UrdfError: no such file, broken XML, a xacro file, or an element that is wrong; it is
            named.
    """
    text, path = text_of(path_or_xml, "a URDF is given as a path or as XML text, not as")
    source = path or "URDF text"
    assumed: list[str] = []
    if uses_xacro(text) and not is_expanded(text):
        if not xacro:
            hint = f"xacro {shlex.quote(path) if path else 'FILE'} > robot.urdf"
            raise Place(source).fault(
                "it is a xacro file, a program that is not run here; expand it by "
                f"`{hint}`, or give xacro=True to Robot.from_urdf if you trust it",
                "xacro",
            )
        text = expanded(text, path)
        assumed.append("the macros of xacro are expanded")
    text, repairs = repair_text(text)
    robot = parsed_xml(text, source)
    return checked_urdf(robot, text, path, [*assumed, *repairs], source=source, mimic=mimic)


def checked_urdf(
    robot: Element,
    text: str,
    path: str | None,
    assumed: Sequence[str] = (),
    *,
    source: str,
    mimic: bool = False,
) -> UrdfText:
    """Repair and check a <robot>.

    Args:
        robot: the outermost element, which repairs change.
        text: the XML that it was parsed from; "" for one that was built.
        path: of the file, or None.
        assumed: what was assumed so far.
        source: the file in messages.
        mimic: as for ``read_urdf``.

    Raises:
        UrdfError: an element that is wrong; it is named.
    """
    assumed = [*assumed, *repair_tree(robot, mimic=mimic)]
    if robot.tag != "robot":
        tag = f"<{shown(robot.tag)}>"
        reader = _READERS.get(robot.tag, "")
        sentence = f"the outermost element is {tag}, a URDF has <robot>{reader}"
        raise Place(source).fault(sentence, tag)
    name = Place(source, "<robot>").name(robot.get("name") or "robot")
    inertials = read_links(robot, source)
    joints = read_joints(robot, source, inertials, mimic=mimic)
    check_tree(joints, inertials, source)
    if assumed or not text:
        text = xml_of(robot)
    # What stays as it is written.
    assumed += impossible_inertias(inertials)
    rotors = read_rotors(robot, joints, source)
    return UrdfText(text, path, name, inertials, joints, robot, tuple(assumed), rotors)


def impossible_inertias(links: Mapping[str, LinkInertial]) -> list[str]:
    """Return a sentence on the links whose principal moments no body has.

    One of them is below zero, or above the sum of the others.
    """
    names = [name for name, link in links.items() if any(link.moments[k] for k in (0, 3, 5))]
    if not names:
        return []
    # In units of the largest, whose squares are doubles.
    entries = np.array([links[name].moments for name in names])[:, WHOLE]
    unit = np.abs(entries).max()
    moments = np.linalg.eigvalsh(entries / unit)
    first, second, third = moments.T
    wrong = (first < -EXCESS * third) | (third > (1.0 + EXCESS) * (first + second))
    found = np.flatnonzero(wrong & (third > DUMMY * third.max()))
    if not len(found):
        return []
    named = ", ".join(
        f'"{names[k]}" ({", ".join(f"{unit * one:.3g}" for one in moments[k])} kg m²)'
        for k in found[:NAMED]
    )
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return [
        f"principal moments of inertia violate the triangle inequality: {named}{more}; they are "
        "taken as written"
    ]


def read_rotors(robot: Element, joints: Sequence[UrdfJoint], source: str) -> dict[str, float]:
    """Return by joint what its rotor adds to the diagonal of M: ratio² · inertia [kg m², kg].

    Raises:
        UrdfError: a number that is none, or below zero.
    """
    moving = {joint.name for joint in joints if joint.kind != "fixed"}
    rotors = {}
    for transmission in robot.findall("transmission"):
        joint = transmission.find("joint")
        name = None if joint is None else joint.get("name")
        if name not in moving:
            continue
        place = Place(source, f'transmission of joint "{name}"')
        inertia = _number_of_rotor(transmission, _INERTIA, place, 0.0)
        if inertia:
            ratio = _number_of_rotor(transmission, _RATIO, place, -np.inf)
            rotors[str(name)] = inertia * (1.0 if ratio is None else ratio) ** 2
    return rotors


def _number_of_rotor(
    parent: Element, names: tuple[str, ...], place: Place, least: float
) -> float | None:
    for child in parent.iter():
        tag = child.tag.rpartition("}")[2] if isinstance(child.tag, str) else ""
        if tag.lower() in names:
            text = child.get("value", child.text) or ""
            return place.number(text.strip(), f"<{tag}>", least)
    return None


def expanded(text: str, path: str | None) -> str:
    """Return the URDF that a xacro file stands for.

    xacro runs the expressions in the file as Python: a file from elsewhere is a program.

    Args:
        text: the file's text.
        path: where it lies; files that it includes are looked for from there.

    Raises:
        UrdfError: xacro is not installed, or refuses the file; the sentence says why.
    """
    place = Place(path or "URDF text")
    try:
        import xacro
    except ImportError:
        raise place.fault(
            'expanding a xacro file needs xacro: pip install ".[xacro]" in impulsekit\'s folder',
            "xacro",
        ) from None
    output = io.StringIO()
    try:
        with redirect_stdout(output), redirect_stderr(output):
            if path is not None:
                return xacro.process_file(path).toxml()
            import tempfile

            with tempfile.TemporaryDirectory() as folder:
                own = os.path.join(folder, "robot.xacro")
                with open(own, "w", encoding="utf-8") as file:
                    file.write(text)
                return xacro.process_file(own).toxml()
    except (Exception, SystemExit) as error:  # xacro has no error class of its own for all
        lines = [line for line in (str(error) or output.getvalue()).splitlines() if line.strip()]
        reason = shown(lines[0], 200) if lines else type(error).__name__
        raise place.fault(f"xacro cannot expand it: {reason}", "xacro") from None


@dataclass(frozen=True)
class Srdf:
    """An SRDF, which MoveIt writes beside a URDF.

    Attributes:
        disabled: pairs of links whose collisions are disabled.
        poses: by the name of a pose, the values of its joints; states of several groups that have
            one name are one pose.
    """

    disabled: frozenset[frozenset[str]]
    poses: Mapping[str, Mapping[str, tuple[float, ...]]]


def read_srdf(path: str | os.PathLike[str]) -> Srdf:
    """Read an SRDF file.

    Raises:
        UrdfError: no such file, broken XML, or a joint value that is no number.

    Example:
        >>> from impulsekit.robot.examples import example_srdf
        >>> sorted(read_srdf(example_srdf("talos")).poses)
        ['half_sitting']
    """
    text, source = text_of(os.path.abspath(path), "")
    robot = parsed_xml(text, str(source))
    disabled = frozenset(
        frozenset((pair.get("link1", ""), pair.get("link2", "")))
        for pair in robot.findall("disable_collisions")
    )
    poses: dict[str, dict[str, tuple[float, ...]]] = {}
    for state in robot.findall("group_state"):
        pose = poses.setdefault(state.get("name", ""), {})
        place = Place(str(source), f'<group_state name="{shown(state.get("name", ""))}">')
        for joint in state.findall("joint"):
            name, words = joint.get("name", ""), joint.get("value", "")
            try:
                pose[name] = tuple(map(float, words.split()))
            except ValueError:
                raise place.fault(
                    f'joint "{shown(name)}" has the value "{shown(words)}", expected numbers',
                    "group_state",
                ) from None
    return Srdf(disabled, poses)
