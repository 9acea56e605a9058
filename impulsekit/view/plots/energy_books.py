"""Kinetic energy before and after, and what every entry put in or took out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .canvas import AFTER, BEFORE, BLOW, CYCLE, QUIET, axes_or_new, ink_of, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...impact import Impact

__all__ = ["energy_books"]


def energy_books(impact: Impact, ax: Axes | None = None) -> Axes:
    """The books of energy as steps from the kinetic energy before to that after [J].

    Args:
        impact: the impact.
        ax: where to draw; a new figure if None.

    Raises:
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1], name="blow")])
        >>> ax = energy_books(solve(scene, robot.neutral(), robot.velocity()))
        >>> [label.get_text() for label in ax.get_yticklabels()]
        ['before', 'work of blow', 'after']
    """
    energy = impact.energy
    works = list(energy.work.values())
    levels = energy.before + np.cumsum([0.0, *works])
    starts = [0.0, *levels[:-1], 0.0]
    lengths = [energy.before, *works, energy.after]
    colors = [BEFORE, *(CYCLE[2] if work >= 0.0 else BLOW for work in works), AFTER]
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
            color=ink_of(ax),
        )
    ax.set_yticks(y, ["before", *(plain(f"work of {name}") for name in energy.work), "after"])
    ax.invert_yaxis()
    ax.margins(x=0.18)
    ax.set_xlim(left=min(0.0, ax.get_xlim()[0]) if min(levels) < 0.0 else 0.0)
    ax.set_xlabel("kinetic energy [J]")
    ax.set_title("Energy by entry", loc="left")
    return tidy(ax)
