"""What rested in a step of a motion, and how: the forces of the step follow from it again."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...geometry.features import CornerOnFace, EdgesCross, TipOnFace
from ...rows.reach import reached_model
from ...scene import Scene
from ..gaps.contacts import Gaps
from ..gaps.resting import RestingContact
from ..tree.pressed import BEGINS, SLIDES, STICKS
from .contacts import Resting

if TYPE_CHECKING:
    from ...geometry.held_points import HeldPoint

__all__ = ["NOTHING", "Footing", "footings_of", "packed_footings"]


@dataclass(frozen=True, eq=False)
class Footing:
    """The contacts that rest in a step, as they were when it was made.

    Attributes:
        contacts: in the order of their rows; not to be changed.
        held: by contact, the points of polyhedra that were followed, not to be changed; None
            where none were.
        slow, negligible: as ``Resting`` has them.
        ways: as ``DryJoints`` has them; empty where no joint has dry friction.
    """

    contacts: tuple[RestingContact, ...] = ()
    held: tuple[list[HeldPoint] | None, ...] = ()
    slow: float = 0.0
    negligible: float = 0.0
    ways: tuple[float, ...] = ()

    @classmethod
    def of(cls, resting: Resting, gaps: Gaps | None) -> Footing:
        """What rests now."""
        ways = () if resting.joints is None else tuple(resting.joints.ways.tolist())
        if gaps is None or not resting.contacts:
            return cls(ways=ways) if ways else NOTHING
        return cls(
            tuple(_copied(contact) for contact in resting.contacts),
            tuple(
                None if gaps.rated[contact.gap] else gaps.items[contact.gap].held
                for contact in resting.contacts
            ),
            resting.slow,
            resting.negligible,
            ways,
        )

    def restored(self, scene: Scene, gaps: Gaps | None) -> Resting:
        """What rests in the step, without anything of other times."""
        resting = Resting(scene)
        if resting.joints is not None:
            resting.joints.ways = np.array(self.ways)
        if gaps is not None and self.contacts:
            resting.contacts = [_copied(contact) for contact in self.contacts]
            resting.slow, resting.negligible = self.slow, self.negligible
            for contact, held in zip(self.contacts, self.held, strict=True):
                if not gaps.rated[contact.gap]:
                    gaps.items[contact.gap].held = held
        return resting


def _copied(contact: RestingContact) -> RestingContact:
    own = copy(contact)
    own.slips, own.rolls, own.spins = (a.copy() for a in (own.slips, own.rolls, own.spins))
    return own


NOTHING = Footing()


def packed_footings(footings: Sequence[Footing]) -> list[Any]:
    """The footings of a path, ready for JSON; where nothing rests, None."""
    return [None if own is NOTHING else _packed(own) for own in footings]


def footings_of(scene: Scene, packed: Sequence[Any]) -> list[Footing]:
    """The footings that ``packed_footings`` packed.

    Raises:
        KeyError, IndexError, ValueError, TypeError: they are none of this scene.
    """
    if not any(packed):
        return [NOTHING] * len(packed)
    reached = reached_model(
        scene.robot.model, range(1, scene.robot.model.njoints), keep_places=True
    )
    gaps = Gaps(scene, reached) if scene.contacts else None
    return [NOTHING if own is None else _unpacked(own, gaps) for own in packed]


def _packed(footing: Footing) -> dict[str, Any]:
    return {
        "slow": footing.slow,
        "negligible": footing.negligible,
        "joints": footing.ways,
        "contacts": [
            {
                "gap": c.gap,
                "entry": c.entry,
                "friction": c.friction,
                "since": c.since,
                "count": c.count,
                "slides": _packed_ways(c.slips, 2),
                "begins": (c.slips[:, 2] == BEGINS).tolist(),
                **({"turns": _packed_turns(c)} if len(c.rolls) else {}),
                "held": None if held is None else [_packed_point(point) for point in held],
            }
            for c, held in zip(footing.contacts, footing.held, strict=True)
        ],
    }


def _packed_ways(ways: np.ndarray, numbers: int) -> list[list[float] | None]:
    """By point the numbers of its direction; None where it sticks."""
    return [way[:numbers] if way[2] != STICKS else None for way in ways.tolist()]


def _packed_turns(contact: RestingContact) -> list[list[Any]]:
    """By point how it rolls and spins, and which of it has just begun."""
    both = contact.rolls, contact.spins
    begins = [(ways[:, 2] == BEGINS).tolist() for ways in both]
    ways = _packed_ways(contact.rolls, 2), _packed_ways(contact.spins, 1)
    return [list(point) for point in zip(*ways, *begins, strict=True)]


def _unpacked_ways(packed: Sequence[Any], begins: Sequence[Any]) -> np.ndarray:
    """(k, 3) what ``_packed_ways`` packed, and whether slides have just begun."""
    ways = np.zeros((len(packed), 3))
    for own, way, starts in zip(ways, packed, begins, strict=True):
        if way is not None:
            own[: len(way)], own[2] = way, BEGINS if starts else SLIDES
    return ways


def _packed_point(point: HeldPoint) -> list[Any]:
    feature = point.feature
    if isinstance(feature, CornerOnFace):
        where: list[Any] = [feature.side, feature.corner, feature.face]
    elif isinstance(feature, TipOnFace):
        where = [feature.side, feature.tip, feature.face, int(feature.rolls)]
    else:
        where = [list(map(int, feature.first)), list(map(int, feature.other))]
    return [list(point.pieces), where, list(point.kept)]


def _unpacked(packed: dict[str, Any], gaps: Gaps | None) -> Footing:
    contacts, all_held = [], []
    for own in packed["contacts"]:
        if gaps is None:
            raise ValueError("a contact that rests is none of the scene's")
        rolls, spins, *begin = zip(*own["turns"], strict=True) if own.get("turns") else ((),) * 4
        contacts.append(
            RestingContact(
                int(own["gap"]),
                int(own["entry"]),
                float(own["friction"]),
                float(own["since"]),
                int(own["count"]),
                _unpacked_ways(own["slides"], own["begins"]),
                _unpacked_ways(rolls, begin[0]),
                _unpacked_ways(spins, begin[1]),
            )
        )
        if gaps.entries[contacts[-1].gap] != contacts[-1].entry:
            raise ValueError("a contact that rests is none of the scene's")
        held = own["held"]
        if held is not None:
            item = gaps.items[contacts[-1].gap]
            held = [
                item.point_again((int(pieces[0]), int(pieces[1])), _feature(where), kept)
                for pieces, where, kept in held
            ]
        all_held.append(held)
    numbers = float(packed["slow"]), float(packed["negligible"])
    ways = tuple(float(way) for way in packed.get("joints", ()))
    return Footing(tuple(contacts), tuple(all_held), *numbers, ways)


def _feature(where: list[Any]) -> CornerOnFace | EdgesCross | TipOnFace:
    if len(where) == 3:
        return CornerOnFace(*map(int, where))
    if len(where) == 4:
        side, tip, face, rolls = map(int, where)
        return TipOnFace(side, tip, face, bool(rolls))
    (a, b), (c, d) = where
    return EdgesCross((int(a), int(b)), (int(c), int(d)))
