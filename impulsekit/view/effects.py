"""Drawings beside the bodies: arrows and marks of impacts, and traces of points."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from .arrows import COLORS, KINDS, Arrow, impact_arrows, impact_marks, largest_sizes, summary
from .drawing import ROOT, Drawing, node_name
from .motions import Shown, resting_forces
from .surfaces import arrow as arrow_surface
from .surfaces import cylinder, tube
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
HIDDEN_OPACITY = 0.5
ON_TOP = 0.9
# Contact forces are drawn so often in a second of playback, and so often at most.
FORCES_A_SECOND = 20.0
MOST_FORCES = 1200
# In place of a scale of zero, which turns no normals.
NO_SCALE = 1e-6
TRACE_POINTS = 600
TRACES = ((0.07, 0.52, 0.50), (0.55, 0.36, 0.10), (0.62, 0.20, 0.48), (0.30, 0.38, 0.10))


@dataclass(eq=False)
class Effects:
    """The drawn effects.

    Attributes:
        impacts: for each impact, the playback times of its arrows and what the page says of it.
        arrows: by entry, joint or point, the nodes of its arrows.
        labels: the nodes of arrows and marks, with what the page says of each.
        forces: of contacts between impacts: name, playback times [s] and sizes [N].
        ends: (n, 3) arrays: the arrows' ends and the traces' points, for the camera [m].
        rows: of the legend, with the units of every kind of arrow.
        groups: by the group that a row names, the nodes that it switches.
        notes: what was left out.
    """

    impacts: list[dict[str, Any]]
    arrows: dict[str, tuple[str, ...]] = field(default_factory=dict)
    labels: list[tuple[str, str]] = field(default_factory=list)
    forces: list[dict[str, Any]] = field(default_factory=list)
    ends: list[np.ndarray] = field(default_factory=list)
    rows: list[dict[str, str]] = field(default_factory=list)
    groups: dict[str, list[str]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def add(self, path: Sequence[str], group: str, label: str) -> str:
        """Take in a node of a group, with its label; returns its path in the player."""
        node = "/" + "/".join((ROOT, *path))
        self.groups.setdefault(group, []).append(node)
        self.labels.append((node, label))
        return node


def draw_effects(
    drawing: Drawing,
    shown: Shown,
    timeline: Timeline,
    size: float,
    *,
    points: Sequence[ReportPoint],
    velocities: bool,
    reactions: bool | Sequence[str],
    traces: Sequence[ReportPoint],
    hold: float | None,
) -> Effects:
    """Draw arrows and marks of all impacts, contact forces between them, and paths of points.

    Args:
        size: of the picture [m].
        hold: how long arrows stay, in playback time [s]; None for as long as it plays. The
            arrows of an impact go when those of the next one come.
    """
    found = [
        impact_arrows(impact, points=points, velocities=velocities, reactions=reactions)
        for _, impact in shown.impacts
    ]
    spans = _spans(shown, timeline, hold)
    effects = Effects(
        [
            {"time": start, "end": min(end, timeline.duration), "said": summary(arrows)}
            for (_, start, end), arrows in zip(spans, found, strict=True)
        ]
    )
    _draw_arrows(drawing, effects, found, spans, timeline.duration, size)
    _draw_marks(drawing, effects, shown, spans, timeline.duration, size)
    _draw_forces(drawing, effects, shown, timeline, size)
    for i, point in enumerate(traces):
        line = _trace(shown, point)
        color = trace_color(i)
        node = ("traces", node_name(i, point.title))
        effects.ends.append(line)
        if np.ptp(line, axis=0).max() > 0.0:
            drawing.add(node, tube(line, TRACE_RADIUS * size), color, glow=0.25)
        effects.add(node, node[-1], f"path of {point.title}")
        effects.rows.append(legend_row(f"path of {point.title}", color, group=node[-1]))
    return effects


def _spans(
    shown: Shown, timeline: Timeline, hold: float | None
) -> list[tuple[float, float, float]]:
    """Of each impact in playback time: when what was before it begins to show, it, and its end."""
    times = [float(timeline.to_playback(time)) for time, _ in shown.impacts]
    spans = []
    for time in times:
        last = max((other for other in times if other < time), default=-np.inf)
        following = min((other for other in times if other > time), default=np.inf)
        stays = np.inf if hold is None else hold
        spans.append((max(0.0, last, time - stays), time, min(following, time + stays)))
    return spans


def _draw_arrows(
    drawing: Drawing,
    effects: Effects,
    found: Sequence[Sequence[Arrow]],
    spans: Sequence[tuple[float, float, float]],
    duration: float,
    size: float,
) -> None:
    every = [(number, item) for number, arrows in enumerate(found) for item in arrows]
    every = _without_slight(every, size)
    largest = largest_sizes(item for _, item in every)
    if len(every) > MOST_ARROWS:
        effects.notes.append(f"{len(every) - MOST_ARROWS} smaller arrows of {len(every)} left out")
        every.sort(key=lambda entry: -entry[1].size / largest[entry[1].kind])
        every = sorted(every[:MOST_ARROWS], key=lambda entry: entry[0])
    for i, (number, item) in enumerate(every):
        length = LONGEST_ARROW * size * item.size / largest[item.kind]
        path = ("impacts", str(number), node_name(i, f"{item.kind} {item.name}"))
        effects.ends.append(_draw_arrow(drawing, path, item, length, size))
        start, instant, end = spans[number]
        span = (start, instant) if item.kind == "before" else (instant, end)
        drawing.show_between(path, *span, duration)
        node = effects.add(path, item.kind, item.label)
        effects.arrows[item.name] = (*effects.arrows.get(item.name, ()), node)
    effects.rows += [_arrow_row(kind, largest[kind]) for kind in KINDS if largest.get(kind)]


def _draw_marks(
    drawing: Drawing,
    effects: Effects,
    shown: Shown,
    spans: Sequence[tuple[float, float, float]],
    duration: float,
    size: float,
) -> None:
    marks = [
        (k, mark) for k, (_, impact) in enumerate(shown.impacts) for mark in impact_marks(impact)
    ]
    if len(marks) > MOST_ARROWS:
        effects.notes.append(f"{len(marks) - MOST_ARROWS} later contact marks left out")
    for i, (number, mark) in enumerate(marks[:MOST_ARROWS]):
        path = ("impacts", str(number), node_name(i, f"contact {mark.name}"))
        disc = cylinder(MARK_RADIUS * size, 0.1 * MARK_RADIUS * size)
        drawing.add(path, disc, COLORS[mark.mode], shade=ON_TOP)
        drawing.place(path, pin.SE3(_turn_to(mark.normal), mark.position))
        drawing.show_between(path, *spans[number][1:], duration)
        effects.add(path, f"contact {mark.mode}", f"{mark.name}: {mark.mode}")
    modes = {mark.mode for _, mark in marks}
    effects.rows += [
        legend_row(f"contact, {mode}", color, group=f"contact {mode}")
        for mode, color in COLORS.items()
        if mode in modes
    ]


def _draw_forces(
    drawing: Drawing, effects: Effects, shown: Shown, timeline: Timeline, size: float
) -> None:
    """Draw the resultant of every contact that pushes between impacts, as it changes."""
    count = min(MOST_FORCES, 1 + int(FORCES_A_SECOND * timeline.duration))
    times = np.linspace(0.0, timeline.duration, count)
    carried = resting_forces(shown, timeline.to_motion(times))
    largest = max(
        (float(np.linalg.norm(f, axis=1).max()) for _, f in carried.values()), default=0.0
    )
    for i, (name, (places, forces)) in enumerate(carried.items()):
        path = ("forces", node_name(i, name))
        length = LONGEST_ARROW * size
        color = KINDS["force"][2]
        surface = arrow_surface(length, ARROW_WIDTH * size)
        drawing.add(path, surface, color, glow=0.25, shade=HIDDEN_OPACITY)
        sizes = np.linalg.norm(forces, axis=1)
        poses = np.empty((count, 7))
        turn = np.eye(3)
        for pose, place, force, much in zip(poses, places, forces, sizes, strict=True):
            turn = _turn_to(force / much) if much > 0.0 else turn
            pose[:] = pin.SE3ToXYZQUAT(pin.SE3(turn, place))
        drawing.move(path, times, poses, np.maximum(sizes / largest, NO_SCALE))
        effects.add(path, "force", f"{name}: contact force")
        effects.ends.append(places + length / largest * forces)
        rounded = [float(f"{much:.3g}") for much in sizes]
        effects.forces.append({"name": name, "times": times.round(4).tolist(), "sizes": rounded})
    if largest > 0.0:
        effects.rows.append(_arrow_row("force", largest))


def _without_slight(found: list[tuple[int, Arrow]], size: float) -> list[tuple[int, Arrow]]:
    """Leave out rounding, and couples that a small shift of the largest impulse makes up for."""
    largest = largest_sizes(item for _, item in found)
    blow = largest.get("impulse", 0.0)
    carried = max(largest.get("reaction", 0.0), blow)
    least = {
        "couple": SLIGHT * size * blow,
        "reaction": FAINT_MARK * blow,
        "reaction couple": max(SLIGHT * largest.get("reaction", 0.0), FAINT_MARK * carried) * size,
    }
    return [entry for entry in found if entry[1].size >= least.get(entry[1].kind, 0.0)]


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
    # A shade of it where it is inside a body or behind one.
    drawing.add(path, surface, color, glow=0.25, shade=HIDDEN_OPACITY)
    drawing.place(path, pin.SE3(_turn_to(direction), start))
    return np.array([start, start + length * direction])


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


def _arrow_row(kind: str, largest: float) -> dict[str, str]:
    words, unit, color = KINDS[kind]
    size = f"{largest:.4g} {unit}"
    return legend_row(
        f"{words}, the longest arrow {size}", color, group=kind, short=f"{words} ≤ {size}"
    )


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


def _css(color: Sequence[float]) -> str:
    red, green, blue = (round(255 * c) for c in color[:3])
    return f"rgb({red}, {green}, {blue})"


def _turn_to(direction: np.ndarray) -> np.ndarray:
    """(3, 3) a rotation that brings z to a unit direction."""
    across = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = across - direction * float(direction @ across)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(direction, first), direction])
