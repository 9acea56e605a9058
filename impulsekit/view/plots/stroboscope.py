"""Stroboscopic figures: a mechanism at several instants in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ...errors import RangeError
from ...tolerances import NONZERO
from ..motions import Shown, shown_motion
from .canvas import axes_or_new, ink_of, on_sheet, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...robot import Robot

__all__ = ["skeleton", "stroboscope"]

# Metres in a unit of length.
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
AXES = {"x": 0, "y": 1, "z": 2}
# A motion is looked at in so many poses to choose its plane.
LOOKS = 40
# What moves less than this share of the picture's width counts as still for that.
STILL = 0.02


def stroboscope(
    motion: Any,
    times: Sequence[float],
    ax: Axes | None = None,
    *,
    plane: str | None = None,
    unit: str = "m",
    origin: Sequence[float] = (0.0, 0.0),
    ends: Sequence[str] = (),
    color: str | None = None,
) -> Axes:
    """A mechanism as lines from joint to joint at several instants.

    Figures 2 and 3 of Chang & Huston 1995 are of this kind: the struck chain with its ends
    marked A and B, and the pendulum in feet.

    Args:
        motion: a ``Trajectory``, a ``Recording`` or an ``Impact``.
        times: the instants [s].
        ax: where to draw; a new figure if None.
        plane: two axes of the world, the first one to the right, such as "xz"; by default
            those along which most moves.
        unit: of the axes: "m", "cm", "mm", "ft" or "in".
        origin: where the world's origin is drawn, in that unit.
        ends: names for the first and the last end, which are marked with the number of
            the instant, such as ("A", "B").
        color: of the lines, by default one that the sheet shows; earlier instants are paler.

    Raises:
        InputError: what is no motion.
        RangeError: an instant outside the motion, an unknown plane or unit.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> import numpy as np
        >>> from impulsekit import Robot
        >>> from impulsekit.measured import Recording
        >>> from impulsekit.models import chain_urdf
        >>> robot = Robot.from_urdf(chain_urdf(3))
        >>> q = np.array([robot.neutral(), robot.configuration(joint_2=0.5)])
        >>> ax = stroboscope(Recording(robot, [0, 1], q), [0.0, 0.5, 1.0], unit="ft")
        >>> ax.get_xlabel()
        'x [ft]'
    """
    if plane is not None and (
        len(plane) != 2 or not set(plane) <= set(AXES) or plane[0] == plane[1]
    ):
        raise RangeError.of("stroboscope: plane", repr(plane), 'two of x, y, z such as "xz"')
    if unit not in UNITS:
        raise RangeError.of("stroboscope: unit", repr(unit), ", ".join(UNITS))
    shown = shown_motion(motion)
    for time in times:
        if not shown.start <= time <= shown.end:
            raise RangeError.of("stroboscope: time", time, f"{shown.start:g} to {shown.end:g} s")
    if plane is None:
        plane = _plane_of(shown)
    ax = axes_or_new(ax, 5.0)
    color = ink_of(ax) if color is None else color
    pick = [AXES[axis] for axis in plane]
    marks: list[tuple[float, float, str]] = []
    for number, time in enumerate(times):
        strokes = skeleton(shown.robot, shown.at(np.array([float(time)]))[0])
        flat = strokes[:, :, pick] / UNITS[unit] + np.asarray(origin, dtype=float)
        shade = 0.3 + 0.7 * (number + 1) / len(times)
        for i, stroke in enumerate(flat):
            label = f"t = {time:g} s" if i == 0 else None
            ax.plot(*stroke.T, color=color, alpha=shade, linewidth=1.6, marker="o",
                    markersize=2.6, label=label)  # fmt: skip
        for name, point in zip(ends, (flat[0, 0], flat[-1, -1]), strict=False):
            marks.append((*point, f"${name}_{{{number}}}$"))
    if len(times) > 0:
        ax.legend(frameon=False, fontsize=8)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(f"{plane[0]} [{unit}]")
    ax.set_ylabel(f"{plane[1]} [{unit}]")
    tidy(ax)
    on_sheet(ax, marks)
    return ax


def _plane_of(shown: Shown) -> str:
    """The two axes of the world along which the skeleton moves most, then is widest."""
    instants = np.linspace(shown.start, shown.end, LOOKS)
    poses = np.array([skeleton(shown.robot, q) for q in shown.at(instants)]).reshape(LOOKS, -1, 3)
    if not poses.size:
        return "xy"
    moved = np.ptp(poses, axis=0).max(axis=0)
    wide = np.ptp(poses.reshape(-1, 3), axis=0)
    scale = max(float(wide.max()), NONZERO)
    # Of a pure shift along one axis the other one is that in which the robot is seen best.
    score = np.where(moved > STILL * scale, moved, 0.0) + STILL * wide
    first, second = sorted(np.argsort(-score, kind="stable")[:2])
    return "xyz"[first] + "xyz"[second]


def skeleton(robot: Robot, q: np.ndarray) -> np.ndarray:
    """(n, 2, 3) lines from joint to joint, and through the mass centres of the last links [m].

    A last link's line is as long as that of a uniform rod with its mass centre.
    """
    model = robot.model
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    strokes = []
    for joint_id in range(1, model.njoints):
        parent = model.parents[joint_id]
        place = data.oMi[joint_id]
        # What floats freely hangs on nothing; what is fixed to the world starts there.
        if parent > 0:
            strokes.append([data.oMi[parent].translation.copy(), place.translation.copy()])
        if not len(model.children[joint_id]) and model.inertias[joint_id].mass > 0.0:
            end = place.act(2.0 * model.inertias[joint_id].lever)
            strokes.append([place.translation.copy(), end])
    return np.array(strokes).reshape(-1, 2, 3)
