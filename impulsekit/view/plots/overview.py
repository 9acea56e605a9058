"""An impact, or a motion, on one sheet."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors.calls import public
from .canvas import new_figure, plain, save_figure
from .impacts import (
    contact_cones,
    energy_balance,
    joint_reactions,
    reaction_sizes,
    velocity_jump,
)
from .motions import FAINT, energy_history, momentum_history

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@public
def overview(
    subject: Any, path: str | os.PathLike[str] | None = None, *, dark: bool = False
) -> Figure:
    """Draw the plots of an ``Impact`` or a ``Trajectory`` on one sheet, those with numbers in them.

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
    joints = 1.6 + 0.26 * min(len(impact.scene.robot.joint_names), 20)
    panels: list[tuple[float, Callable[[Any], Any]]] = [
        (2.1 + 0.26 * rows, lambda ax: velocity_jump(impact, ax, rows=20))
    ]
    # A panel without a number in it is left out.
    if reaction_sizes(impact, "force").any():
        panels.append((joints, lambda ax: joint_reactions(impact, ax, rows=20)))
    if impact.energy.before or impact.energy.after:
        height = max(3.0, 1.4 + 0.3 * (2 + len(impact.energy.work)))
        panels.append((height, lambda ax: energy_balance(impact, ax)))
    if any(point.normal is not None for c in impact.contacts for point in c.points):
        panels.append((3.6, lambda ax: contact_cones(impact, ax)))
    elif reaction_sizes(impact, "couple").any():
        panels.append((joints, lambda ax: joint_reactions(impact, ax, part="couple", rows=20)))
    lines = [panels[i : i + 2] for i in range(0, len(panels), 2)]
    heights = [max(height for height, _ in line) for line in lines]
    figure = new_figure(11.0, 0.2 + sum(heights))
    grid = figure.add_gridspec(len(lines), 2, height_ratios=heights)
    for i, line in enumerate(lines):
        for j, (_, draw) in enumerate(line):
            draw(figure.add_subplot(grid[i, j] if len(line) == 2 else grid[i, :]))
    for ax in figure.axes:
        # Long names at the side leave little width for numbers below.
        ax.locator_params(axis="x", nbins=5)
    figure.suptitle(plain(impact.scene.robot.name))
    return figure


def _of_motion(motion: Any) -> Figure:
    momentum = motion.momentum()
    sizes = {part: float(np.abs(getattr(momentum, part)).max()) for part in ("linear", "angular")}
    parts = [part for part in sizes if sizes[part] > FAINT * max(sizes.values())]
    figure = new_figure(9.0, 3.0 * (1 + len(parts)))
    axes = figure.subplots(1 + len(parts), 1, sharex=True, squeeze=False)[:, 0]
    energy_history(motion, axes[0])
    for ax, part in zip(axes[1:], parts, strict=True):
        momentum_history(motion, ax, part=part)
    for ax in axes[:-1]:
        ax.set_xlabel("")
    figure.suptitle(plain(motion.scene.robot.name))
    return figure
