"""Drawings beside the bodies: arrows and marks of impacts, contact forces, paths of points."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from .arrows import KINDS, MODES, Arrow, impact_arrows, largest_sizes, summary
from .bodies import joint_places
from .drawing import Drawing, Tube, arrow, cylinder, node_name, node_path
from .motions import Shown, resting_forces, triad
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
GLOW = 0.25
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
        impacts: for each impact, the playback times of its arrows and its line on the page.
        arrows: by entry, joint or point, the nodes of its arrows.
        labels: the nodes of arrows and marks, with the label of each.
        forces: of contacts between impacts: name, playback times [s] and sizes [N].
        ends: (n, 3) arrays: the arrows' ends and the traces' points, for the camera [m].
        rows: of the legend, with the units of every kind of arrow.
        groups: by the group that a row names, the nodes that it switches.
        notes: how many arrows and marks were left out.
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
        node = node_path(path)
        self.groups.setdefault(group, []).append(node)
        self.labels.append((node, label))
        return node


def draw_effects(
    drawing: Drawing,
    shown: Shown,
    timeline: Timeline,
    size: float,
    *,
    traces: Sequence[ReportPoint] = (),
    hold: float | None = None,
    **options: Any,
) -> Effects:
    """Draw arrows and marks of all impacts, contact forces between them, and paths of points.

    Args:
        size: of the picture [m].
        hold: how long arrows stay, in playback time [s]; None for as long as it plays. The
            arrows of an impact go when those of the next one come.
        options: of ``impact_arrows``.
    """
    found = [impact_arrows(impact, **options) for _, impact in shown.impacts]
    spans = _spans(shown, timeline, hold)
    effects = Effects(
        [
            {"time": start, "end": min(end, timeline.duration), "text": summary(arrows)}
            for (_, start, end), arrows in zip(spans, found, strict=True)
        ]
    )
    _draw_impacts(drawing, effects, found, spans, timeline.duration, size)
    _draw_forces(drawing, effects, shown, timeline, size)
    for i, point in enumerate(traces):
        line = _trace(shown, point)
        color = trace_color(i)
        node = ("traces", node_name(i, point.title))
        effects.ends.append(line)
        if np.ptp(line, axis=0).max() > 0.0:
            drawing.add(node, Tube(line, TRACE_RADIUS * size), color, glow=GLOW)
        effects.add(node, node[-1], f"path of {point.title}")
        effects.rows.append(legend_row(f"path of {point.title}", color, group=node[-1]))
    return effects


def _spans(
    shown: Shown, timeline: Timeline, hold: float | None
) -> list[tuple[float, float, float]]:
    """Return by impact, in playback time: start of the arrows before it, its instant, its end."""
    times = [float(timeline.to_playback(time)) for time, _ in shown.impacts]
    stays = np.inf if hold is None else hold
    spans = []
    for time in times:
        last = max((other for other in times if other < time), default=-np.inf)
        following = min((other for other in times if other > time), default=np.inf)
        spans.append((max(0.0, last, time - stays), time, min(following, time + stays)))
    return spans


def _draw_impacts(
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
    marks = [entry for entry in every if entry[1].kind == "contact"]
    arrows = [entry for entry in every if entry[1].kind != "contact"]
    if len(arrows) > MOST_ARROWS:
        effects.notes.append(f"showing the {MOST_ARROWS} largest of {len(arrows)} arrows")
        arrows.sort(key=lambda entry: -entry[1].size / largest[entry[1].kind])
        arrows = sorted(arrows[:MOST_ARROWS], key=lambda entry: entry[0])
    if len(marks) > MOST_ARROWS:
        effects.notes.append(f"{len(marks) - MOST_ARROWS} later contact marks left out")
    for i, (number, item) in enumerate([*arrows, *marks[:MOST_ARROWS]]):
        path = ("impacts", str(number), node_name(i, f"{item.kind} {item.name}"))
        start, instant, end = spans[number]
        span = (start, instant) if item.kind == "before" else (instant, end)
        node = effects.add(path, item.group, item.label)
        if item.kind == "contact":
            disc = cylinder(MARK_RADIUS * size, 0.1 * MARK_RADIUS * size)
            drawing.add(path, disc, item.color, shade=ON_TOP)
            drawing.place(path, pin.SE3(triad(item.vector), item.origin))
        else:
            length = LONGEST_ARROW * size * item.size / largest[item.kind]
            effects.ends.append(_draw_arrow(drawing, path, item, length, size))
            effects.arrows[item.name] = (*effects.arrows.get(item.name, ()), node)
        drawing.show_between(path, *span, duration)
    effects.rows += [_arrow_row(kind, largest[kind]) for kind in KINDS if largest.get(kind)]
    effects.rows += [
        legend_row(f"contact, {mode}", color, group=f"contact {mode}")
        for mode, color in MODES.items()
        if any(item.mode == mode for _, item in marks)
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
    length = LONGEST_ARROW * size
    for i, (name, (places, forces)) in enumerate(carried.items()):
        path = ("forces", node_name(i, name))
        shape = arrow(length, ARROW_WIDTH * size)
        drawing.add(path, shape, KINDS["force"][2], glow=GLOW, shade=HIDDEN_OPACITY)
        sizes = np.linalg.norm(forces, axis=1)
        poses = np.empty((count, 7))
        turn = np.eye(3)
        for pose, place, force, much in zip(poses, places, forces, sizes, strict=True):
            turn = triad(force / much) if much > 0.0 else turn
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
    impulse = largest.get("impulse", 0.0)
    carried = max(largest.get("reaction", 0.0), impulse)
    least = {
        "couple": SLIGHT * size * impulse,
        "reaction": FAINT_MARK * impulse,
        "reaction couple": max(SLIGHT * largest.get("reaction", 0.0), FAINT_MARK * carried) * size,
    }
    return [entry for entry in found if entry[1].size >= least.get(entry[1].kind, 0.0)]


def _draw_arrow(
    drawing: Drawing, path: tuple[str, ...], item: Arrow, length: float, size: float
) -> np.ndarray:
    """Draw an arrow and return its two ends, (2, 3)."""
    # Thin before and thick after: the two are told apart without colours too.
    width = ARROW_WIDTH * (THIN if item.kind == "before" else 1.0)
    direction = item.vector / item.size
    # An applied impulse ends at the point where it acts.
    start = item.origin - length * direction if item.from_outside else item.origin
    shape = arrow(length, width * size, heads=2 if "couple" in item.kind else 1)
    # A shade of it where it is inside a body or behind one.
    drawing.add(path, shape, item.color, glow=GLOW, shade=HIDDEN_OPACITY)
    drawing.place(path, pin.SE3(triad(direction), start))
    return np.array([start, start + length * direction])


def _trace(shown: Shown, point: ReportPoint) -> np.ndarray:
    """Return (n, 3): the path of a point through the world [m]."""
    robot = shown.robot
    frame = robot.model.frames[robot.frame_id(point.frame, "replay: traces")]
    inside = frame.placement.act(np.array(point.at))
    places = joint_places(shown, np.linspace(shown.start, shown.end, TRACE_POINTS))
    return np.array([pin.XYZQUATToSE3(x).act(inside) for x in places[:, frame.parentJoint]])


def _arrow_row(kind: str, largest: float) -> dict[str, str]:
    words, unit, color = KINDS[kind]
    size = f"{largest:.4g} {unit}"
    return legend_row(
        f"{words}, the longest arrow {size}", color, group=kind, short=f"{words} ≤ {size}"
    )


def legend_row(
    text: str, color: Sequence[float], *, group: str = "", short: str = ""
) -> dict[str, str]:
    """Return a row of the legend: its text, also in short, its colour, the group it switches."""
    css = f"rgb({', '.join(str(round(255 * c)) for c in color[:3])})"
    return {"text": text, "short": short or text, "color": css, "group": group}


def trace_color(i: int) -> tuple[float, float, float]:
    """Return a colour for the i-th path, each its own: a few picked, then by the golden angle.

    Example:
        >>> len({trace_color(i) for i in range(50)})
        50
    """
    if i < len(TRACES):
        return TRACES[i]
    hue = (0.10 + 0.618034 * (i - len(TRACES))) % 1.0
    return colorsys.hsv_to_rgb(hue, 0.55 + 0.35 * (i % 2), 0.45 + 0.15 * (i % 3))
