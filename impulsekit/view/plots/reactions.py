"""What every joint had to bear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import RangeError
from .canvas import CYCLE, axes_or_new, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...impact import Impact

__all__ = ["joint_reactions"]

PARTS = {
    "force": (slice(0, 3), "N s", "Force impulse in the joints"),
    "couple": (slice(3, 6), "N m s", "Couple impulse in the joints"),
}

FAINT_BAR = 1e-10


def joint_reactions(
    impact: Impact, ax: Axes | None = None, *, part: str = "force", rows: int = 30
) -> Axes:
    """The reaction impulse of every moving joint, as bars of its size.

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
    where, unit, title = PARTS[part]
    names = impact.scene.robot.joint_names
    sizes = np.array([np.linalg.norm(impact.reactions[name][where]) for name in names])
    # Beside the largest reaction of either part this is rounding.
    scale = max((float(np.abs(impact.reactions[name]).max()) for name in names), default=0.0)
    sizes[sizes < FAINT_BAR * scale] = 0.0
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
