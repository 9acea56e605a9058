"""Recorded tosses of two boxes on a hinge: where motions are 68 ms after first contact."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from benchmarks.recorded.section import Section
from benchmarks.recorded.tensors import read_tensor
from benchmarks.urdf import box_moments, joint_text, link_text, robot_text
from impulsekit.errors import InputError, shown
from impulsekit.measured.active_contacts import ClosingContacts
from impulsekit.measured.calibration import calibrate
from impulsekit.measured.flight import Flight
from impulsekit.measured.motions import MotionFit, fit_motion
from impulsekit.measured.recording import Recording
from impulsekit.measured.rollouts import QUICK, Rollouts
from impulsekit.measured.segments import flights_with_noise
from impulsekit.robot import Robot
from impulsekit.scene import Contact, JointSpring, Scene

# Samples a second; numbers of a sample: quaternion wxyz, position, hinge, and their rates.
RATE, ELBOW_COLUMNS = 148.0, 15
# Restitution and friction to start from: those of the cube, of the same acrylic and table.
RESTITUTION, FRICTION = 0.125, 0.18
# As published: half sides of a box, masses, the hinge in the first box and the second box from it
# [m, kg]. The published inertias are those of the cube; these are of homogeneous boxes.
HALF, MASS, HINGE, ALONG = (0.05, 0.025, 0.025), 0.37, (-0.035, 0.06, 0.0), 0.035
# A gap from which samples count as in contact: half of what a fall of 1 m/s makes in a sample [m].
TOUCHING = 0.004
# Samples of flight that tell the first state, and those within 68 ms of the contact, which lies
# before the first that touches.
BEFORE, AFTER = 6, 9
# When motions are compared [ms], counted from the last sample before contact, and which sample of a
# window that is.
TIMES, AT = (54, 68), (-3, -1)
# Recordings that the calibration and the noise rest on, evenly taken; the share held out.
CALIBRATED, HELD_OUT = 60, 0.8
INERTIAS = ("ixx", "iyy", "izz")
FORCES = {"bearing": ("damping",)}
# Damping in the hinge to start from [N m s/rad]: it takes a tenth of the turning of two boxes of
# 6e-4 kg m² within the 68 ms.
DAMPING = 1e-3
WHERE = "github.com/DAIRLab/dair_pll, branch ebianchi/downstream, assets/contactnets_elbow (BSD-3)"


def elbow_scene(restitution: float = RESTITUTION, friction: float = FRICTION) -> Scene:
    """Two boxes on a hinge, each with its eight corners over a table."""
    moments = box_moments(MASS, [2.0 * side for side in HALF])
    boxes = (("elbow_1", 0.0), ("elbow_2", ALONG))
    parts = [link_text(name, MASS, moments, at=(centre, 0, 0)) for name, centre in boxes]
    joint = joint_text("hinge", "continuous", "elbow_1", "elbow_2", "0 1 0", at=HINGE)
    robot = Robot.from_urdf(robot_text("elbow", *parts, joint), root="freeflyer")
    signs = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    contacts = [
        Contact(name, at=np.add(np.multiply(HALF, sign), [centre, 0, 0]), restitution=restitution,
                friction=friction, name=f"corner_{name[-1]}{k}")
        for name, centre in boxes
        for k, sign in enumerate(signs)
    ]  # fmt: skip
    bearing = JointSpring("hinge", stiffness=0.0, damping=DAMPING, name="bearing")
    return Scene(robot, contacts=contacts, forces=[bearing], gravity=[0, 0, -9.81])


def load_elbow(folder: str | os.PathLike[str], robot: Robot) -> list[Recording]:
    """The tosses in a folder of ``NUMBER.pt`` files.

    Raises:
        FileError: a file is no tensor.
        InputError: there are none, or of another robot, with where they can be had.
    """
    files = [file for file in Path(folder).glob("*.pt") if re.fullmatch(r"\d+", file.stem)]
    if not files:
        raise InputError(f"{shown(os.fspath(folder), 200)}: no tosses called NUMBER.pt; {WHERE}")
    tosses = []
    for file in sorted(files, key=lambda each: int(each.stem)):
        state = read_tensor(file)
        if state.ndim != 2 or state.shape[1] != ELBOW_COLUMNS or len(state) < 2:
            raise InputError(
                f"{shown(file.name, 80)}: expected (T, {ELBOW_COLUMNS}) numbers of an elbow, got "
                f"{state.shape}; {WHERE}"
            )
        turn = state[:, [1, 2, 3, 0]] / np.linalg.norm(state[:, :4], axis=1)[:, None]
        hinge = np.stack([np.cos(state[:, 7]), np.sin(state[:, 7])], axis=1)
        q = np.hstack([state[:, 4:7], turn, hinge])
        tosses.append(Recording(robot, np.arange(len(q)) / RATE, q, name=f"toss {file.stem}"))
    return tosses


def windows(tosses: Sequence[Recording], scene: Scene) -> list[Recording]:
    """From flight up to the last sample within 68 ms of the first contact.

    Tosses without flight before it, or that end sooner, are left out.
    """
    closing, found = ClosingContacts(scene), []
    rest = np.zeros(scene.robot.nv)
    for toss in tosses:
        for k, q in enumerate(toss.q):
            if closing.gaps(q, rest).min() < TOUCHING:
                if k >= 4 and k + AFTER < len(toss.t):
                    first = max(0, k - BEFORE)
                    found.append(toss.part(toss.t[first], toss.t[k + AFTER]))
                break
    return found


def elbow_section(
    folder: str | os.PathLike[str],
    *,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Section:
    """Errors of motions on tosses that took no part in the fit.

    Raises:
        FileError, InputError: as ``load_elbow``, or as ``calibrate`` and ``fit_motion``.
    """
    scene = elbow_scene()
    tosses = load_elbow(folder, scene.robot)
    some = tosses[:: max(1, len(tosses) // CALIBRATED)]
    calibration = calibrate(some, scene)
    scene = calibration.scene(scene)
    noise = flights_with_noise(Flight(scene), [calibration.apply(toss) for toss in some])
    sigma = None if noise is None else noise[0]
    # Before they are cut: a part has too few samples to tell its noise.
    seen = windows([replace(calibration.apply(t), sigma=sigma) for t in tosses], scene)
    fit = fit_motion(
        seen, scene, restitution=["corner_*"], friction=["corner_*"], held_out=HELD_OUT,
        inertias={"root_joint": INERTIAS, "hinge": INERTIAS}, forces=FORCES,
        threads=threads, progress=progress,
    )  # fmt: skip
    held = [toss for toss in seen if toss.name in set(fit.held_names)]
    rollouts = Rollouts(held, scene, QUICK, threads)
    cases = (
        ("homogeneous boxes, e and mu of the cube", scene),
        ("e, mu, inertias and damping fitted", fit.scene),
        ("no floor", replace(scene, contacts=())),
    )
    rows = [(name, _errors(rollouts, each)) for name, each in cases]
    fitted = rows[1][1]
    return Section(
        "elbow", _lines(len(tosses), len(seen), fit, rows),
        [(f"elbow, {TIMES[k]} ms after contact, median, held out", _cells(fitted[:, k]),
          "nothing published") for k in range(len(TIMES))],
    )  # fmt: skip


def _lines(
    count: int, used: int, fit: MotionFit, rows: Sequence[tuple[str, np.ndarray]]
) -> list[str]:
    values = [f"{n} = {v:.4g}" for n, v in zip(fit.names, fit.values, strict=True)]
    return [
        f"{count} tosses, {used} with flight before the first contact and 68 ms after it, "
        f"{len(fit.held_names)} of these held out",
        "fitted: " + ", ".join(values),
        *(f"note: {note}" for note in fit.notes),
        "",
        f"{'place, turn, hinge; held out, median':42}"
        + "".join(f"{f'after {time} ms':>28}" for time in TIMES),
        *(
            f"{name:42}" + "".join(f"{_cells(errors[:, k]):>28}" for k in range(len(TIMES)))
            for name, errors in rows
        ),
    ]


def _errors(rollouts: Rollouts, scene: Scene) -> np.ndarray:
    """(K, 2, 3) distance [m], angle [rad] of the first box and of the hinge at ``TIMES``."""
    model, found = scene.robot.model, np.full((len(rollouts.recordings), len(TIMES), 3), np.nan)
    rows = rollouts.rows(scene, range(len(rollouts.recordings)))
    for k, (recording, row) in enumerate(zip(rollouts.recordings, rows, strict=True)):
        if row is None or not np.isfinite(row.q).all():
            continue
        for i, at in enumerate(AT):
            ours, theirs = row.q[at], recording.q[at]
            off = pin.difference(model, np.array(ours), np.array(theirs))
            far = np.linalg.norm(ours[:3] - theirs[:3])
            found[k, i] = far, np.linalg.norm(off[3:6]), abs(off[6])
    return found


def _cells(errors: np.ndarray) -> str:
    place, turn, hinge = np.nanmedian(errors, axis=0)
    lost = int(np.isnan(errors[:, 0]).sum())
    tail = f" ({lost} not followed to the end)" if lost else ""
    return f"{1e3 * place:.1f} mm, {np.degrees(turn):.1f}°, {np.degrees(hinge):.1f}°{tail}"
