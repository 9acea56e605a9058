"""Materials of links, and a table of pairs: coefficients of contacts by what touches what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..errors import InputError, a_thing
from ..errors.calls import public
from ..robot import Robot
from .coefficients import (
    Damping,
    FrictionLike,
    RestitutionLike,
    Stiffness,
    as_given,
    asks_for_materials,
)
from .contacts import Collision, Contact
from .entry import Checked
from .numbers import Name, text


@public
@dataclass(frozen=True)
class Material(Checked):
    """A material, and the links that are made of it.

    Attributes:
        name: what pairs call it.
        links: names of links or frames, all frames on them included; "world" for what is fixed.

    Raises:
        InputError.

    Example:
        >>> Material("rubber", links=["ball"]).links
        ('ball',)
    """

    wording = '{kind} "{name}"'

    name: Name
    links: tuple[str, ...]

    def _check(self, what: str) -> None:
        links = (self.links,) if isinstance(self.links, str) else self.links
        what = f"{what}: links"
        if not isinstance(links, Sequence):
            raise InputError(f"{what} must be a list of names, got {a_thing(links)}")
        object.__setattr__(self, "links", tuple(text(link, what) for link in links))

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the links."""
        for link in self.links:
            robot.frame_id(link, where)


@public
@dataclass(frozen=True)
class MaterialPair(Checked):
    """The coefficients of two materials that touch, in either order.

    Only pairs that are listed count: no rule makes up e and µ out of two materials, for both are
    properties of the pair.

    Attributes:
        first, other: names of materials; they may be the same.
        restitution, friction: as for ``Contact``.
        stiffness, stiffness_ratio, tangential_damping: as for ``Contact``; for contacts that give
            none.

    Raises:
        InputError, RangeError, NotFiniteError.

    Example:
        >>> MaterialPair("rubber", "steel", restitution=0.8, friction=0.9).friction
        0.9
    """

    wording = '{kind} of "{first}" and "{other}"'

    first: Name
    other: Name
    restitution: RestitutionLike = 0.0
    friction: FrictionLike = 0.0
    stiffness: Stiffness = None
    stiffness_ratio: Stiffness = None
    tangential_damping: Damping = None


def with_materials(
    robot: Robot, contacts: Sequence[Any], materials: Sequence[Any]
) -> tuple[Any, ...]:
    """Return the contacts, with the coefficients of the table where they ask for it.

    Contacts with coefficients of another table get those of this one.

    Raises:
        InputError: something that is no material or pair, a name or link given twice, materials
            without a pair, a link without a material.
        UnknownNameError: a link that the robot does not have.
    """
    of_link, pairs = _tables(robot, materials)
    found = []
    for i, contact in enumerate(map(as_given, contacts)):
        if not asks_for_materials(contact):
            found.append(contact)
            continue
        first, other = _materials_of(robot, contact, of_link, f"contacts[{i}]")
        pair = pairs.get(frozenset((first, other)))
        if pair is None:
            raise InputError(
                f'contacts[{i}]: materials without a pair, "{first}" and "{other}"; add '
                f'MaterialPair("{first}", "{other}", ...)'
            )
        names = ["restitution", "friction"]
        changes = {
            name: getattr(pair, name) for name in names if isinstance(getattr(contact, name), str)
        }
        for name in ("stiffness", "stiffness_ratio", "tangential_damping"):
            if getattr(contact, name) is None:
                changes[name] = getattr(pair, name)
        by_table = tuple((name, getattr(contact, name), changes[name]) for name in changes)
        resolved = replace(contact, _by_table=by_table, **changes)
        found.append(resolved)
    return tuple(found)


def _tables(
    robot: Robot, materials: Sequence[Any]
) -> tuple[dict[str, str], dict[frozenset[str], MaterialPair]]:
    of_link: dict[str, str] = {}
    pairs: dict[frozenset[str], MaterialPair] = {}
    names = {one.name for one in materials if isinstance(one, Material)}
    for i, one in enumerate(materials):
        where = f"materials[{i}]"
        if isinstance(one, Material):
            one.check_robot(robot, where)
            for link in one.links:
                if of_link.setdefault(link, one.name) != one.name:
                    raise InputError(
                        f'{where}: "{link}" is made of "{of_link[link]}" already; give it one '
                        "material"
                    )
        elif isinstance(one, MaterialPair):
            unknown = [name for name in (one.first, one.other) if name not in names]
            if unknown:
                raise InputError(
                    f'{where}: no Material has the name "{unknown[0]}"; known: '
                    f"{', '.join(sorted(names)) or 'none'}"
                )
            key = frozenset((one.first, one.other))
            if key in pairs:
                raise InputError(
                    f'{where}: the pair of "{one.first}" and "{one.other}" is given twice'
                )
            pairs[key] = one
        else:
            raise InputError(f"{where} must be a Material or MaterialPair, got {a_thing(one)}")
    return of_link, pairs


def _materials_of(
    robot: Robot, contact: Contact | Collision, of_link: dict[str, str], where: str
) -> list[str]:
    found = []
    ends = [getattr(contact, name, None) for name in ("frame", "against", "first", "other")]
    for name in [end for end in ends if end is not None]:
        if name in of_link:
            found.append(of_link[name])
            continue
        frames = robot.model.frames
        if hasattr(contact, "frame"):
            frame_id = robot.frame_id(name, where)
        else:
            from ..robot.geometry import geometry_ids

            objects = robot.collision_model.geometryObjects
            frame_id = objects[geometry_ids(robot, name, where)[0][0]].parentFrame
        material = None
        while material is None:
            material = of_link.get(frames[frame_id].name if frame_id else "world")
            if frame_id == 0 or frames[frame_id].parentFrame == frame_id:
                break
            last, frame_id = frame_id, frames[frame_id].parentFrame
            if frames[last].parentJoint != frames[frame_id].parentJoint:
                break
        if material is None:
            raise InputError(
                f'{where}: "{name}" has no material; add Material(..., links=["{name}"]), or give '
                "the contact its own coefficients"
            )
        found.append(material)
    return found
