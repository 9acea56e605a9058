"""``load_history``: forces of contacts and in joints over time, on one sheet."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import CYCLE, new_figure, plain, save_figure
from .motions import FAINT, check_motion, over_time

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# [of the duration] So long before an impact its force is still that of before.
BESIDE = 1e-9
# More curves in a panel are not told apart.
MOST_CURVES = 6


def load_history(
    motion: Any,
    path: str | os.PathLike[str] | None = None,
    *,
    joints: Sequence[str] | None = None,
    samples: int = 400,
) -> Figure:
    """Draw the forces of a ``Trajectory`` over time: of its contacts, and in its joints.

    Shown are sizes, in panels of one unit each: of the force on the first body of a contact,
    and of the force and moment that the parent gives the child at a joint's origin. A panel
    without a force is left out; dashed lines mark impacts, whose impulses are no forces.

    Args:
        motion: a ``Trajectory``.
        path: where the figure is written, as PNG, SVG or PDF by its ending; None for nowhere.
        joints: by name; None for the most loaded ones.
        samples: how many times are evaluated, besides those around impacts.

    Raises:
        InputError: no ``Trajectory``; an ending that matplotlib does not know.
        UnknownNameError: a joint that the robot does not have.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, simulate
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", name="floor")])
        >>> motion = simulate(scene, ball.neutral(), ball.velocity(), duration=0.2)
        >>> [ax.get_ylabel() for ax in load_history(motion, samples=20).axes]
        ['contact force [N]']
    """
    check_motion(motion, "load_history")
    hits = np.array([time for time, _ in motion.impacts])
    both_sides = [np.linspace(0.0, motion.duration, samples), hits, hits - BESIDE * motion.duration]
    times = np.unique(np.concatenate(both_sides))
    times = times[times >= 0.0]
    forces = {name: contact.force(times) for name, contact in motion.contacts.items()}
    names = motion.scene.robot.joint_names if joints is None else joints
    wrenches = {name: motion.joints[name].reaction(times) for name in names}
    panels = {
        # The force of a stop is a part of what its joint carries.
        "contact force [N]": {n: f for n, f in forces.items() if f.shape[1] == 3},
        "force in joints [N]": {name: wrench[:, :3] for name, wrench in wrenches.items()},
        "moment in joints [N m]": {name: wrench[:, 3:] for name, wrench in wrenches.items()},
    }
    figure = _drawn(motion, times, {label: _largest(own) for label, own in panels.items()})
    if path is not None:
        save_figure(figure, path, dpi=130)
    return figure


def _largest(vectors: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The (T,) sizes of the largest of some (T, 3) vectors."""
    sizes = {name: np.linalg.norm(each, axis=1) for name, each in vectors.items()}
    return dict(sorted(sizes.items(), key=lambda entry: -entry[1].max())[:MOST_CURVES])


def _drawn(
    motion: Any, times: np.ndarray, panels: Mapping[str, Mapping[str, np.ndarray]]
) -> Figure:
    scale = max((curve.max() for own in panels.values() for curve in own.values()), default=0.0)
    kept = {
        label: {name: curve for name, curve in own.items() if curve.max() > FAINT * scale}
        for label, own in panels.items()
    }
    kept = {label: own for label, own in kept.items() if own}
    figure = new_figure(8.0, 2.6 * max(len(kept), 1))
    figure.suptitle(plain(motion.scene.robot.name))
    axes = figure.subplots(len(kept), 1, sharex=True, squeeze=False)[:, 0] if kept else []
    for ax, (label, own) in zip(axes, kept.items(), strict=True):
        for color, (name, curve) in zip(CYCLE, own.items(), strict=False):
            ax.plot(times, curve, color=color, linewidth=1.3, label=plain(name))
        ax.set_ylabel(label)
        ax.set_ylim(bottom=0.0)
        over_time(ax, motion)
        ax.label_outer()
    return figure
