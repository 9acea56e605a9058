"""A motion in plots: energy, momentum and loads over time, and stroboscopic figures."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ...errors import RangeError, check_kind
from ...errors.calls import public
from ...motion.record.energies import energies_of, momenta_of
from ...tolerances import NONZERO
from ..motions import Shown, shown_motion
from .canvas import (
    AXES,
    CYCLE,
    IMPULSE,
    axes_or_new,
    ink,
    new_figure,
    on_sheet,
    plain,
    save_figure,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...motion.record.energies import States
    from ...robot import Robot

# More lines at impacts than these would hide the curves.
MOST_IMPACTS = 60
CLOSEST = 1e-3
# What stays below this share of the largest is rounding.
FAINT = 1e-9
# [of the duration] So long before an impact its force is still that of before.
BESIDE = 1e-9
# More curves in a panel are not told apart.
MOST_CURVES = 6


@public
def energy_history(motion: Any, ax: Axes | None = None) -> Axes:
    """Draw kinetic and potential energy of a ``Trajectory`` over time [J].

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
    check_motion(motion, "energy_history")
    ax = axes_or_new(ax)
    times, states = _with_jumps(motion)
    energy = energies_of(motion, states)
    for i, name in enumerate(("kinetic", "gravity", "springs")):
        values = getattr(energy, name)
        if np.any(values):
            ax.plot(times, values, color=CYCLE[i], linewidth=1.2, label=name)
    ax.plot(times, energy.total, color=ink(), linewidth=1.8, label="total")
    ax.set_ylabel("energy [J]")
    ax.set_title("Energy", loc="left")
    _no_closer_than(ax, float(np.abs(energy.total).max()))
    return over_time(ax, motion)


@public
def momentum_history(motion: Any, ax: Axes | None = None, *, part: str = "linear") -> Axes:
    """Draw the momentum of a ``Trajectory`` over time, in world axes.

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
    check_motion(motion, "momentum_history")
    units = {"linear": "kg m/s", "angular": "kg m²/s"}
    if part not in units:
        raise RangeError.of("momentum_history: part", repr(part), '"linear" or "angular"')
    ax = axes_or_new(ax)
    times, states = _with_jumps(motion)
    momentum = momenta_of(motion, states)
    for i, axis in enumerate("xyz"):
        column = getattr(momentum, part)[:, i]
        ax.plot(times, column, color=AXES[i], linewidth=1.4, label=axis)
    ax.set_ylabel(f"{part} momentum [{units[part]}]")
    ax.set_title(f"{part.capitalize()} momentum, world axes", loc="left")
    _no_closer_than(ax, float(np.abs([momentum.linear, getattr(momentum, part)]).max()))
    return over_time(ax, motion)


def _with_jumps(motion: Any) -> tuple[np.ndarray, States]:
    """Return times and states, with both states of every impact: a jump is a vertical line."""
    if not motion.impacts:
        return motion.t, (motion.q, motion.v)
    hits = np.repeat([time for time, _ in motion.impacts], 2)
    place = np.searchsorted(motion.t, hits, "left")
    q = np.repeat([impact.q for _, impact in motion.impacts], 2, axis=0)
    v = np.concatenate([[impact.v_before, impact.v_after] for _, impact in motion.impacts])
    states = np.insert(motion.q, place, q, axis=0), np.insert(motion.v, place, v, axis=0)
    return np.insert(motion.t, place, hits), states


def check_motion(motion: Any, what: str) -> None:
    """Raise an InputError unless it is a ``Trajectory``."""
    from ...motion import Trajectory

    check_kind(motion, Trajectory, what)


def _no_closer_than(ax: Axes, scale: float) -> None:
    """Keep rounding from filling the picture: show a share of the ``scale`` at least."""
    low, high = ax.get_ylim()
    least = CLOSEST * scale
    if high - low < least:
        middle = 0.5 * (low + high)
        ax.set_ylim(middle - 0.5 * least, middle + 0.5 * least)


def over_time(ax: Axes, motion: Any) -> Axes:
    """Finish axes over time: impacts as dashed lines, a legend."""
    for i, (time, _) in enumerate(list(motion.impacts)[:MOST_IMPACTS]):
        label = "impact" if i == 0 else None
        ax.axvline(time, color=IMPULSE, linewidth=0.8, alpha=0.5, linestyle="--", label=label)
    ax.set_xlabel("time [s]")
    ax.legend(frameon=False)
    return tidy(ax)


@public
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
    curves = {label: _largest(own) for label, own in panels.items()}
    scale = max((each.max() for own in curves.values() for each in own.values()), default=0.0)
    kept = {
        label: found
        for label, own in curves.items()
        if (found := {name: each for name, each in own.items() if each.max() > FAINT * scale})
    }
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
    if path is not None:
        save_figure(figure, path, dpi=130)
    return figure


def _largest(vectors: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the (T,) sizes of the largest of some (T, 3) vectors."""
    sizes = {name: np.linalg.norm(each, axis=1) for name, each in vectors.items()}
    return dict(sorted(sizes.items(), key=lambda entry: -entry[1].max())[:MOST_CURVES])


# Metres in a unit of length.
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
INDEX_OF_AXIS = {"x": 0, "y": 1, "z": 2}
# A motion is looked at in so many poses to choose its plane.
LOOKS = 40
# What moves less than this share of the picture's width counts as still for that.
STILL = 0.02


@public
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
    """Draw a mechanism as lines from joint to joint at several instants.

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
        len(plane) != 2 or not set(plane) <= set(INDEX_OF_AXIS) or plane[0] == plane[1]
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
    color = ink() if color is None else color
    pick = [INDEX_OF_AXIS[axis] for axis in plane]
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
    """Return the two axes of the world along which the skeleton moves most, then is widest."""
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
    """Return (n, 2, 3): lines from joint to joint and through the last links' mass centres [m].

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
