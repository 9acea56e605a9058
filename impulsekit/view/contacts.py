"""What a report says of contacts."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..display.table import decimals, table
from .speeds import speeds_of

if TYPE_CHECKING:
    from ..impact import Impact
    from ..impact.constraint_results import ConstraintResult
    from ..impact.contact_results import ContactPoint, ContactResult

__all__ = ["GAP_SCALE", "contacts_section", "gap_lines"]

# Gaps below rounding of this [m] are shown as 0: places of robots are no better than 1e-13 of it.
GAP_SCALE = 1e4
# Of a line of names [characters].
WIDTH = 80


def contacts_section(impact: Impact) -> list[str]:
    """The lines on the contacts of a scene: impulses, speeds, and what is not unique."""
    results = impact.contacts
    if not results:
        return []
    lines = _points([r for r in results if r.touching and len(r.impulse) == 3])
    lines += _turning([r for r in results if any(p.turning is not None for p in r.points)])
    lines += _stops(impact, [r for r in results if r.touching and len(r.impulse) == 1])
    apart = [result.name for result in results if not result.touching]
    shared = [result.name for result in results if not result.unique]
    if apart:
        lines.append(f"  not touching: {', '.join(apart)}")
    if shared:
        lines.append(f"  redundant, only the resultant counts: {', '.join(shared)}")
    has_stops = any(len(result.impulse) == 1 for result in results)
    lines += gap_lines("gaps [m, rad]" if has_stops else "gaps [m]", results)
    return [
        "Contacts: impulses [N s] in world axes, speeds [m/s] along the normal and across",
        *lines,
    ]


def _turning(results: list[ContactResult]) -> list[str]:
    """Angular impulses against rolling and spin, point by point."""
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


def gap_lines(title: str, results: Sequence[ContactResult | ConstraintResult]) -> list[str]:
    """How far entries are from touching or closed [m, rad]; below a nanometre they are."""
    if not results:
        return []
    shown = [f"{each.name} {decimals(each.gap, GAP_SCALE)}" for each in results]
    return textwrap.wrap(
        f"{title}: {', '.join(shown)}",
        WIDTH,
        initial_indent="  ",
        subsequent_indent="    ",
        break_long_words=False,
    )


def _points(results: list[ContactResult]) -> list[str]:
    if not results:
        return []
    impulse_scale = max(float(np.abs(result.impulse).max()) for result in results)
    speeds = [[_speeds(point) for point in result.points] for result in results]
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


def _speeds(point: ContactPoint) -> tuple[float, float, float, float]:
    """Along the normal and across it, each before and after."""
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
    unit_of_joint = {speed.joint: speed.unit for speed in speeds_of(impact.scene.robot, impact.q)}
    joint_of_name = {
        name: entry.joint_names[0]
        for name, entry in zip(
            impact.scene.entry_names("contacts"), impact.scene.contacts, strict=True
        )
        if entry.joint_names
    }
    rows = []
    for result in results:
        joint = joint_of_name[result.name]
        turns = unit_of_joint[joint] == "rad/s"
        numbers = (result.impulse[0], result.velocity_before[0], result.velocity_after[0])
        units = "N m s, rad/s" if turns else "N s, m/s"
        rows.append([result.name, joint, *map(decimals, numbers), units])
    return table(["stop", "joint", "impulse", "before", "after", "units"], rows)
