"""Contact impulses in their friction cones."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...scene.friction import static_friction
from .canvas import BEFORE, CYCLE, axes_or_new, ink_of, on_sheet, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...impact import Impact

__all__ = ["contact_cones"]

MARKERS = {"sticking": "o", "sliding": "s", "separated": "x"}
# More names than these would hide the points.
MOST_NAMES = 12


def contact_cones(impact: Impact, ax: Axes | None = None) -> Axes:
    """The impulse of every contact point, tangential against normal, in its cone [N s].

    A point on the edge of the shaded wedge slides, one within it sticks. It is drawn to the
    right where friction points along the axis in which it is largest, else to the left.

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
        ax.plot(tangential, normal, MARKERS[point.mode], color=ink_of(ax), label=label, zorder=3)
        # Points that fall on one another share a label.
        place = (round(tangential / top, 3) * top, round(normal / top, 3) * top)
        names.setdefault(place, []).append(name)
    if not found:
        ax.text(0.5, 0.5, "nothing touches", transform=ax.transAxes, ha="center", color=BEFORE)
    ax.set_xlabel("tangential impulse [N s]")
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
    """A few names that share a place; of more, how many."""
    names = list(dict.fromkeys(names))
    return ", ".join(names[:2]) + (f" and {len(names) - 2} more" if len(names) > 2 else "")
