"""An impact, or a motion, on one sheet."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from .canvas import new_figure, save_figure
from .impacts import contact_cones, energy_books, joint_reactions, velocity_jump
from .motions import energy_history, momentum_history

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def overview(
    subject: Any, path: str | os.PathLike[str] | None = None, *, dark: bool = False
) -> Figure:
    """The plots of an ``Impact`` or a ``Trajectory`` on one sheet.

    Args:
        subject: an ``Impact``, or a ``Trajectory`` with its energy and momentum histories.
        dark: light words on a dark sheet.
        path: where the sheet is written, as PNG, SVG or PDF by its ending; None for nowhere.

    Raises:
        InputError: an ending that matplotlib does not know.
        MissingExtraError: matplotlib is not installed.
        FileError: the file cannot be written.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("ur5")
        >>> scene = Scene(robot, [AppliedImpulse("wrist_3_link", linear=[0, 0, 1])])
        >>> len(overview(solve(scene, robot.neutral(), robot.velocity())).axes)
        4
    """
    from ...impact import Impact

    new_figure(1.0, 1.0)
    from matplotlib import style

    with style.context("dark_background" if dark else []):
        figure = _of_impact(subject) if isinstance(subject, Impact) else _of_motion(subject)
        if path is not None:
            save_figure(figure, path, dpi=130)
    return figure


def _of_impact(impact: Any) -> Figure:
    rows = min(impact.scene.robot.nv, 20)
    contacts = any(point.normal is not None for c in impact.contacts for point in c.points)
    lower = max(3.6, 1.4 + 0.3 * (2 + len(impact.energy.work)), 1.2 + 0.24 * min(rows, 14))
    figure = new_figure(11.0, 2.3 + 0.26 * rows + lower)
    grid = figure.add_gridspec(2, 2, height_ratios=[2.1 + 0.26 * rows, lower])
    velocity_jump(impact, figure.add_subplot(grid[0, 0]), rows=20)
    joint_reactions(impact, figure.add_subplot(grid[0, 1]), rows=20)
    energy_books(impact, figure.add_subplot(grid[1, 0]))
    if contacts:
        contact_cones(impact, figure.add_subplot(grid[1, 1]))
    else:
        joint_reactions(impact, figure.add_subplot(grid[1, 1]), part="couple", rows=14)
    for ax in figure.axes:
        # Long names at the side leave little room for numbers below.
        ax.locator_params(axis="x", nbins=5)
    figure.suptitle(impact.scene.robot.name.replace("$", r"\$"))
    return figure


def _of_motion(motion: Any) -> Figure:
    figure = new_figure(9.0, 9.0)
    axes = figure.subplots(3, 1, sharex=True)
    energy_history(motion, axes[0])
    momentum_history(motion, axes[1])
    momentum_history(motion, axes[2], part="angular")
    for ax in axes[:-1]:
        ax.set_xlabel("")
    figure.suptitle(motion.scene.robot.name.replace("$", r"\$"))
    return figure
