"""Repairs of the links of a URDF where the meaning is clear; see ``urdf_repairs``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .urdf_numbers import listed

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["repair_inertias", "with_world_link", "without_shapeless"]

_PRODUCTS = ("ixy", "ixz", "iyz")


def with_world_link(robot: Element, links: set[str | None]) -> list[str]:
    """A link "world" that joints name as their parent, and that is the only one missing."""
    from xml.etree.ElementTree import Element as NewElement

    missing = {
        end.get("link")
        for joint in robot.findall("joint")
        for end in (joint.find("parent"), joint.find("child"))
        if end is not None and end.get("link") not in links
    }
    if missing != {"world"} or not links:
        return []
    robot.insert(0, NewElement("link", {"name": "world"}))
    return ['link "world" is missing; it is taken as a link without mass']


def repair_inertias(robot: Element) -> list[str]:
    """<inertial> without <mass> says nothing; without <inertia> it is a point's."""
    from xml.etree.ElementTree import SubElement

    no_mass, points = [], []
    for link in robot.findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        if inertial.find("mass") is None:
            # An inertia without a mass is a slip that nobody but the author can mend.
            if inertial.find("inertia") is None:
                link.remove(inertial)
                no_mass.append(link.get("name", ""))
        elif inertial.find("inertia") is None:
            SubElement(inertial, "inertia", ixx="0", iyy="0", izz="0", ixy="0", ixz="0", iyz="0")
            points.append(link.get("name", ""))
    told = []
    if no_mass:
        told.append(f"a link whose <inertial> has no <mass> has none ({listed(no_mass)})")
    if points:
        told.append(
            "a link whose <inertial> has no <inertia> is a point mass at its mass centre "
            f"({listed(points)})"
        )
    return told + _products_of_inertia(robot)


def _products_of_inertia(robot: Element) -> list[str]:
    names = []
    for link in robot.findall("link"):
        inertia = link.find("inertial/inertia")
        if inertia is None or not all(key in inertia.attrib for key in ("ixx", "iyy", "izz")):
            continue
        absent = [key for key in _PRODUCTS if key not in inertia.attrib]
        for key in absent:
            inertia.set(key, "0")
        if absent:
            names.append(link.get("name", ""))
    if not names:
        return []
    return [f"products of inertia that are left out are 0 ({listed(names)})"]


def without_shapeless(robot: Element) -> list[str]:
    """<visual> in which no shape stands: there is nothing to be drawn."""
    names = []
    for link in robot.findall("link"):
        for item in link.findall("visual"):
            geometry = item.find("geometry")
            if geometry is None or not len(geometry):
                link.remove(item)
                names.append(link.get("name", ""))
    return [f"<visual> without a shape is ignored ({listed(names)})"] if names else []
