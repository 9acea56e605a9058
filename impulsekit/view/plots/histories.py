"""Energy and momentum over the time of a motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import RangeError, check_kind
from .canvas import BLOW, CYCLE, axes_or_new, ink_of, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["energy_history", "momentum_history"]

# More lines at impacts than these would hide the curves.
MOST_IMPACTS = 60
CLOSEST = 1e-3


def energy_history(motion: Any, ax: Axes | None = None) -> Axes:
    """Kinetic and potential energy of a ``Trajectory`` over time [J].

    Args:
        motion: a ``Trajectory``; its impacts are marked.
        ax: where to draw; a new figure if None.

    Raises:
        InputError: no ``Trajectory``.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import Robot, Scene, simulate
        >>> panda = Robot.from_example("panda")
        >>> motion = simulate(Scene(panda), panda.neutral(), panda.velocity(), duration=0.05)
        >>> energy_history(motion).get_ylabel()
        'energy [J]'
    """
    _check_motion(motion, "energy_history")
    ax = axes_or_new(ax)
    energy = motion.energy()
    for i, name in enumerate(("kinetic", "gravity", "springs")):
        values = getattr(energy, name, None)
        if values is not None and np.any(values):
            ax.plot(motion.t, values, color=CYCLE[i], linewidth=1.2, label=name)
    ax.plot(motion.t, energy.total, color=ink_of(ax), linewidth=1.8, label="total")
    ax.set_ylabel("energy [J]")
    ax.set_title("Energy", loc="left")
    _no_closer_than(ax, float(np.abs(energy.total).max()))
    return _over_time(ax, motion)


def momentum_history(motion: Any, ax: Axes | None = None, *, part: str = "linear") -> Axes:
    """Momentum of a ``Trajectory`` over time, in world axes.

    Args:
        motion: a ``Trajectory``; its impacts are marked.
        ax: where to draw; a new figure if None.
        part: "linear" [kg m/s], or "angular" about the world's origin [kg m²/s].

    Raises:
        InputError: no ``Trajectory``.
        RangeError: another part.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import Robot, Scene, simulate
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> ax = momentum_history(simulate(Scene(rod), [0.3], [0.0], 0.5), part="angular")
        >>> ax.get_ylabel()
        'angular momentum [kg m²/s]'
    """
    _check_motion(motion, "momentum_history")
    units = {"linear": "kg m/s", "angular": "kg m²/s"}
    if part not in units:
        raise RangeError.of("momentum_history: part", repr(part), '"linear" or "angular"')
    ax = axes_or_new(ax)
    momentum = motion.momentum()
    values = getattr(momentum, part)
    for i, axis in enumerate("xyz"):
        ax.plot(motion.t, values[:, i], color=CYCLE[i], linewidth=1.4, label=axis)
    ax.set_ylabel(f"{part} momentum [{units[part]}]")
    ax.set_title(f"{part.capitalize()} momentum", loc="left")
    _no_closer_than(ax, float(np.abs([momentum.linear, values]).max()))
    return _over_time(ax, motion)


def _check_motion(motion: Any, what: str) -> None:
    from ...motion import Trajectory

    check_kind(motion, Trajectory, what)


def _no_closer_than(ax: Axes, scale: float) -> None:
    """Keep rounding from filling the picture: show a share of the ``scale`` at least."""
    low, high = ax.get_ylim()
    least = CLOSEST * scale
    if high - low < least:
        middle = 0.5 * (low + high)
        ax.set_ylim(middle - 0.5 * least, middle + 0.5 * least)


def _over_time(ax: Axes, motion: Any) -> Axes:
    for i, (time, _) in enumerate(list(motion.impacts)[:MOST_IMPACTS]):
        label = "impact" if i == 0 else None
        ax.axvline(time, color=BLOW, linewidth=0.8, alpha=0.5, linestyle="--", label=label)
    ax.set_xlabel("time [s]")
    ax.legend(frameon=False)
    return tidy(ax)
