"""Recorded tosses of a cube: the files of ContactNets, and how far simulators end up from them."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.motions import WIDTH, cube_scene
from benchmarks.recorded.section import Section
from benchmarks.recorded.tensors import read_tensor
from impulsekit.errors import FileError, InputError, shown
from impulsekit.measured.calibration import calibrate
from impulsekit.measured.columns import RecordingFormat
from impulsekit.measured.motions import fit_motion
from impulsekit.measured.reading import load_recordings
from impulsekit.measured.recording import Recording
from impulsekit.measured.rollouts import QUICK, Rollouts
from impulsekit.robot import Robot
from impulsekit.scene import Scene

# Samples a second.
RATE = 148.0
# Mean position error [% of the width] and rotation [deg] of best fits to 550 of the tosses:
# Acosta, Yang & Posa 2022 (arXiv:2110.00541).
PUBLISHED = (("Drake, best fit", 13.5, 16.5), ("Bullet, best fit", 14.9, 16.5),
             ("MuJoCo, best fit", 25.1, 21.7))  # fmt: skip
# The same of tosses with the solver's own friction and cone set well, by the authors of this file.
MUJOCO = "MuJoCo, well set, 12.3 %, 16.2°"
# The part of the tosses that is not fitted.
HELD_OUT = 0.8
WHERE = "github.com/DAIRLab/contact-nets, data/tosses_processed (BSD-3-Clause)"


def load_tosses(path: str | os.PathLike[str], robot: Robot) -> list[Recording]:
    """The tosses in a file of recordings, or in a folder of the original ``.pt`` files.

    Raises:
        FileError, InputError: there are none, with where they can be had.
    """
    if not os.path.exists(path):
        raise FileError(f"{shown(os.fspath(path), 200)}: no such file; {WHERE}",
                        path=os.fspath(path))  # fmt: skip
    if not os.path.isdir(path):
        return load_recordings(path, robot)
    files = [file for file in Path(path).glob("*.pt") if re.fullmatch(r"\d+", file.stem)]
    if not files:
        raise InputError(f"{shown(os.fspath(path), 200)}: no tosses called NUMBER.pt; {WHERE}")
    tosses = []
    for file in sorted(files, key=lambda each: int(each.stem)):
        state = read_tensor(file).reshape(-1, 19)
        # Lengths in these files are in halves of the side.
        state[:, [0, 1, 2, 7, 8, 9]] *= 0.5 * WIDTH
        columns = {"position": state[:, :3], "quaternion_wxyz": state[:, 3:7],
                   "velocity": state[:, 7:10], "omega_body": state[:, 10:13]}  # fmt: skip
        tosses.append(
            Recording.from_columns(
                robot, columns, RecordingFormat(rate=RATE), name=f"toss {file.stem}"
            )
        )
    return tosses


def toss_section(
    path: str | os.PathLike[str],
    *,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Section:
    """Mean and median errors on tosses that took no part in the fit, beside published figures.

    Raises:
        FileError, InputError: as ``load_tosses``, or as ``calibrate`` and ``fit_motion``.
    """
    scene = cube_scene()
    tosses = load_tosses(path, scene.robot)
    calibration = calibrate(tosses, scene)
    tosses = [calibration.apply(toss) for toss in tosses]
    moved = calibration.scene(scene)
    fit = fit_motion(
        tosses, moved, restitution=["corner_*"], friction=["corner_*"], held_out=HELD_OUT,
        threads=threads, progress=progress,
    )  # fmt: skip
    held = [toss for toss in tosses if toss.name in set(fit.held_names)]
    rows = [("published e and mu, mass centre at the centre", _errors(held, scene, threads)),
            ("published e and mu, mass centre by free fall", _errors(held, moved, threads)),
            ("e and mu fitted, mass centre by free fall", fit.held_out)]  # fmt: skip
    values = ", ".join(f"{n} = {v:.3f}" for n, v in zip(fit.names, fit.values, strict=True))
    lines = [
        f"{len(tosses)} tosses, {len(tosses) - len(held)} fitted, {len(held)} held out",
        str(calibration),
        f"fitted: {values}",
        *(f"note: {note}" for note in fit.notes),
        "",
        f"{'held-out tosses':48} {'mean':>16} {'median':>16}",
        *(_row(what, errors) for what, errors in rows),
        "",
        "published, mean over 550 tosses (Acosta, Yang & Posa 2022)",
        *(f"{what:48} {place:7.1f} % {turn:5.1f}°" for what, place, turn in PUBLISHED),
        "",
        "Ours start from a fit to the first flight of each toss, theirs from its first state.",
    ]
    fine = np.mean(rows[-1][1][np.isfinite(rows[-1][1]).all(axis=1)], axis=0)
    others = ", ".join(f"{what} {place:g} % {turn:g}°" for what, place, turn in PUBLISHED)
    figure = f"{100 * fine[0] / WIDTH:.1f} %, {np.degrees(fine[1]):.1f}°"
    return Section(
        "cube", lines,
        [("cube, whole toss, mean, held out", figure, f"{others}; {MUJOCO}")],
    )  # fmt: skip


def _errors(held: Sequence[Recording], scene: Scene, threads: int | None) -> np.ndarray:
    return Rollouts(held, replace(scene), QUICK, threads).errors(scene)


def _row(what: str, errors: np.ndarray) -> str:
    fine = errors[np.isfinite(errors).all(axis=1)] * [100.0 / WIDTH, 180.0 / np.pi]
    cells = [f"{e[0]:7.1f} % {e[1]:5.1f}°" for e in (fine.mean(axis=0), np.median(fine, axis=0))]
    lost = len(errors) - len(fine)
    tail = f"   ({lost} not followed to the end)" if lost else ""
    return f"{what:48} {cells[0]:>16} {cells[1]:>16}{tail}"
