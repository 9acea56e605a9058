"""``report``: an impact as plain text, with units on every number."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..errors import RangeError, check_kind, quoted
from ..errors.calls import public
from ..formatting import ROUNDING, decimals, paper_decimals, table
from ..scene import AppliedImpulse
from ..scene.points import report_points
from .forms import FORMS, IMPULSE_UNITS, speeds_of, turns_of
from .outcome_report import outcome_blocks
from .touching import contacts_section, gap_lines

if TYPE_CHECKING:
    from ..impact import Impact, Outcomes
    from ..scene.points import ReportPoint

# So many links and joints are listed.
LARGEST = 3
# Loads below this share of the largest are shown as 0.
FAINT_LOAD = 1e-9


@public
def report(
    impact: Impact | Outcomes,
    points: Iterable[ReportPoint] = (),
    *,
    rows: int = 12,
    form: str = "text",
) -> str:
    """Report an impact in words and tables. Numbers at machine precision are shown as 0.

    Args:
        impact: a solved impact; or its ``Outcomes``, for intervals of v⁺ and of joint loads.
        points: points whose velocity is reported, in world axes; of an impact.
        rows: the largest number of joint speeds shown: those of a floating base, and those with
            the largest jumps.
        form: "text", "markdown" or "json", with the same content; ``Impact.to_dict`` has
            every number in full.

    Raises:
        RangeError: an unknown form.
        UnknownNameError: a point on a frame that the robot does not have.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> print(report(solve(scene, robot.neutral(), robot.velocity())).splitlines()[0])
        panda: 1 impulse, 9 degrees of freedom
    """
    from ..impact import Impact as AnImpact
    from ..impact import Outcomes as AllOutcomes

    if form not in FORMS:
        raise RangeError.of("report: form", quoted(form), " or ".join(map(quoted, FORMS)))
    if isinstance(impact, AllOutcomes):
        return FORMS[form](outcome_blocks(impact))
    check_kind(impact, AnImpact, "report")
    return FORMS[form](report_blocks(impact, points, rows=rows))


def report_blocks(
    impact: Impact, points: Iterable[ReportPoint] = (), *, rows: int = 12
) -> list[list[str]]:
    """Return the lines of a report, section by section; the first of each is its title."""
    blocks = [
        _head(impact),
        _points(impact, report_points(points, "report: points")),
        _speeds(impact, rows),
    ]
    blocks += [section(impact) for section in SECTIONS]
    return [block for block in blocks if block]


def _head(impact: Impact) -> list[str]:
    scene = impact.scene
    what = [_counted(len(scene.impulses), "impulse")]
    for kind in ("constraints", "contacts"):
        if count := len(getattr(scene, kind)):
            what.append(_counted(count, kind.removesuffix("s")))
    if scene.controlled:
        what.append(_counted(len(scene.controlled), "controlled joint"))
    what.append(f"{scene.robot.nv} degrees of freedom")
    return [
        f"{scene.robot.name}: {', '.join(what)}",
        f"{impact.status.name.lower()}: {impact.status.value}",
        *_uniqueness(impact),
        *(f"warning: {doubt}" for doubt in impact.doubts),
    ]


def _uniqueness(impact: Impact) -> list[str]:
    """Return a line on the uniqueness of v⁺, if the scene has contacts."""
    if not impact.scene.contacts:
        return []
    found = impact.uniqueness
    lines = [f"uniqueness of v⁺: {found.verdict}; {found.reason}"]
    if found.rule:
        lines.append(f"load split: {found.rule}")
    return lines


def _points(impact: Impact, points: Sequence[ReportPoint]) -> list[str]:
    if not points:
        return []
    velocities = [impact.velocity_at(point.frame, point.at) for point in points]
    states = {
        "before": [velocity.before for velocity in velocities],
        "after": [velocity.after for velocity in velocities],
    }
    scale = max(float(np.abs(each).max()) for each in states.values())
    title = "Velocity of points [m/s], world axes"
    if not np.any(states["before"]):
        del states["before"]
        title += "; all at rest before"
    head = ["point", *(f"{axis} {when}" for when in states for axis in "xyz")]
    rows = [
        [point.title, *(paper_decimals(x, scale) for each in states.values() for x in each[i])]
        for i, point in enumerate(points)
    ]
    return [title, *table(head, rows)]


def _speeds(impact: Impact, most: int) -> list[str]:
    speeds = speeds_of(impact.scene.robot, impact.q)
    scale = float(np.max(np.abs([impact.v_before, impact.v_after]), initial=0.0))
    largest = np.max(np.abs([impact.v_before, impact.dv]), axis=0)
    moving = np.flatnonzero(largest > ROUNDING * scale).tolist()
    if not moving:
        return ["Joint speeds: all stay zero"]
    # What a base does comes first: speeds of joints with several, then the largest jumps.
    by_jump = sorted(moving, key=lambda i: (not speeds[i].component, -abs(impact.dv[i])))
    shown = sorted(by_jump[: max(most, 1)])
    rows = [
        [
            speeds[i].title,
            *(decimals(x[i], scale) for x in (impact.v_before, impact.v_after, impact.dv)),
            speeds[i].unit,
        ]
        for i in shown
    ]
    lines = ["Joint speeds", *table(["joint", "before", "after", "jump", "unit"], rows)]
    if len(moving) > len(shown):
        lines.append(f"  {len(moving) - len(shown)} smaller ones not shown")
    still = len(speeds) - len(moving)
    if still:
        lines.append(f"  {still} other{'s stay' if still > 1 else ' stays'} zero")
    return lines


def _impulses(impact: Impact) -> list[str]:
    scene = impact.scene
    if not scene.impulses:
        return []
    turns = turns_of(impact)
    rows = []
    for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
        if isinstance(entry, AppliedImpulse):
            where = f"on {entry.frame}"
            parts = []
            if any(entry.linear):
                parts.append(f"{_listed(entry.linear)} N s")
            if any(entry.angular):
                parts.append(f"{_listed(entry.angular)} N m s")
            given = " and ".join(parts) or "nothing"
            if any(entry.at):
                given += f" at {_listed(entry.at)} m"
            if entry.axes != "world":
                given += f", {entry.axes} axes"
        else:
            where = f"in {entry.joint}"
            pairs = zip(entry.values, turns[entry.joint], strict=True)
            given = ", ".join(f"{x:g} {IMPULSE_UNITS[one].split(',')[0]}" for x, one in pairs)
        rows.append([name, where, given])
    return ["Impulses", *table(["name", "where", "impulse"], rows)]


def _constraints(impact: Impact) -> list[str]:
    if not impact.constraints:
        return []
    turns = turns_of(impact)
    speed_scale = float(np.abs([impact.v_before, impact.v_after]).max())
    rows = []
    notes = []
    for entry, result in zip(impact.scene.held, impact.constraints, strict=True):
        for i, row in enumerate(result.rows):
            joint = entry.joint_names[0] if entry.joint_names else ""
            turning = turns[joint][i] if joint else row.startswith("r")
            numbers = (result.impulse[i], result.velocity_before[i], result.velocity_after[i])
            scales = (np.abs(result.impulse).max(), speed_scale, speed_scale)
            shown = map(decimals, numbers, scales)
            rows.append([result.name, row, *shown, IMPULSE_UNITS[turning]])
        if not result.unique:
            free = [r for r, one in zip(result.rows, result.unique_rows, strict=True) if not one]
            notes.append(f"  {result.name}: only the resultant of {', '.join(free)} is determined")
    head = ["name", "row", "impulse", "velocity before", "after", "units"]
    anchors = [
        (result.name, result.gap)
        for entry, result in zip(impact.scene.held, impact.constraints, strict=True)
        if getattr(entry, "other_at", None) is not None
    ]
    return ["Constraints", *table(head, rows), *notes, *gap_lines("open by [m]", anchors)]


def _energy(impact: Impact) -> list[str]:
    energy = impact.energy
    scale = max(energy.before, energy.after, *map(abs, energy.work.values()), 0.0)
    rows = [["before", decimals(energy.before, scale)]]
    works = {name: decimals(work, scale) for name, work in energy.work.items()}
    rows += [[f"work of {name}", shown] for name, shown in works.items() if shown != "0"]
    rows += [["after", decimals(energy.after, scale)]]
    lines = ["Kinetic energy", *table(["entry", "J"], rows)]
    if idle := list(works.values()).count("0"):
        lines.append(f"  {_counted(idle, 'entry', 'entries')} without work")
    return [*lines, f"  energy balance error {energy.imbalance:.1e} of the largest entry"]


def _links(impact: Impact) -> list[str]:
    sizes = {
        name: (float(np.linalg.norm(jump.dv_com)), float(np.linalg.norm(jump.domega)))
        for name, jump in impact.bodies.items()
    }
    linear = max((size[0] for size in sizes.values()), default=0.0)
    angular = max((size[1] for size in sizes.values()), default=0.0)
    largest = sorted(sizes, key=lambda name: -sizes[name][0])[:LARGEST]
    rows = [
        [name, decimals(sizes[name][0], linear), decimals(sizes[name][1], angular)]
        for name in largest
        if any(sizes[name])
    ]
    if not rows:
        return []
    head = ["link", "mass centre, m/s", "rotation, rad/s"]
    return [f"Largest jumps of links ({len(rows)} of {len(sizes)})", *table(head, rows)]


def _joint_loads(impact: Impact) -> list[str]:
    """Return the joints that the impact bends or turns most, for bearings and gears."""
    loads = [load for load in impact.joint_loads.values() if load.axis is not None]
    force = max((float(np.linalg.norm(load.force)) for load in loads), default=0.0)
    moment = max((float(np.linalg.norm(load.moment)) for load in loads), default=0.0)
    # Beside a force, a moment counts by its lever: moments alone may all be rounding.
    lever = max(
        (float(np.linalg.norm(x.com_in_joint)) for x in impact.scene.robot.links), default=0
    )
    moment = max(moment, force * lever)
    turned = {load.joint: max(load.bending, abs(load.torque)) for load in loads}
    pushed = {load.joint: max(load.shear, abs(load.axial)) for load in loads}
    loads = [
        load
        for load in loads
        if turned[load.joint] > FAINT_LOAD * moment or pushed[load.joint] > FAINT_LOAD * force
    ]
    loads.sort(
        key=lambda load: (
            -turned[load.joint] if turned[load.joint] > FAINT_LOAD * moment else 0.0,
            -pushed[load.joint],
        )
    )
    rows = [
        [
            load.joint,
            *(decimals(x, force, FAINT_LOAD) for x in (load.axial, load.shear)),
            *(decimals(x, moment, FAINT_LOAD) for x in (load.bending, load.torque)),
        ]
        for load in loads[:LARGEST]
    ]
    if not rows or not max(force, moment):
        return []
    head = ["joint", "axial, N s", "shear, N s", "bending, N m s", "torque, N m s"]
    lines = [f"Largest joint loads ({len(rows)} of {len(loads)})", *table(head, rows)]
    if not np.any(impact.scene.robot.model.armature):
        lines.append("  no rotor inertia is known: geared joints count as free and carry no torque")
    return lines


def _residuals(impact: Impact) -> list[str]:
    residuals = impact.residuals
    parts = {"momentum": residuals.momentum}
    # Rows that a scene does not have have no residual.
    parts |= {
        name: value
        for name in ("constraint", "complementarity")
        if (value := getattr(residuals, name)) != 0.0
    }
    listed = ", ".join(f"{name} {value:.1e}" for name, value in parts.items())
    return [f"Residuals, relative: {listed}"]


def _counted(count: int, what: str, plural: str = "") -> str:
    return f"{count} {what if count == 1 else plural or what + 's'}"


def _listed(numbers: Iterable[float]) -> str:
    return "(" + ", ".join(f"{x:g}" for x in numbers) + ")"


# The sections after the velocities, in order; one without content returns nothing.
SECTIONS: tuple[Callable[[Impact], list[str]], ...] = (
    _impulses,
    _constraints,
    contacts_section,
    _energy,
    _links,
    _joint_loads,
    _residuals,
)
