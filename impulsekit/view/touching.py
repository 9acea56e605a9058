"""Contacts in tables: ``touching`` before anything is solved, and the contacts of a report."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import check_kind
from ..errors.calls import public
from ..formatting import Displayed, decimals, table
from ..impact.gaps import (
    AnchorOpening,
    ContactGap,
    anchor_openings,
    contact_gaps,
    nearest_contacts,
)
from ..named import Named
from ..robot.placing import Posture
from ..scene import Scene
from .forms import IMPULSE_UNITS, turns_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..impact import Impact
    from ..impact.contact_results import ContactPoint, ContactResult


# Gaps below rounding of this [m] are shown as 0: places of robots are no better than 1e-13 of it.
GAP_SCALE = 1e4
# Of a line of names [characters].
WIDTH = 100
# So many of the contacts that do not touch are shown.
NEAREST = 3


@dataclass(frozen=True, eq=False, repr=False)
class Touching(Displayed):
    """Gaps and closing speeds of a scene at a state; printed, it is a table.

    Attributes:
        contacts: a ``ContactGap`` for each contact, by place or by name: ``gap`` [m, rad],
            ``closing_speed`` [m/s, rad/s], ``touching``.
        constraints: an ``AnchorOpening`` for each constraint: ``gap`` [m].
    """

    contacts: Named[ContactGap]
    constraints: Named[AnchorOpening]

    def lines(self) -> list[str]:
        """Return the lines of its table."""
        lines: list[str] = []
        if self.contacts:
            rows = [
                [
                    item.name,
                    "yes" if item.touching else "no",
                    decimals(item.gap, GAP_SCALE),
                    decimals(item.closing_speed),
                    "rad, rad/s" if item.angular else "m, m/s",
                ]
                for item in self.contacts
            ]
            head = ["contact", "touching", "gap", "closing speed", "units"]
            lines += ["Contacts", *table(head, rows)]
        if self.constraints:
            rows = [[item.name, decimals(item.gap, GAP_SCALE)] for item in self.constraints]
            lines += ["Constraints", *table(["constraint", "open by, m"], rows)]
        return lines or ["The scene has no contacts and no constraints"]

    def __str__(self) -> str:
        return "\n".join(self.lines())

    __repr__ = __str__


@public
def touching(scene: Scene, q: ArrayLike, v: ArrayLike | None = None) -> Touching:
    """Report the gaps of all contacts and anchors of a scene at one state, without solving it.

    Args:
        scene: the scene.
        q: (nq,) configuration.
        v: (nv,) velocity; None for a robot at rest.

    Raises:
        ShapeError, NotFiniteError, StateError: q or v is not valid.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> floor = Contact("panda_hand", at=[0, 0, 0.1], name="floor")
        >>> v = robot.velocity(panda_joint2=1.0)
        >>> print(touching(Scene(robot, contacts=[floor]), robot.neutral(), v))
        Contacts
          contact   touching     gap   closing speed   units
          -------   --------   -----   -------------   ------
          floor     yes        0.826           0.088   m, m/s
    """
    check_kind(scene, Scene, "touching")
    posture = Posture(scene.robot, q, v)
    return Touching(
        Named(contact_gaps(scene, posture), "contact"),
        Named(anchor_openings(scene, posture), "constraint"),
    )


def contacts_section(impact: Impact) -> list[str]:
    """Return the lines on contacts: impulses, speeds, and contacts that are not unique."""
    results = impact.contacts
    if not results:
        return []
    lines = _point_rows([r for r in results if r.touching and len(r.impulse) == 3])
    lines += _turning([r for r in results if any(p.turning is not None for p in r.points)])
    lines += _stops(impact, [r for r in results if r.touching and len(r.impulse) == 1])
    touching = [i for i, result in enumerate(results) if result.touching]
    shared = [result.name for result in results if not result.unique]
    if shared:
        lines += _wrapped("only the resultant is determined", shared)
    units = "[m, rad]" if any(len(result.impulse) == 1 for result in results) else "[m]"
    posture = Posture(impact.scene.robot, impact.q, impact.v_before)
    gaps = contact_gaps(impact.scene, posture, touching)
    lines += gap_lines(f"gaps {units}", [(item.name, item.gap) for item in gaps])
    if count := len(results) - len(touching):
        near = nearest_contacts(impact.scene, posture, NEAREST, touching)
        others = "1 other does" if count == 1 else f"{count} others do"
        nearest = "nearest, " if count > len(near) else ""
        title = f"{others} not touch; {nearest}gaps {units}"
        lines += gap_lines(title, [(item.name, item.gap) for item in near])
    return [
        "Contacts: impulses [N s] in world axes, speeds [m/s] along the normal and across",
        *lines,
    ]


def _turning(results: list[ContactResult]) -> list[str]:
    """Return angular impulses against rolling and spin, point by point."""
    own = [(r.name, p.turning) for r in results for p in r.points if p.turning is not None]
    if not own:
        return []
    moments = max(float(np.abs(turning.impulse).max()) for _, turning in own)
    rates = max(
        float(np.abs(w).max()) for _, t in own for w in (t.velocity_before, t.velocity_after)
    )
    rows = [
        [
            name,
            turning.rolling,
            turning.spin,
            *(decimals(x, moments) for x in turning.impulse),
            *(
                decimals(float(np.linalg.norm(w)), rates)
                for w in (turning.velocity_before, turning.velocity_after)
            ),
        ]
        for name, turning in own
    ]
    head = ["name", "rolling", "spin", *(f"impulse {axis}" for axis in "xyz")]
    title = "  angular impulses against rolling and spin [N m s], relative angular speeds [rad/s]"
    return [title, *table([*head, "speed before", "after"], rows)]


def gap_lines(title: str, gaps: Sequence[tuple[str, float]]) -> list[str]:
    """Return names with their gaps [m, rad]; below a nanometre they are shown as 0."""
    return _wrapped(title, [f"{name} {decimals(gap, GAP_SCALE)}" for name, gap in gaps])


def _wrapped(title: str, words: Sequence[str]) -> list[str]:
    """Return a list in lines of readable width."""
    if not words:
        return []
    return textwrap.wrap(
        f"{title}: {', '.join(words)}",
        WIDTH,
        initial_indent="  ",
        subsequent_indent="    ",
        break_long_words=False,
    )


def _point_rows(results: list[ContactResult]) -> list[str]:
    if not results:
        return []
    impulse_scale = max(float(np.abs(result.impulse).max()) for result in results)
    speeds = [[_point_speeds(point) for point in result.points] for result in results]
    speed_scale = max(float(np.abs(each).max()) for each in speeds)
    rows = []
    for result, each in zip(results, speeds, strict=True):
        count = len(result.points)
        rows.append(
            [
                result.name + (f" ({count} points)" if count > 1 else ""),
                result.mode,
                *(decimals(x, impulse_scale) for x in result.impulse),
                *(decimals(x, speed_scale) for x in np.mean(each, axis=0)),
            ]
        )
    head = ["name", "mode", *(f"impulse {axis}" for axis in "xyz")]
    head += ["normal before", "after", "slip before", "after"]
    return table(head, rows)


def _point_speeds(point: ContactPoint) -> tuple[float, float, float, float]:
    """Return speeds along the normal and across it, each before and after."""
    if point.normal is None:
        raise ValueError("a joint stop has no normal")
    found = []
    for velocity in (point.velocity_before, point.velocity_after):
        along = float(point.normal @ velocity)
        found += [along, float(np.linalg.norm(velocity - along * point.normal))]
    return found[0], found[2], found[1], found[3]


def _stops(impact: Impact, results: list[ContactResult]) -> list[str]:
    if not results:
        return []
    turns = turns_of(impact)
    joints = {
        result.name: entry.joint_names[0]
        for result, entry in zip(impact.contacts, impact.scene.contacts, strict=True)
        if entry.joint_names
    }
    rows = []
    for result in results:
        joint = joints[result.name]
        numbers = (result.impulse[0], result.velocity_before[0], result.velocity_after[0])
        rows.append([result.name, joint, *map(decimals, numbers), IMPULSE_UNITS[turns[joint][0]]])
    return table(["stop", "joint", "impulse", "before", "after", "units"], rows)
