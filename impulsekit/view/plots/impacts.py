"""An impact in plots: the velocity jump, reactions, impulses in their cones, the energy balance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import RangeError, check_kind
from ...errors.calls import public
from ...scene.coefficients import static_friction
from ..forms import speeds_of
from .canvas import AFTER, BEFORE, CYCLE, IMPULSE, QUIET, axes_or_new, ink, on_sheet, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...impact import Impact


@public
def velocity_jump(impact: Impact, ax: Axes | None = None, *, rows: int = 30) -> Axes:
    """Draw every joint speed before and after; rad/s and m/s on axes of their own.

    Args:
        impact: the impact.
        ax: where to draw; a new figure if None. Where there are both units, further axes
            take a part of its place, below it.
        rows: how many speeds are drawn at most, those that jump most.

    Raises:
        InputError: no ``Impact``.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> ax = velocity_jump(solve(scene, robot.neutral(), robot.velocity()))
        >>> ax.get_yticklabels()[0].get_text()
        'panda_joint1 [rad/s]'
    """
    from ...impact import Impact as AnImpact

    check_kind(impact, AnImpact, "velocity_jump")
    speeds = speeds_of(impact.scene.robot, impact.q)
    chosen = np.sort(np.argsort(-np.abs(impact.dv), kind="stable")[: max(rows, 1)])
    units = list(dict.fromkeys(speeds[i].unit for i in chosen))
    groups = [[i for i in chosen if speeds[i].unit == unit] for unit in units]
    ax = axes_or_new(ax, 1.2 + 0.7 * len(units) + 0.28 * len(chosen))
    panels = _stacked(ax, [len(group) + 1.5 for group in groups])
    for panel, unit, group in zip(panels, units, groups, strict=True):
        y = np.arange(len(group))
        before, after = impact.v_before[group], impact.v_after[group]
        panel.axvline(0.0, color=QUIET, linewidth=0.8)
        panel.hlines(y, before, after, color=AFTER, alpha=0.45, linewidth=3)
        panel.plot(before, y, "o", color=BEFORE, markersize=5, label="before")
        panel.plot(after, y, "o", color=AFTER, markersize=6, label="after")
        panel.set_yticks(y, [plain(f"{speeds[i].title} [{unit}]") for i in group])
        panel.set_ylim(len(group) - 0.4, -0.6)
        panel.set_xlabel(f"speed [{unit}]")
        tidy(panel)
    left = len(speeds) - len(chosen)
    ax.set_title("Joint speeds" + (f"\n({left} smaller not shown)" if left else ""), loc="left")
    if groups:
        ax.legend(frameon=False)
    return tidy(ax)


def _stacked(ax: Axes, shares: list[float]) -> list[Axes]:
    """Return ``ax`` and further axes below it that share its place, as high as ``shares`` say."""
    if len(shares) < 2:
        return [ax][: len(shares)]
    figure, spec = ax.figure, ax.get_subplotspec()
    if spec is None:
        # Axes that stand where they were put: that place is divided.
        place = ax.get_position()
        edges = {"left": place.x0, "right": place.x1, "bottom": place.y0, "top": place.y1}
        spec = figure.add_gridspec(1, 1, **edges)[0]
    cells = spec.subgridspec(len(shares), 1, height_ratios=shares)
    ax.set_subplotspec(cells[0])
    return [ax, *(figure.add_subplot(cells[i]) for i in range(1, len(shares)))]


PARTS = {
    "force": (slice(0, 3), "N s", "Force impulse in the joints"),
    "couple": (slice(3, 6), "N m s", "Couple impulse in the joints"),
}

FAINT_BAR = 1e-10


@public
def joint_reactions(
    impact: Impact, ax: Axes | None = None, *, part: str = "force", rows: int = 30
) -> Axes:
    """Draw the reaction impulse of every moving joint, as bars of its size.

    Args:
        impact: the impact.
        ax: where to draw; a new figure if None.
        part: "force" [N s] or "couple" about the joint's origin [N m s].
        rows: how many joints are drawn at most, the most loaded.

    Raises:
        RangeError: another part.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> ax = joint_reactions(solve(scene, robot.neutral(), robot.velocity()))
        >>> ax.get_xlabel(), len(ax.patches)
        ('size [N s]', 9)
    """
    if part not in PARTS:
        raise RangeError.of("joint_reactions: part", repr(part), '"force" or "couple"')
    _, unit, title = PARTS[part]
    names = impact.scene.robot.joint_names
    sizes = reaction_sizes(impact, part)
    chosen = np.sort(np.argsort(-sizes, kind="stable")[: max(rows, 1)])
    ax = axes_or_new(ax, 1.2 + 0.28 * len(chosen))
    y = np.arange(len(chosen))
    ax.barh(y, sizes[chosen], height=0.62, color=CYCLE[3])
    ax.set_yticks(y, [plain(names[i]) for i in chosen])
    ax.invert_yaxis()
    ax.set_xlabel(f"size [{unit}]")
    left = len(names) - len(chosen)
    ax.set_title(title + (f"\n({left} smaller not shown)" if left else ""), loc="left")
    return tidy(ax)


def reaction_sizes(impact: Impact, part: str) -> np.ndarray:
    """Return (joints,): the sizes of one part of the reactions, zero where they are rounding."""
    where = PARTS[part][0]
    wrenches = np.array([impact.reactions[name] for name in impact.scene.robot.joint_names])
    wrenches = wrenches.reshape(-1, 6)
    sizes = np.linalg.norm(wrenches[:, where], axis=1)
    sizes[sizes < FAINT_BAR * np.abs(wrenches).max(initial=0.0)] = 0.0
    return sizes


MARKERS = {"sticking": "o", "sliding": "s", "separated": "x"}
# More names than these would hide the points.
MOST_NAMES = 12


@public
def contact_cones(impact: Impact, ax: Axes | None = None) -> Axes:
    """Draw the impulse of every contact point, tangential against normal, in its cone [N s].

    A point on the edge of the shaded wedge slides, one within it sticks. It is drawn to the
    right where friction points towards +x (or +y, +z, where it is largest along that axis),
    else to the left; both impulses are those that the first body receives.

    Args:
        impact: the impact.
        ax: where to draw; a new figure if None.

    Raises:
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, solve
        >>> robot = Robot.from_example("solo12", root="freeflyer")
        >>> scene = Scene(robot, contacts=[Contact("FL_FOOT", friction=0.5)])
        >>> v = robot.velocity(root_joint=[0.1, 0, -1, 0, 0, 0])
        >>> contact_cones(solve(scene, robot.neutral(), v)).get_ylabel()
        'normal impulse [N s]'
    """
    ax = axes_or_new(ax)
    found = [
        (result.name, static_friction(getattr(entry, "friction", 0.0)), point.normal, point)
        for entry, result in zip(impact.scene.contacts, impact.contacts, strict=True)
        for point in result.points
        if point.normal is not None
    ]
    normals = [float(axis @ point.impulse) for _, _, axis, point in found]
    top = 1.12 * max(normals, default=0.0) or 1.0
    for i, friction in enumerate(sorted({friction for _, friction, _, _ in found})):
        color = CYCLE[i % len(CYCLE)]
        edge = np.array([0.0, friction * top])
        ax.fill_betweenx([0.0, top], -edge, edge, color=color, alpha=0.10, linewidth=0)
        ax.plot([-edge[1], 0.0, edge[1]], [top, 0.0, top], color=color, linewidth=1.0)
        ax.plot([], [], color=color, label=f"cone of µ = {friction:g}")
    used: set[str] = set()
    names: dict[tuple[float, float], list[str]] = {}
    for (name, _, axis, point), normal in zip(found, normals, strict=True):
        across = point.impulse - normal * axis
        # The side tells whether friction points along +x (then +y, then +z) or against it.
        lead = across[int(np.argmax(np.abs(across)))]
        tangential = float(np.copysign(np.linalg.norm(across), lead))
        label = point.mode if point.mode not in used else None
        used.add(point.mode)
        ax.plot(tangential, normal, MARKERS[point.mode], color=ink(), label=label, zorder=3)
        # Points that fall on one another share a label.
        place = (round(tangential / top, 3) * top, round(normal / top, 3) * top)
        names.setdefault(place, []).append(name)
    if not found:
        ax.text(0.5, 0.5, "nothing touches", transform=ax.transAxes, ha="center", color=BEFORE)
    ax.set_xlabel("tangential impulse [N s]\n(right: towards +x, +y or +z)")
    ax.set_ylabel("normal impulse [N s]")
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    ax.set_title("Contact impulses in their cones", loc="left")
    # Beside the cones there is room for names.
    ax.margins(x=0.25)
    if found:
        ax.legend(frameon=False, fontsize=8, loc="best")
    tidy(ax)
    if len(names) <= MOST_NAMES:
        on_sheet(ax, [(x, y, plain(_listed(group))) for (x, y), group in names.items()])
    return ax


def _listed(names: list[str]) -> str:
    """Return a few names that share a place; of more, how many."""
    names = list(dict.fromkeys(names))
    return ", ".join(names[:2]) + (f" and {len(names) - 2} more" if len(names) > 2 else "")


@public
def energy_balance(impact: Impact, ax: Axes | None = None) -> Axes:
    """Draw the energy balance as steps from the kinetic energy before to that after [J].

    Green work is given to the bodies, red work taken from them.

    Args:
        impact: the impact.
        ax: where to draw; a new figure if None.

    Raises:
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1], name="blow")])
        >>> ax = energy_balance(solve(scene, robot.neutral(), robot.velocity()))
        >>> [label.get_text() for label in ax.get_yticklabels()]
        ['before', 'work of blow', 'after']
    """
    energy = impact.energy
    works = list(energy.work.values())
    levels = energy.before + np.cumsum([0.0, *works])
    starts = [0.0, *levels[:-1], 0.0]
    lengths = [energy.before, *works, energy.after]
    colors = [BEFORE, *(CYCLE[2] if work >= 0.0 else IMPULSE for work in works), AFTER]
    ax = axes_or_new(ax, 1.4 + 0.4 * len(lengths))
    y = np.arange(len(lengths))
    ax.barh(y, lengths, left=starts, height=0.6, color=colors)
    for i, level in enumerate(levels):
        ax.plot([level, level], [i - 0.3, i + 1.3], color=QUIET, linewidth=0.9)
    for i, (start, length) in enumerate(zip(starts, lengths, strict=True)):
        ax.annotate(
            f"{length:.4g} J",
            (max(start, start + length), i),
            xytext=(5, 0),
            textcoords="offset points",
            va="center",
            fontsize=8,
            color=ink(),
        )
    ax.set_yticks(y, ["before", *(plain(f"work of {name}") for name in energy.work), "after"])
    ax.invert_yaxis()
    ax.margins(x=0.18)
    ax.set_xlim(left=min(0.0, ax.get_xlim()[0]) if min(levels) < 0.0 else 0.0)
    ax.set_xlabel("kinetic energy [J]")
    ax.set_title("Energy balance: work on the bodies is positive", loc="left")
    return tidy(ax)
