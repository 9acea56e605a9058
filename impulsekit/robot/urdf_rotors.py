"""Rotors that a URDF tells of: inertia and gear ratio in its <transmission> elements.

URDF has no word for them. Drake writes <drake:rotor_inertia value="..."/> and
<drake:gear_ratio value="..."/> into an <actuator>; others <rotorInertia>, <motorInertia> and
<mechanicalReduction> with the number as text.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from .urdf_elements import UrdfJoint
from .urdf_numbers import number

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["read_rotors"]

_INERTIA = ("rotor_inertia", "rotorinertia", "motor_inertia", "motorinertia")
_RATIO = ("gear_ratio", "gearratio", "mechanicalreduction", "mechanical_reduction")


def read_rotors(robot: Element, joints: Sequence[UrdfJoint], source: str) -> Mapping[str, float]:
    """By joint, what its rotor adds to the diagonal of M: ratio² · inertia [kg m², kg].

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
        element = f'transmission of joint "{name}"'
        inertia = _found(transmission, _INERTIA, source, element)
        if inertia:
            ratio = _found(transmission, _RATIO, source, element)
            rotors[str(name)] = inertia * (1.0 if ratio is None else ratio) ** 2
    return rotors


def _found(parent: Element, names: tuple[str, ...], source: str, element: str) -> float | None:
    for child in parent.iter():
        tag = child.tag.rpartition("}")[2] if isinstance(child.tag, str) else ""
        if tag.lower() in names:
            text = child.get("value", child.text)
            least = 0.0 if names is _INERTIA else -float("inf")
            return number((text or "").strip(), source, element, f"<{tag}>", least)
    return None
