"""Drawings beside the bodies: arrows and marks of impacts, and traces of points."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from .actors import Actors
from .arrows import COLORS, KINDS, Arrow, Mark, impact_arrows, impact_marks, largest_sizes
from .drawing import ROOT, Drawing, node_name
from .motions import Shown
from .surfaces import arrow as arrow_surface
from .surfaces import disc, tube
from .timeline import Timeline

if TYPE_CHECKING:
    from ..scene.points import ReportPoint

# Against the reach of the picture.
LONGEST_ARROW = 0.5
ARROW_WIDTH = 0.022
THIN = 0.55
MARK_RADIUS = 0.03
TRACE_RADIUS = 0.005
SLIGHT = 3e-3
FAINT_MARK = 1e-9
# Nodes beyond these make a page slow; the largest impulses stay.
MOST_ARROWS = 400
HIDDEN_OPACITY = 0.3
TRACE_POINTS = 600
TRACES = ((0.07, 0.52, 0.50), (0.55, 0.36, 0.10), (0.62, 0.20, 0.48), (0.30, 0.38, 0.10))


@dataclass(frozen=True, eq=False)
class Effects:
    """The drawn effects.

    Attributes:
        arrows: by entry, joint or point, the nodes of its arrows.
        corners: (n, 3) the arrows' ends and the traces' points, for the camera [m].
        rows: of the legend, with the units of every kind of arrow.
        groups: by the group that a row names, the nodes that it switches.
        notes: what was left out.
    """

    arrows: Mapping[str, tuple[str, ...]]
    corners: np.ndarray
    rows: list[dict[str, str]]
    groups: Mapping[str, list[str]]
    notes: tuple[str, ...]


def draw_effects(
    drawing: Drawing,
    shown: Shown,
    actors: Actors,
    timeline: Timeline,
    *,
    points: Sequence[ReportPoint],
    velocities: bool,
    reactions: bool | Sequence[str],
    traces: Sequence[ReportPoint],
    hold: float | None,
) -> Effects:
    """Draw arrows and marks of all impacts and the traces of points.

    Args:
        hold: how long arrows stay, in playback time [s]; None for as long as it plays.
    """
    found = [
        (time, number, item)
        for number, (time, impact) in enumerate(shown.impacts)
        for item in impact_arrows(impact, points=points, velocities=velocities, reactions=reactions)
    ]
    found = _without_slight(found, actors.reach)
    marks = [
        (time, number, mark)
        for number, (time, impact) in enumerate(shown.impacts)
        for mark in impact_marks(impact)
    ]
    largest = largest_sizes(item for _, _, item in found)
    notes: list[str] = []
    if len(found) > MOST_ARROWS:
        notes.append(f"{len(found) - MOST_ARROWS} smaller arrows of {len(found)} are left out")
        found.sort(key=lambda entry: -entry[2].size / largest[entry[2].kind])
        found = sorted(found[:MOST_ARROWS], key=lambda entry: entry[:2])
    if len(marks) > MOST_ARROWS:
        notes.append(f"{len(marks) - MOST_ARROWS} later contact marks are left out")
        marks = marks[:MOST_ARROWS]
    nodes: dict[str, list[str]] = {}
    groups: dict[str, list[str]] = {}
    ends = [np.zeros((0, 3))]
    for i, (time, number, item) in enumerate(found):
        length = LONGEST_ARROW * actors.reach * item.size / largest[item.kind]
        path = ("impacts", str(number), node_name(i, f"{item.kind} {item.name}"))
        ends.append(_draw_arrow(drawing, path, item, length, actors.reach))
        _time(drawing, path, timeline, time, hold, before=item.kind == "before")
        nodes.setdefault(item.name, []).append(_node(path))
        groups.setdefault(item.kind, []).append(_node(path))
    for i, (time, number, mark) in enumerate(marks):
        path = ("impacts", str(number), node_name(i, f"contact {mark.name}"))
        _draw_mark(drawing, path, mark, actors.reach)
        groups.setdefault(f"contact {mark.mode}", []).append(_node(path))
        _time(drawing, path, timeline, time, hold, before=False)
    rows = _rows(largest, [mark for _, _, mark in marks])
    for i, point in enumerate(traces):
        line = _trace(shown, point)
        color = trace_color(i)
        node = ("traces", node_name(i, point.title))
        ends.append(line)
        if np.ptp(line, axis=0).max() > 0.0:
            surface = tube(line, TRACE_RADIUS * actors.reach)
            drawing.add(node, surface, color, glow=0.25)
        groups[node[-1]] = [_node(node)]
        rows.append(legend_row(f"path of {point.title}", color, group=node[-1]))
    return Effects(
        {name: tuple(paths) for name, paths in nodes.items()},
        np.concatenate(ends),
        rows,
        groups,
        tuple(notes),
    )


def _without_slight(
    found: list[tuple[float, int, Arrow]], size: float
) -> list[tuple[float, int, Arrow]]:
    """Leave out rounding, and couples that a small shift of the largest impulse makes up for."""
    largest = largest_sizes(item for _, _, item in found)
    blow = largest.get("impulse", 0.0)
    carried = max(largest.get("reaction", 0.0), blow)
    least = {
        "couple": SLIGHT * size * blow,
        "reaction": FAINT_MARK * blow,
        "reaction couple": max(SLIGHT * largest.get("reaction", 0.0), FAINT_MARK * carried) * size,
    }
    return [entry for entry in found if entry[2].size >= least.get(entry[2].kind, 0.0)]


def _draw_arrow(
    drawing: Drawing, path: tuple[str, ...], item: Arrow, length: float, size: float
) -> np.ndarray:
    """Draw an arrow; gives its two ends, (2, 3)."""
    color = KINDS[item.kind][2]
    # Thin before and thick after: the two are told apart without colours too.
    width = ARROW_WIDTH * (THIN if item.kind == "before" else 1.0)
    direction = item.vector / item.size
    couple = "couple" in item.kind
    start = item.origin
    if item.from_outside:
        # What strikes ends at the point that it strikes.
        start = item.origin - length * direction
    surface = arrow_surface(length, width * size, heads=2 if couple else 1)
    drawing.add((*path, "solid"), surface, color, glow=0.25)
    # A shade of it where it is inside a body or behind one.
    drawing.add((*path, "shade"), surface, (*color, HIDDEN_OPACITY), glow=0.5, through=True)
    drawing.place(path, pin.SE3(_turn_to(direction), start))
    return np.array([start, start + length * direction])


def _draw_mark(drawing: Drawing, path: tuple[str, ...], mark: Mark, size: float) -> None:
    drawing.add(path, disc(MARK_RADIUS * size, 0.2 * MARK_RADIUS * size), COLORS[mark.mode])
    drawing.place(path, pin.SE3(_turn_to(mark.normal), mark.position))


def _time(
    drawing: Drawing,
    path: tuple[str, ...],
    timeline: Timeline,
    time: float,
    hold: float | None,
    *,
    before: bool,
) -> None:
    """Show a node up to an impact, or from it on, for ``hold`` seconds of playback."""
    instant = float(timeline.to_playback(time))
    duration = timeline.duration
    if duration == 0.0:
        return
    if before:
        start, end = (0.0 if hold is None else max(0.0, instant - hold)), instant
    else:
        start, end = instant, (np.inf if hold is None else instant + hold)
    drawing.show_between(path, start, end, duration)


def _trace(shown: Shown, point: ReportPoint) -> np.ndarray:
    """(n, 3) the path of a point through the world [m]."""
    robot = shown.robot
    frame = robot.model.frames[robot.frame_id(point.frame, "replay: traces")]
    inside = frame.placement.act(np.array(point.at))
    data = robot.model.createData()
    line = []
    for q in shown.at(np.linspace(shown.start, shown.end, TRACE_POINTS)):
        pin.forwardKinematics(robot.model, data, q)
        line.append(data.oMi[frame.parentJoint].act(inside))
    return np.array(line)


def _rows(largest: Mapping[str, float], marks: Sequence[Mark]) -> list[dict[str, str]]:
    rows = []
    for kind, (words, unit, color) in KINDS.items():
        if largest.get(kind, 0.0) > 0.0:
            size = f"{largest[kind]:.4g} {unit}"
            text = f"{words}, the longest arrow {size}"
            rows.append(legend_row(text, color, group=kind, short=f"{words} ≤ {size}"))
    modes = {mark.mode for mark in marks}
    rows += [
        legend_row(f"contact, {mode}", color, group=f"contact {mode}")
        for mode, color in COLORS.items()
        if mode in modes
    ]
    return rows


def legend_row(
    text: str, color: Sequence[float], *, group: str = "", short: str = ""
) -> dict[str, str]:
    """A row of the legend: what it says, in short too, its colour, and what it switches."""
    return {"text": text, "short": short or text, "color": _css(color), "group": group}


def trace_color(i: int) -> tuple[float, float, float]:
    """A colour for the i-th path, each its own: the first few picked, then by the golden angle.

    Example:
        >>> len({trace_color(i) for i in range(50)})
        50
    """
    if i < len(TRACES):
        return TRACES[i]
    hue = (0.10 + 0.618034 * (i - len(TRACES))) % 1.0
    return colorsys.hsv_to_rgb(hue, 0.55 + 0.35 * (i % 2), 0.45 + 0.15 * (i % 3))


def _node(path: Sequence[str]) -> str:
    return "/" + "/".join((ROOT, *path))


def _css(color: Sequence[float]) -> str:
    red, green, blue = (round(255 * c) for c in color[:3])
    return f"rgb({red}, {green}, {blue})"


def _turn_to(direction: np.ndarray) -> np.ndarray:
    """(3, 3) a rotation that brings z to a unit direction."""
    across = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = across - direction * float(direction @ across)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(direction, first), direction])
