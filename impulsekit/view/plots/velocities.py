"""The velocity jump, joint by joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..speeds import speeds_of
from .canvas import AFTER, BEFORE, QUIET, axes_or_new, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...impact import Impact

__all__ = ["velocity_jump"]


def velocity_jump(impact: Impact, ax: Axes | None = None, *, rows: int = 30) -> Axes:
    """Every joint speed before and after, each with its unit.

    Args:
        impact: the impact.
        ax: where to draw; a new figure if None.
        rows: how many speeds are drawn at most, those that jump most.

    Raises:
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> ax = velocity_jump(solve(scene, robot.neutral(), robot.velocity()))
        >>> ax.get_yticklabels()[0].get_text()
        'panda_joint1 [rad/s]'
    """
    speeds = speeds_of(impact.scene.robot, impact.q)
    chosen = np.sort(np.argsort(-np.abs(impact.dv), kind="stable")[: max(rows, 1)])
    ax = axes_or_new(ax, 1.2 + 0.28 * len(chosen))
    y = np.arange(len(chosen))
    before, after = impact.v_before[chosen], impact.v_after[chosen]
    ax.axvline(0.0, color=QUIET, linewidth=0.8)
    ax.hlines(y, before, after, color=AFTER, alpha=0.45, linewidth=3)
    ax.plot(before, y, "o", color=BEFORE, markersize=5, label="before")
    ax.plot(after, y, "o", color=AFTER, markersize=6, label="after")
    ax.set_yticks(y, [plain(f"{speeds[i].title} [{speeds[i].unit}]") for i in chosen])
    ax.invert_yaxis()
    ax.set_xlabel("speed, in the unit of its joint")
    left = len(speeds) - len(chosen)
    ax.set_title("Joint speeds" + (f" ({left} more jump less)" if left else ""), loc="left")
    ax.legend(frameon=False)
    return tidy(ax)
