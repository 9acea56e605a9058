"""Results of many runs in plots: run time against error, studies, recordings."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ...batch.study.store import open_study
from ...batch.study.summary import is_valid, sizes_of, statuses_of
from ...errors import InputError, ShapeError
from ...errors.calls import public
from ..forms import speeds_of
from .canvas import (
    AFTER,
    AXES,
    CYCLE,
    IMPULSE,
    QUIET,
    axes_or_new,
    new_figure,
    plain,
    save_figure,
    tidy,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...measured.found_impacts import FoundImpacts
    from ...measured.identification import Identification
    from ...measured.motions import MotionFit
    from ...measured.recording import Recording

MARKERS = "osD^vP*X"
# Where an error is 0, it is drawn at the unit of rounding.
LEAST_ERROR = 2.0**-53


@public
def time_against_error(
    methods: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    ax: Axes | None = None,
    *,
    error: str = "relative error",
    per: str = "run time",
) -> Axes:
    """Draw run times over errors of several methods, both logarithmic. Down and left is better.

    Args:
        methods: by name, the errors of each run and the seconds it took.
        ax: where to draw; a new figure if None.
        error: what the error is, with its unit if it has one.
        per: what the seconds are for.

    Raises:
        ShapeError: errors and seconds that are not as many.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> ax = time_against_error({"rk4": ([1e-3, 1e-6], [0.01, 0.06])})
        >>> ax.get_xscale(), ax.get_ylabel()
        ('log', 'run time [s]')
    """
    ax = axes_or_new(ax)
    for i, (name, (errors, seconds)) in enumerate(methods.items()):
        if len(errors) != len(seconds):
            what = f'time_against_error: seconds of "{name}"'
            raise ShapeError.of(what, (len(errors),), (len(seconds),))
        order = np.argsort(errors)
        ax.plot(
            np.maximum(np.asarray(errors, dtype=float)[order], LEAST_ERROR),
            np.asarray(seconds, dtype=float)[order],
            marker=MARKERS[i % len(MARKERS)],
            color=CYCLE[i % len(CYCLE)],
            linewidth=1.2,
            markersize=6,
            label=plain(name),
        )
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel(error)
    ax.set_ylabel(f"{per} [s]")
    ax.set_title("Run time against error", loc="left")
    if methods:
        ax.legend(frameon=False)
    return tidy(ax)


def plot_study(path: str | os.PathLike[str], picture: str | os.PathLike[str]) -> None:
    """Draw histograms of all quantities of a store into a picture (svg, png, pdf).

    Raises:
        InputError: the folder is not the store of a study, or nothing in it is valid.
        MissingExtraError: matplotlib is not installed.
    """
    dataset = open_study(path).load()
    good = [code for code, one in statuses_of(dataset).items() if is_valid(one)]
    valid = np.isin(dataset["status"].values, good)
    names = [name for name in sorted(dataset.data_vars) if name != "status"]
    if not valid.any() or not names:
        raise InputError(f'"{path}" holds no valid row to plot')
    figure = new_figure(6.0, 2.2 * len(names))
    for axes, name in zip(np.atleast_1d(figure.subplots(len(names))), names, strict=True):
        label, sizes = sizes_of(dataset[name])
        axes.hist(sizes[valid], bins=80, color="#4477aa")
        axes.set_xlabel(f"{label} [{dataset[name].attrs.get('units', '1')}]")
        axes.set_ylabel("rows")
    save_figure(figure, picture)


@public
def found_impacts(recording: Recording, impacts: FoundImpacts, ax: Axes | None = None) -> Axes:
    """Draw recorded speeds of the first joint that have one unit, and the impacts found.

    Dots are slopes between samples; a line at an impact goes from where the flight before it
    ended to where the next begins. Linear speeds of a free-flyer are in world axes, and its height
    is drawn as well.

    Args:
        recording: one of those that ``impacts`` were found in, by its name.
        impacts: of ``find_impacts``.
        ax: where to draw; a new figure if None.

    Raises:
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> import impulsekit as ik
        >>> file = ik.load_scene("examples/cube_tosses.toml")
        >>> tosses = ik.measured.load_recordings("examples/cube_tosses.npz", file.scene.robot)
        >>> ax = found_impacts(tosses[0], ik.measured.find_impacts(tosses[:1], file.scene))
        >>> ax.get_xlabel()
        'time [s]'
    """
    ax = axes_or_new(ax)
    own = [each for each in impacts.impacts if each.recording == recording.name]
    v = recording.velocities([each.time for each in own], reach=1)
    speeds = speeds_of(recording.robot, recording.q[0])
    unit = speeds[0].unit
    shown = [i for i in range(min(3, v.shape[1])) if speeds[i].unit == unit]
    floats = recording.robot.model.joints[1].shortname() == "JointModelFreeFlyer"
    seen = _in_world(recording.q, v) if floats else v
    for i in shown:
        color = AXES[i]
        label = f"{'xyz'[i]}, world axes" if floats else plain(speeds[i].title)
        ax.plot(recording.t, seen[:, i], ".", markersize=3, color=color, label=label)
        for each in own:
            sides = np.array([each.v_before, each.v_after])
            if floats:
                sides = _in_world(np.array([each.q, each.q]), sides)
            ax.plot([each.time, each.time], sides[:, i], color=color, linewidth=1.6)
    if floats:
        height = ax.twinx()
        height.plot(recording.t, recording.q[:, 2], color=QUIET, linewidth=1.0, label="height")
        height.set_ylabel("height [m]", color=QUIET)
    for each in own:
        ax.axvline(each.time, color=QUIET, linewidth=0.7, linestyle=":")
    for name, start, end in impacts.phases:
        if name == recording.name:
            ax.axvspan(start, end, color=QUIET, alpha=0.12, linewidth=0)
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"speed [{unit}]")
    ax.set_title(plain(f"Impacts in recording {recording.name}".rstrip()), loc="left")
    ax.legend(frameon=False)
    return tidy(ax)


def _in_world(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(T, 3) the velocity of a free-flyer's origin in world axes, of (T, nq) and (T, nv)."""
    turns = (pin.XYZQUATToSE3(place[:7]).rotation for place in q)
    return np.array([turn @ own[:3] for turn, own in zip(turns, v, strict=True)])


@public
def loss_curve(fit: MotionFit, name: str, ax: Axes | None = None) -> Axes:
    """Draw the losses that were evaluated over one coefficient, with its value and interval.

    Args:
        fit: of ``fit_motion``.
        name: of the parameter.
        ax: where to draw; a new figure if None.

    Raises:
        UnknownNameError: the parameter is unknown.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> ax = loss_curve(fit, "corner_*: friction")  # doctest: +SKIP
    """
    ax = axes_or_new(ax)
    value = fit[name]
    i = fit.names.index(name)
    for stage in np.unique(fit.stage):
        own = fit.stage == stage
        ax.plot(
            fit.points[own, i], fit.losses[own], "o", markersize=3 + 1.5 * int(stage),
            color=CYCLE[int(stage) % len(CYCLE)], label=f"round {int(stage) + 1}",
        )  # fmt: skip
    low, high = fit.intervals()[i]
    ax.axvspan(low, high, color=AFTER, alpha=0.12, linewidth=0)
    ax.axvline(value, color=IMPULSE, linewidth=1.0)
    ax.set_xlabel(plain(name))
    ax.set_ylabel("mean loss")
    ax.set_ylim(bottom=0.0)
    ax.legend(frameon=False)
    return tidy(ax)


def identified_figure(found: Identification) -> Any:
    """Draw the impacts of the recording with most of them, and a loss curve by parameter.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    fit = found.by_motion
    names = () if fit is None else fit.names
    figure = new_figure(9.0, 3.2 * (1 + len(names)))
    axes = figure.subplots(1 + len(names), 1, squeeze=False)[:, 0]
    counts = [
        sum(each.recording == recording.name for each in found.impacts.impacts)
        for recording in found.recordings
    ]
    found_impacts(found.recordings[int(np.argmax(counts))], found.impacts, axes[0])
    if fit is not None:
        for ax, name in zip(axes[1:], names, strict=True):
            loss_curve(fit, name, ax)
    return figure
