"""Recorded landings of the biped Cassie: its velocity 11 and 44 ms after touch-down."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from benchmarks.recorded.section import Section
from impulsekit.errors import FileError, InputError, shown
from impulsekit.files import as_file_error, open_plain_file
from impulsekit.impact.solver import solve_without_warnings
from impulsekit.measured.active_contacts import ClosingContacts
from impulsekit.motion.record.status import MotionStatus
from impulsekit.motion.simulate import simulate
from impulsekit.robot import Robot
from impulsekit.scene import (
    Actuator,
    Contact,
    DistanceAnchor,
    JointLock,
    JointSpring,
    Scene,
    TorqueTable,
)
from impulsekit.scene.motion import MotionSettings

SIDES = ("left", "right")
# Columns of a state: quaternion wxyz and place of the pelvis, joints, their rates (angular before
# linear, in the world); of the torques. As the legend of the data has them.
JOINTS = (
    *(f"{n}_{s}" for n in ("hip_roll", "hip_yaw", "hip_pitch", "knee", "knee_joint", "ankle_joint")
      for s in SIDES),
    "ankle_spring_joint_left", "toe_left", "ankle_spring_joint_right", "toe_right",
)  # fmt: skip
MOTORS = tuple(
    f"{n}_{s}" for n in ("hip_roll", "hip_yaw", "hip_pitch", "knee", "toe") for s in SIDES
)
COLUMNS = 7 + len(JOINTS) + 6 + len(JOINTS)
# The robot as its makers' simulator has it: rotors times squared gear ratios [kg m²], stiffness of
# leaf springs [N m/rad], ends of the feet, of the rods on heel springs and on thighs [m].
ROTORS = {"hip_roll": 61e-6 * 25**2, "hip_yaw": 61e-6 * 25**2, "hip_pitch": 365e-6 * 16**2,
          "knee": 365e-6 * 16**2, "toe": 4.9e-6 * 50**2}  # fmt: skip
SPRINGS = {"knee_joint": 1500.0, "ankle_spring_joint": 1250.0}
FOOT = ((-0.0457, 0.112, 0.0), (0.088, 0.0, 0.0))
ROD_ON_HEEL, ROD_ON_THIGH = (0.11877, -0.01, 0.0), 0.045
# Rubber soles; every friction above some 0.4 gives the same, as the feet hardly slip.
FRICTION = 0.8
# Touch-down is the last sample at which the lowest point descends with this share of its fastest
# descent within the first so many seconds; slower descents than this are no landing [m/s].
STILL_FAST, SOUGHT, SLOW = 0.9, 0.02, 0.5
# When velocities are compared [s]; so long after the last sample there are none.
LATE = 1e-3
AFTER = (0.011, 0.044)
# Velocities are known to a few per cent: these give six digits; looser ones let feet stick and slip
# in turn without end. Torques change little over so many samples, and steps of a motion end at each
# time of a table.
SETTINGS = MotionSettings(rtol=1e-5, atol=1e-7, capture_speed=1e-3, together=1e-5, max_steps=2000)
THINNED = 4
WHERE = (
    "github.com/DAIRLab/cassie_impact_dataset, jumping_data/data (BSD-3), with cassie_v2.urdf of "
    "github.com/DAIRLab/dairlib, examples/Cassie/urdf, in the folder or beside it"
)


@dataclass(frozen=True, eq=False)
class Landing:
    """One landing.

    Attributes:
        name: of the recording.
        t: (T,) times after touch-down [s]. q: (T, nq). v: (T, nv).
        torques: (T, 10) of ``MOTORS`` [N m].
        floor: heights of the floor under the left and the right foot [m].
    """

    name: str
    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torques: np.ndarray
    floor: tuple[float, float]

    def at(self, time: float) -> int:
        """The sample nearest to a time [s]."""
        return int(np.argmin(np.abs(self.t - time)))


def cassie_scene(
    robot: Robot, floor: tuple[float, float] = (0.0, 0.0), *, rotors: bool = True
) -> Scene:
    """Cassie with its rods and the ends of its feet, without springs and torques."""
    model = pin.Model(robot.model)
    for joint, inertia in ROTORS.items():
        for side in SIDES:
            at = model.joints[robot.joint_id(f"{joint}_{side}")].idx_v
            model.armature[at] = inertia if rotors else 0.0
    contacts = [
        Contact(f"toe_{side}", at=at, origin=[0, 0, height], restitution=0.0, friction=FRICTION,
                name=f"{side}_{end}")
        for side, height in zip(SIDES, floor, strict=True)
        for end, at in zip(("front", "rear"), FOOT, strict=True)
    ]  # fmt: skip
    rods = [
        DistanceAnchor(f"heel_spring_{side}", f"thigh_{side}", at=ROD_ON_HEEL,
                       other_at=[0, 0, sign * ROD_ON_THIGH], velocity="kept", name=f"rod_{side}")
        for side, sign in zip(SIDES, (1.0, -1.0), strict=True)
    ]  # fmt: skip
    return Scene(
        Robot.from_model(model), contacts=contacts, constraints=rods, gravity=[0, 0, -9.81]
    )


def load_landings(folder: str | os.PathLike[str]) -> tuple[Robot, list[Landing], list[str]]:
    """The robot, the landings in a folder of ``x_NN.npy``, ``u_NN.npy`` and ``t_NN.npy``, and
    the names of the recordings in which nothing lands.

    Raises:
        FileError: an array or the robot's file cannot be read.
        InputError: there are none, or of other shapes, with where they can be had.
    """
    place = Path(folder)
    files = sorted(file for file in place.glob("x_*.npy") if re.fullmatch(r"x_\d+", file.stem))
    if not files:
        raise InputError(f"{shown(os.fspath(folder), 200)}: no landings called x_NN.npy; {WHERE}")
    near = [each / "cassie_v2.urdf" for each in (place, *place.absolute().parents[:3])]
    urdf = next((each for each in near if each.is_file()), None)
    if urdf is None:
        raise InputError(f"{shown(os.fspath(folder), 200)}: cassie_v2.urdf is missing; {WHERE}")
    robot = Robot.from_urdf(urdf, root="freeflyer")
    scene = cassie_scene(robot)
    closing = ClosingContacts(scene)
    found, without = [], []
    for file in files:
        arrays = [_array(file.with_name(f"{kind}{file.stem[1:]}.npy")) for kind in "txu"]
        t, x, u = arrays
        if x.ndim != 2 or (t.shape, x.shape, u.shape) != (
            (len(x),), (len(x), COLUMNS), (len(x), len(MOTORS))
        ):  # fmt: skip
            raise InputError(
                f"{shown(file.name, 80)}: expected times (T,), states (T, {COLUMNS}) and torques "
                f"(T, {len(MOTORS)}), got {t.shape}, {x.shape} and {u.shape}; {WHERE}"
            )
        landing = _landing(f"jump {file.stem[2:]}", scene, closing, t, x, u)
        if landing is None:
            without.append(f"jump {file.stem[2:]}")
        else:
            found.append(landing)
    return robot, found, without


def _array(path: Path) -> np.ndarray:
    label = shown(path.name, 80)
    with as_file_error(path), open_plain_file(path) as file:
        try:
            array = np.asarray(np.load(file, allow_pickle=False), dtype=float)
            if not np.isfinite(array).all():
                raise ValueError("a NaN or an infinity")
        except Exception as error:  # whatever a file that is none raises
            raise FileError(f"{label}: no array of numbers ({error})", path=label) from None
    return array


def _landing(
    name: str, scene: Scene, closing: ClosingContacts, t: np.ndarray, x: np.ndarray, u: np.ndarray
) -> Landing | None:
    """A recording in the order of the robot, with its touch-down; None if nothing lands."""
    states = [_state(scene.robot, closing, row) for row in x]
    q, v = (np.array(each) for each in zip(*states, strict=True))
    heights = np.array([closing.gaps(*state) for state in states])
    speeds = np.array([closing.mass_and_rows(a)[2] @ b for a, b in states])
    touch = [_touch_down(t, heights[:, own], speeds[:, own]) for own in (slice(0, 2), slice(2, 4))]
    reached = [each for each in touch if each is not None]
    if not reached:
        return None
    first = min(reached)
    if t[-1] - t[first] < AFTER[0]:
        return None
    # The planes are where the feet touch; a foot that touches later is above its own until then.
    floor = []
    for own, at in zip((slice(0, 2), slice(2, 4)), touch, strict=True):
        lowest = heights[first:, own].min() if at is None else heights[at, own].min()
        floor.append(float(min(lowest, heights[first, own].min())))
    return Landing(
        name, t[first:] - t[first], q[first:], v[first:], u[first:], (floor[0], floor[1])
    )


def _state(
    robot: Robot, closing: ClosingContacts, row: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """q and v of a sample; the heel springs' rates, which were not measured, by the rods."""
    model, count = robot.model, len(JOINTS)
    q, v = robot.neutral().copy(), np.zeros(robot.nv)
    q[:3], q[3:7] = row[4:7], row[[1, 2, 3, 0]] / np.linalg.norm(row[:4])
    turn = pin.Quaternion(q[3:7].copy()).matrix()
    rates = row[7 + count :]
    v[:3], v[3:6] = turn.T @ rates[3:6], turn.T @ rates[:3]
    for joint, angle, rate in zip(JOINTS, row[7 : 7 + count], rates[6:], strict=True):
        own = model.joints[robot.joint_id(joint)]
        q[own.idx_q], v[own.idx_v] = angle, rate
    unknown = [model.joints[robot.joint_id(f"ankle_spring_joint_{side}")].idx_v for side in SIDES]
    rods = closing.mass_and_rows(q)[1][-len(SIDES) :]
    v[unknown] = 0.0
    v[unknown] = -np.linalg.solve(rods[:, unknown], rods @ v)
    return q, v


def _touch_down(t: np.ndarray, heights: np.ndarray, speeds: np.ndarray) -> int | None:
    """The sample at which a foot's lowest point begins to be braked."""
    sought = int(np.searchsorted(t, t[0] + SOUGHT))
    lowest = heights[:sought].argmin(axis=1)
    own = speeds[np.arange(len(lowest)), lowest]
    if not len(own) or own.min() > -SLOW:
        return None
    fast = np.flatnonzero(own <= STILL_FAST * own.min())
    return int(fast[-1])


def landing_section(
    folder: str | os.PathLike[str], *, progress: Callable[[int, int], object] | None = None
) -> Section:
    """Errors of impacts and motions under several assumptions about the joints.

    Raises:
        FileError, InputError: as ``load_landings``.
    """
    robot, landings, without = load_landings(folder)
    springs = [f"{joint}_{side}" for joint in SPRINGS for side in SIDES]
    cases: list[tuple[str, Callable[[Landing], list[float]]]] = [
        ("one impact, joints free", lambda each: _impact(robot, each)),
        ("one impact, rotors left out", lambda each: _impact(robot, each, rotors=False)),
        ("one impact, motors controlled", lambda each: _impact(robot, each, controlled=MOTORS)),
        ("one impact, motors locked", lambda each: _impact(robot, each, locked=MOTORS)),
        ("one impact, knee springs locked",
         lambda each: _impact(robot, each, locked=springs[:2])),
        ("motion, springs and torques", lambda each: _motion(robot, each)),
        ("motion, without contact", lambda each: _motion(robot, each, contact=False)),
    ]  # fmt: skip
    rows, total = [], len(cases) * len(landings)
    for k, (name, error) in enumerate(cases):
        found = []
        for i, landing in enumerate(landings):
            found.append(error(landing))
            if progress is not None:
                progress(k * len(landings) + i + 1, total)
        rows.append((name, np.array(found)))
    by_name = dict(rows)
    lines = [
        f"{len(landings)} landings"
        + (f"; in {', '.join(without)} nothing lands" if without else ""),
        "error of the velocity over its change since touch-down, by kinetic energy; median (mean)",
        "",
        f"{'':40}" + "".join(f"{f'after {1e3 * t:g} ms':>18}" for t in AFTER),
        *(f"{name:40}" + "".join(f"{cell:>18}" for cell in _cells(found)) for name, found in rows),
        f"{'no impact at all':40}" + "".join(f"{'1':>18}" for _ in AFTER),
    ]
    ours = _cells(by_name["motion, springs and torques"])
    free = _cells(by_name["one impact, joints free"])
    return Section(
        "Cassie's landings", lines,
        [("Cassie, 11 ms after touch-down, one impact", free[0], "nothing published"),
         ("Cassie, 44 ms after touch-down, motion", ours[1], "nothing published")],
    )  # fmt: skip


def _cells(errors: np.ndarray) -> list[str]:
    cells = []
    for column in errors.T:
        fine = column[np.isfinite(column)]
        cells.append(f"{np.median(fine):.2f} ({fine.mean():.2f})" if len(fine) else "none")
    return cells


def _impact(
    robot: Robot,
    landing: Landing,
    *,
    rotors: bool = True,
    controlled: Sequence[str] = (),
    locked: Sequence[str] = (),
) -> list[float]:
    """Errors of the velocity of one impact of both feet at touch-down."""
    scene = cassie_scene(robot, landing.floor, rotors=rotors)
    locks = [JointLock(joint, velocity="kept") for joint in locked]
    scene = replace(scene, controlled=controlled, constraints=[*scene.constraints, *locks])
    after = solve_without_warnings(scene, landing.q[0], landing.v[0]).v_after
    return [_error(robot, landing, after, time) for time in AFTER]


def _motion(robot: Robot, landing: Landing, *, contact: bool = True) -> list[float]:
    """Errors of the velocity of a motion from touch-down on; NaN where it ends before."""
    scene = cassie_scene(robot, landing.floor)
    times = tuple(landing.t[::THINNED].tolist())
    forces: list[Any] = [
        Actuator(joint, TorqueTable(times, tuple(own[::THINNED])))
        for joint, own in zip(MOTORS, landing.torques.T, strict=True)
    ]
    damping = robot.model.damping
    for joint in JOINTS:
        own = damping[robot.model.joints[robot.joint_id(joint)].idx_v]
        stiffness = SPRINGS.get(joint.rsplit("_", 1)[0], 0.0)
        forces.append(JointSpring(joint, stiffness=stiffness, damping=float(own)))
    scene = replace(scene, forces=forces, contacts=scene.contacts if contact else ())
    ends = [min(time, float(landing.t[-1])) for time in AFTER]
    settings = SETTINGS.changed(duration=ends[-1])
    motion = simulate(scene, landing.q[0], landing.v[0], settings=settings, samples=[0.0, *ends])
    if motion.status is not MotionStatus.FINISHED:
        return [np.nan] * len(AFTER)
    pairs = zip(motion.v[1:], ends, strict=True)
    return [_error(robot, landing, own, time) for own, time in pairs]


def _error(robot: Robot, landing: Landing, v: np.ndarray, time: float) -> float:
    """|v − measured| over |measured − v⁻| in the metric of the kinetic energy; NaN too late."""
    if time > landing.t[-1] + LATE:
        return float("nan")
    model = cassie_scene(robot).robot.model
    mass = pin.crba(model, model.createData(), np.array(landing.q[0]))
    mass = np.triu(mass) + np.triu(mass, 1).T
    measured = landing.v[landing.at(time)]
    off, change = v - measured, measured - landing.v[0]
    return float(np.sqrt(off @ mass @ off) / np.sqrt(change @ mass @ change))
