"""The velocity jump, joint by joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import check_kind
from ..speeds import speeds_of
from .canvas import AFTER, BEFORE, QUIET, axes_or_new, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...impact import Impact

__all__ = ["velocity_jump"]


def velocity_jump(impact: Impact, ax: Axes | None = None, *, rows: int = 30) -> Axes:
    """Every joint speed before and after; rad/s and m/s on axes of their own.

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
    """``ax`` and further axes below it that share its place, as high as ``shares`` say."""
    if len(shares) < 2:
        return [ax][: len(shares)]
    figure = ax.figure
    spec = ax.get_subplotspec()
    if spec is not None:
        cells = spec.subgridspec(len(shares), 1, height_ratios=shares)
        ax.set_subplotspec(cells[0])
        return [ax, *(figure.add_subplot(cells[i]) for i in range(1, len(shares)))]
    # Axes that stand where they were put: each gets its part of that place.
    place = ax.get_position()
    gap = 0.16 * place.height
    height = place.height - gap * (len(shares) - 1)
    panels, top = [], place.y1
    for i, share in enumerate(shares):
        size = height * share / sum(shares)
        bounds = (place.x0, top - size, place.width, size)
        panels.append(ax if i == 0 else figure.add_axes(bounds))
        panels[-1].set_position(bounds)
        top -= size + gap
    return panels
