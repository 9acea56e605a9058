"""The arrows of an impact: impulses, couples, reactions, velocities, and marks of contacts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..robot.placing import Posture
from ..rows.entries import FramePair, rows_of_entry
from ..scene import AppliedImpulse, JointCoupling, JointImpulse, JointLock

if TYPE_CHECKING:
    from ..impact import Impact
    from ..scene.points import ReportPoint

from .forms import TURNS

# Kind: its name in legend and labels, its unit and its colour.
KINDS = {
    "impulse": ("impulse", "N s", (0.78, 0.20, 0.13)),
    "couple": ("couple impulse", "N m s", (0.86, 0.50, 0.10)),
    "reaction": ("joint reaction", "N s", (0.46, 0.26, 0.62)),
    "reaction couple": ("couple in a joint", "N m s", (0.70, 0.45, 0.78)),
    "before": ("velocity before", "m/s", (0.27, 0.27, 0.29)),
    "after": ("velocity after", "m/s", (0.08, 0.44, 0.90)),
    "force": ("contact force", "N", (0.85, 0.20, 0.48)),
}
# Contact points are marked by their mode, across their normal.
MODES = {
    "sticking": (0.16, 0.58, 0.34),
    "sliding": (0.93, 0.60, 0.12),
    "separated": (0.55, 0.60, 0.65),
}
# Beside the largest arrow of its kind, a shorter one is not drawn.
SHORTEST = 5e-3
# Velocity arrows that are drawn by default stay as few as this.
FEW = 12
# As many entries fit into the line of an impact.
MOST_NAMED = 5


@dataclass(frozen=True, eq=False)
class Arrow:
    """A vector at a point.

    Attributes:
        kind: a key of ``KINDS``; "contact" marks a contact point, with its normal as vector.
        name: the entry of the scene, the joint or the point it belongs to.
        origin: (3,) where it starts, in the world [m].
        vector: (3,) in world axes, in the unit of its kind.
        from_outside: it ends at its origin, as an applied impulse does, instead of starting there.
        mode: of the contact that it belongs to.
    """

    kind: str
    name: str
    origin: np.ndarray
    vector: np.ndarray
    from_outside: bool = False
    mode: str = ""

    @property
    def size(self) -> float:
        """The length in the unit of its kind."""
        return float(np.linalg.norm(self.vector))

    @property
    def group(self) -> str:
        """The arrows and marks that a row of the legend shows or hides together."""
        return f"contact {self.mode}" if self.kind == "contact" else self.kind

    @property
    def color(self) -> tuple[float, float, float]:
        """Red, green and blue."""
        return MODES[self.mode] if self.kind == "contact" else KINDS[self.kind][2]

    @property
    def label(self) -> str:
        """The text of the page, such as "floor: 5.3 N s, sliding"."""
        if self.kind == "contact":
            return f"{self.name}: {self.mode}"
        words, unit, _ = KINDS[self.kind]
        more = [words] * (self.kind != "impulse") + [self.mode] * bool(self.mode)
        return ", ".join([f"{self.name}: {self.size:.3g} {unit}", *more])


def summary(arrows: Iterable[Arrow]) -> str:
    """Return the impulses of an impact in a line: by entry the resultant, the largest first.

    Example:
        >>> foot = [Arrow("impulse", "foot", np.zeros(3), np.array([0, 0, 1.5]))] * 2
        >>> summary(foot)
        'foot: 3 N s'
    """
    parts: dict[tuple[str, str], list[Arrow]] = {}
    for item in arrows:
        if item.kind in ("impulse", "couple"):
            parts.setdefault((item.kind, item.name), []).append(item)
    whole = [
        replace(own[0], vector=np.sum([item.vector for item in own], axis=0))
        for own in parts.values()
    ]
    whole.sort(key=lambda item: (item.kind != "impulse", -item.size))
    more = [f"and {len(whole) - MOST_NAMED} more"] * (len(whole) > MOST_NAMED)
    return "; ".join([*(item.label for item in whole[:MOST_NAMED]), *more])


def impact_arrows(
    impact: Impact,
    *,
    points: Sequence[ReportPoint] = (),
    velocities: bool = True,
    reactions: bool | Sequence[str] = False,
) -> list[Arrow]:
    """Return the arrows of an impact and the marks of its contact points.

    Args:
        impact: the impact.
        points: where velocities are drawn; by default at the mass centres that jump most.
        velocities: draw velocities.
        reactions: True for every joint, or the joints' names.

    Raises:
        UnknownNameError: a joint without a reaction, or a point on an unknown frame.
    """
    found = [*_known(impact), *_constraints(impact), *_contacts(impact)]
    if velocities:
        found += _velocities_at(impact, points) if points else _velocities(impact)
    if reactions is not False:
        found += _reactions(impact, None if reactions is True else list(reactions))
    largest = largest_sizes(found)
    return [arrow for arrow in found if arrow.size > SHORTEST * largest[arrow.kind]]


def largest_sizes(arrows: Iterable[Arrow]) -> dict[str, float]:
    """Return the size of the longest arrow of each kind there is, in its unit."""
    largest: dict[str, float] = {}
    for arrow in arrows:
        largest[arrow.kind] = max(largest.get(arrow.kind, 0.0), arrow.size)
    # Both velocities share one scale, so that the eye can compare them.
    speed = max(largest.get("before", 0.0), largest.get("after", 0.0))
    return largest | {kind: speed for kind in ("before", "after") if kind in largest}


def _known(impact: Impact) -> Iterator[Arrow]:
    scene = impact.scene
    for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
        if isinstance(entry, AppliedImpulse):
            place = impact.mechanics.frame_placement(entry.frame)
            turn = place.rotation if entry.axes == "local" else np.eye(3)
            origin = place.act(np.array(entry.at))
            yield Arrow("impulse", name, origin, turn @ np.array(entry.linear), from_outside=True)
            yield Arrow("couple", name, origin, turn @ np.array(entry.angular))
        elif isinstance(entry, JointImpulse):
            yield from _in_joint(impact, name, entry.joint, np.atleast_1d(entry.impulse))


def _constraints(impact: Impact) -> Iterator[Arrow]:
    for entry, result in zip(impact.scene.held, impact.constraints, strict=True):
        rows = rows_of_entry(impact.scene.robot, entry)
        if isinstance(rows, FramePair):
            places = rows.places(impact.mechanics.joint_placement)
            wrench, origin = (
                rows.wrench(result.impulse, rows.axes_at(*places)),
                places[0].translation,
            )
            yield Arrow("impulse", result.name, origin, wrench[:3])
            yield Arrow("couple", result.name, origin, wrench[3:])
        elif isinstance(entry, JointLock | JointCoupling):
            yield from _in_joint(impact, result.name, entry.joint, result.impulse)


def _contacts(impact: Impact) -> Iterator[Arrow]:
    for entry, result in zip(impact.scene.contacts, impact.contacts, strict=True):
        for point in result.points:
            if point.position is not None and point.normal is not None:
                place, normal = np.array(point.position), np.array(point.normal)
                yield Arrow("impulse", result.name, place, point.impulse, mode=point.mode)
                yield Arrow("contact", result.name, place, normal, mode=point.mode)
            elif entry.joint_names:
                yield from _in_joint(impact, result.name, entry.joint_names[0], point.impulse)


def _in_joint(impact: Impact, name: str, joint: str, impulse: np.ndarray) -> Iterator[Arrow]:
    """Return a generalized impulse in a joint as a force or couple impulse on its child."""
    joint_id = impact.scene.robot.joint_id(joint)
    subspace = Posture(impact.scene.robot, impact.q).motion_subspace(joint_id)
    place = impact.mechanics.joint_placement(joint_id)
    # Each speed's own direction; unlike Sᵀf = τ it needs no choice where S is not orthonormal.
    wrench = subspace @ np.asarray(impulse)
    turns = np.abs(subspace[3:]).max(axis=0) > TURNS
    linear = subspace[:3, ~turns] @ np.asarray(impulse)[~turns]
    yield Arrow("impulse", name, place.translation, place.rotation @ linear)
    yield Arrow("couple", name, place.translation, place.rotation @ wrench[3:])


def _velocities_at(impact: Impact, points: Sequence[ReportPoint]) -> Iterator[Arrow]:
    for point in points:
        place = impact.mechanics.frame_placement(point.frame).act(np.array(point.at))
        velocity = impact.velocity_at(point.frame, point.at)
        yield Arrow("before", point.title, place, velocity.before)
        yield Arrow("after", point.title, place, velocity.after)


def _velocities(impact: Impact) -> Iterator[Arrow]:
    """Return velocities at the mass centres of links, those whose momentum jumps most."""
    robot = impact.scene.robot
    data = robot.model.createData()
    jumps = impact.bodies
    links = [link for link in robot.links if link.mass > 0.0 and link.joint_id > 0]
    links.sort(key=lambda link: -link.mass * float(np.linalg.norm(jumps[link.name].dv_com)))
    for kind, v in (("before", impact.v_before), ("after", impact.v_after)):
        pin.forwardKinematics(robot.model, data, impact.q, np.array(v))
        for link in links[:FEW]:
            twist, place = data.v[link.joint_id], data.oMi[link.joint_id]
            velocity = twist.linear + np.cross(twist.angular, link.com_in_joint)
            yield Arrow(kind, link.name, place.act(link.com_in_joint), place.rotation @ velocity)


def _reactions(impact: Impact, names: list[str] | None) -> Iterator[Arrow]:
    robot = impact.scene.robot
    known = impact.reactions
    for name in known if names is None else names:
        if name not in known:
            from ..errors import UnknownNameError

            raise UnknownNameError.among("joint", name, known, "replay: reactions")
        if name in robot.joint_names:
            origin = impact.mechanics.joint_placement(robot.joint_id(name)).translation
        elif names is None:
            # Every joint that moves; fixed ones are drawn where they are named.
            continue
        else:
            origin = impact.mechanics.frame_placement(name).translation
        yield Arrow("reaction", name, np.array(origin), known[name][:3])
        yield Arrow("reaction couple", name, np.array(origin), known[name][3:])
