"""Faults in solving, following, checking, showing, and what follows from an impact."""

# One fault a line, however long; wrong types are what it is about.
# ruff: noqa: E501
# mypy: disable-error-code="arg-type, list-item"

from __future__ import annotations

import functools
import json
import math
import pathlib
from typing import Any

import numpy as np
import pinocchio as pin

from impulsekit.batch.long import LongTree, long_chain, long_tree
from impulsekit.batch.solve import solve_batch
from impulsekit.batch.study.run import run_study
from impulsekit.checking import check
from impulsekit.compliance.curves import MeasuredCurve
from impulsekit.design.centre_of_percussion import (
    centre_of_percussion,
    reaction_map,
    spare_joint,
    worst_blow,
)
from impulsekit.design.fit import Measurement, fit_impacts
from impulsekit.design.least_blow import least_blow
from impulsekit.design.response import effective_mass, impact_ellipsoid
from impulsekit.design.summary import plot_effective_mass
from impulsekit.impact import Impact, ImpactSolver, solve
from impulsekit.impact.derivatives import derivatives
from impulsekit.impact.freed import freed_joint
from impulsekit.impact.saltation import saltation, saltation_matrix
from impulsekit.measured.reading import load_recordings
from impulsekit.measured.recording import Recording
from impulsekit.motion import Trajectory, simulate
from impulsekit.motion.maps.orbit import find_orbit
from impulsekit.motion.maps.sensitivity import sensitivity
from impulsekit.robot import Robot
from impulsekit.scene import (
    AppliedImpulse,
    Contact,
    JointLock,
    Scene,
)
from impulsekit.view.plots.impacts import velocity_jump
from impulsekit.view.plots.motions import energy_history, momentum_history
from impulsekit.view.replay import replay
from impulsekit.view.report import report

from .fault import Fault
from .things import arm, ball, resting, struck

Q, V = [0.1, 0.2], [0.0, 0.0]


@functools.cache
def _impact() -> Impact:
    return solve(struck(), Q, V)


@functools.cache
def _motion() -> Trajectory:
    return simulate(struck(), Q, V, duration=0.01, samples=3)


def _landing() -> Impact:
    return solve(resting(), ball().neutral(), ball().velocity(root_joint=[0, 0, -1, 0, 0, 0]))


@functools.cache
def _chain() -> LongTree:
    return long_chain(5)


def _followed(what: str, **settings: Any) -> Fault:
    return Fault(what, lambda: simulate(struck(), Q, V, **settings))


def _orbit(what: str, x: Any = (1.0,), contact: Any = "floor", **settings: Any) -> Fault:
    def start(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return ball().neutral(), ball().velocity(root_joint=[0, 0, x[0], 0, 0, 0])

    return Fault(
        what,
        lambda: find_orbit(
            resting(), x, start=start, back=lambda q, v: [v[2]], contact=contact, **settings
        ),
    )


def _batch(what: str, q: Any = Q, v: Any = V, scene: Any = struck, **given: Any) -> Fault:
    return Fault(what, lambda: solve_batch(scene(), q, v, **given))


def _shown(what: str, **given: Any) -> Fault:
    return Fault(what, lambda: replay(_impact(), **given))


def _contradiction() -> None:
    locks = [JointLock("elbow", 1.0), JointLock("elbow", 2.0)]
    solve(Scene(arm(), constraints=locks), Q, V)


def _penetrated() -> None:
    q = ball().configuration(root_joint=[0, 0, -1, 0, 0, 0, 1])
    simulate(resting(), q, ball().velocity(), duration=0.1)


def _checked_screw() -> None:
    robot = Robot.from_example("panda", root=pin.JointModelHX(0.1))
    scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
    check(solve(scene, robot.neutral(), robot.velocity()))


def _saved(what: str, name: str, content: bytes | None) -> Fault:
    def act() -> None:
        if content is not None:
            pathlib.Path(name).write_bytes(content)
        Trajectory.load(name)

    return Fault(what, act)


def _changed(what: str, name: str, **arrays: Any) -> Fault:
    """A saved motion in which arrays were changed, or taken out where None."""

    def act() -> None:
        _motion().save(name)
        with np.load(name) as file:
            held = {key: file[key] for key in file.files} | arrays
        np.savez(name, **{key: value for key, value in held.items() if value is not None})
        Trajectory.load(name)

    return Fault(what, act)


def _function_saved() -> None:
    from impulsekit.scene import Actuator

    scene = Scene(arm(), forces=[Actuator("elbow", lambda t, q, v: 1.0)])
    simulate(scene, Q, V, duration=0.001, samples=2).save("driven.npz")
    Trajectory.load("driven.npz")


def _bytes(value: Any) -> np.ndarray:
    return np.frombuffer(json.dumps(value).encode(), dtype=np.uint8)


def _measured(v_after: Any = (1.0, 1.0), sigma: Any = None) -> Measurement:
    floor = Contact("hand", restitution=0.5, name="floor")
    return Measurement(Scene(arm(), contacts=[floor]), Q, [1.0, 1.0], v_after, sigma)


_SOLVING = (
    Fault("solves a robot instead of a scene", lambda: solve(arm(), Q, V)),
    Fault("plans a path instead of a scene", lambda: ImpactSolver("scene.toml")),
    Fault("solves at an array of complex numbers", lambda: solve(struck(), np.array([0.1 + 1j, 0.2]), V)),
    Fault("solves at numpy's complex numbers in a list", lambda: solve(struck(), [np.complex128(0.1), 0.2], V)),
    Fault("solves at a velocity with masked entries", lambda: solve(struck(), Q, np.ma.masked_array(V, mask=[True, False]))),
    Fault("solves at dates", lambda: solve(struck(), np.zeros(2, "M8[s]"), V)),
    Fault("solves at durations", lambda: solve(struck(), Q, np.zeros(2, "m8[s]"))),
    Fault("solves at records", lambda: solve(struck(), np.zeros(2, [("angle", float)]), V)),
    Fault("solves at numbers that are texts", lambda: solve(struck(), ["0", "0"], V)),
    Fault("solves at a text among numbers", lambda: solve(struck(), np.array([0.1, "0"], object), V)),
    Fault("demands two speeds of one joint", _contradiction),
    Fault("asks an impact for the velocity of an unknown frame", lambda: _impact().velocity_at("hnad")),
    Fault("asks an impact for the velocity of a point of two numbers", lambda: _impact().velocity_at("hand", [0, 1])),
    Fault("frees a joint that does not exist", lambda: freed_joint(_impact(), "elbw")),
    Fault("follows a robot instead of a scene", lambda: simulate(arm(), Q, V, 1.0)),
    _followed("follows a motion for NaN seconds", duration=math.nan),
    _followed("follows a motion for words", duration="long"),
    Fault("follows a motion of 1e150 rad/s", lambda: simulate(struck(), Q, [1e150, 0.0], 1.0)),
    _orbit("looks for an orbit of a complex number", x=[1j]),
    _orbit("looks for an orbit from lists of different lengths", x=[[1.0], [1.0, 2.0]]),
    _orbit("looks for an orbit in words", x="fast"),
    _orbit("looks for an orbit without a contact", contact=None),
    _orbit("looks for an orbit with an empty list of contacts", contact=[]),
    _orbit("looks for an orbit with a number for settings", settings=3),
    _followed("misspells a setting", rtl=1e-8),
    _followed("gives falling sample times", duration=1.0, samples=[0.5, 0.1]),
    _followed("gives sample times after the end", duration=0.1, samples=[0.0, 0.5]),
    _followed("gives no sample times", duration=0.1, samples=[]),
    _followed("gives sample times in words", duration=0.1, samples=["now"]),
    _followed("gives settings as a dictionary", settings={"duration": 1.0}),
    _followed("gives a progress that cannot be called", duration=0.01, progress=3),
    Fault("starts a motion inside the floor", _penetrated),
    Fault("asks a motion for a time after its end", lambda: _motion().at(5.0)),
    Fault("asks a motion for a time in words", lambda: _motion().at("end")),
    Fault("writes a motion into a folder that is not there", lambda: _motion().save("no/such/m.npz")),
    Fault("loads a motion whose scene holds a function", _function_saved),
    _saved("loads a motion that does not exist", "gone.npz", None),
    _saved("loads a text as a motion", "notes.npz", b"nothing"),
    _saved("loads half a motion", "half.npz", b"PK\x03\x04" + b"\0" * 40),
    _changed("loads a motion without its record", "bare.npz", record=None),
    _changed("loads a motion of another format", "newer.npz", record=_bytes({"format": 9})),
    _changed("loads a motion with a NaN among its times", "nan.npz", t=np.array([0.0, math.nan, 1.0])),
    _changed("loads a motion with the states of another robot", "other.npz", q=np.zeros((3, 7))),
)  # fmt: skip

_BATCHES = (
    _batch("solves a batch of a robot", scene=arm),
    _batch("solves a batch of no rows", q=np.zeros((0, 2))),
    _batch("solves a batch with q too wide", q=np.zeros((4, 3))),
    _batch("solves a batch with rows that do not agree", q=np.zeros((4, 2)), v=np.zeros((3, 2))),
    _batch("solves a batch with words for q", q=["a", "b"]),
    _batch("solves a batch of complex numbers", q=np.zeros((4, 2), complex)),
    _batch("solves a batch with masked entries", q=np.ma.masked_array(np.zeros((4, 2)), mask=np.eye(4, 2))),
    _batch("solves a batch of masked rows", v=[np.ma.masked_array(V, mask=[False, True]), V]),
    _batch("solves a batch with a NaN that all rows share", q=[math.nan, 0.0]),
    _batch("wants an unknown output of a batch", outputs=["v_afer"]),
    _batch("wants a batch by -1 threads", threads=-1),
    _batch("wants a batch by half a thread", threads=0.5),
    _batch("wants a number as the outputs of a batch", outputs=1),
    _batch("gives a batch blows of two numbers", impulses=np.zeros((4, 2))),
    _batch("gives a batch an unknown blow", impulses={"blw": np.zeros((4, 3))}),
    _batch("gives a batch an infinite blow", impulses=[math.inf, 0, 0]),
    _batch("gives a batch friction without contacts", friction=0.3),
    _batch("gives a batch a restitution of 2", ball().neutral(), ball().velocity(), resting, restitution=2.0),
    _batch("gives a batch a friction by an unknown name", ball().neutral(), ball().velocity(), resting, friction={"flor": 0.2}),
    _batch("gives a batch a mass as a number", masses=2.0),
    _batch("gives a batch the mass of an unknown link", masses={"hnad": 2.0}),
    _batch("gives a batch a negative mass", masses={"hand": -1.0}),
    _batch("gives a batch a progress of 3", progress=3),
    Fault("makes a long chain of no links", lambda: long_chain(0)),
    Fault("makes a long chain on an unknown root", lambda: long_chain(3, root="fixd")),
    Fault("makes a long tree whose parent stands later", lambda: long_tree([-1, 2, 0], masses=1.0, centres=[0, 0, 0], inertias=np.eye(3))),
    Fault("makes a long tree without masses", lambda: long_tree([-1, 0])),
    Fault("makes a long tree with an unknown joint", lambda: long_tree([-1], joints="hinge", masses=1.0, centres=[0, 0, 0], inertias=np.eye(3))),
    Fault("makes a long tree of words", lambda: long_tree("tree", masses=1.0, centres=[0, 0, 0], inertias=np.eye(3))),
    Fault("strikes an unknown link of a long chain", lambda: _chain().solve([AppliedImpulse("link_9")])),
    Fault("strikes a long chain in a q too short", lambda: _chain().solve([AppliedImpulse("link_5")], q=[0.0])),
    Fault("strikes a long chain by nothing", lambda: _chain().solve(None)),
    Fault("strikes a long chain by a name", lambda: _chain().solve("link_5")),
    Fault("runs no study", lambda: run_study(None, "rows")),
    Fault("strikes a long chain by a contact", lambda: _chain().solve([Contact("link_5")])),
)  # fmt: skip

_AFTER = (
    Fault("checks a scene instead of an impact", lambda: check(struck())),
    Fault("checks to 3 digits", lambda: check(_impact(), digits=3)),
    Fault("checks to a milliard digits", lambda: check(_impact(), digits=10**9)),
    Fault("plots the energy of an impact over time", lambda: energy_history(_impact())),
    Fault("plots the momentum of a scene over time", lambda: momentum_history(struck())),
    Fault("plots the velocity jump of nothing", lambda: velocity_jump(None)),
    Fault("replays into a number", lambda: replay(_impact(), 5)),
    Fault("loads recordings from nothing", lambda: load_recordings(None, arm())),
    Fault("gives a measured curve two numbers", lambda: MeasuredCurve(math.nan, math.nan)),
    Fault("checks a robot with a screw joint", _checked_screw),
    Fault("asks a check for an unknown row", lambda: check(_impact()).row("speed")),
    Fault("derives a motion", lambda: derivatives(_motion())),
    Fault("carries deviations through an impact by an unknown contact", lambda: saltation(_landing(), "flor", acceleration_before=np.zeros(6), acceleration_after=np.zeros(6))),
    Fault("carries deviations with an acceleration too short", lambda: saltation(_landing(), "floor", acceleration_before=[0.0], acceleration_after=np.zeros(6))),
    Fault("carries deviations past a guard that is only grazed", lambda: saltation_matrix(np.eye(2), [0.0, 0.0], [0.0, 0.0], [1.0, 0.0])),
    Fault("asks an impact for a motion's sensitivity", lambda: sensitivity(_impact())),
    Fault("reports in an unknown form", lambda: report(_impact(), form="html")),
    Fault("reports a motion", lambda: report(_motion())),
    Fault("reports a point of an unknown frame", lambda: report(_impact(), [_report_point()])),
    Fault("replays a scene", lambda: replay(struck())),
    _shown("replays 0 frames a second", fps=0),
    _shown("replays at a speed of -1", speed=-1),
    _shown("replays an impact for -1 s", span=-1.0),
    _shown("wants ghosts after the end", ghosts=[50.0]),
    _shown("wants the reactions of an unknown joint", reactions=["elbw"]),
    _shown("writes a page into a folder that is not there", html="no/such/page.html"),
    Fault("records nothing", lambda: Recording(arm(), [], np.zeros((0, 2)))),
    Fault("records falling times", lambda: Recording(arm(), [1.0, 0.0], np.zeros((2, 2)))),
    Fault("records configurations of another robot", lambda: Recording(arm(), [0.0, 1.0], np.zeros((2, 3)))),
    Fault("records a NaN", lambda: Recording(arm(), [0.0], [[math.nan, 0.0]])),
    Fault("records words", lambda: Recording(arm(), ["now"], [[0.0, 0.0]])),
)  # fmt: skip

_DESIGN = (
    Fault("wants the effective mass of a path", lambda: effective_mass("arm.urdf", Q, "hand", [1, 0, 0])),
    Fault("wants the effective mass along no direction", lambda: effective_mass(arm(), Q, "hand", [0, 0, 0])),
    Fault("wants the effective mass along two numbers", lambda: effective_mass(arm(), Q, "hand", [1, 0])),
    Fault("wants the ellipsoid of an unknown frame", lambda: impact_ellipsoid(arm(), Q, "hnad")),
    Fault("wants the ellipsoid at a NaN", lambda: impact_ellipsoid(arm(), [math.nan, 0], "hand")),
    Fault("wants a blow for a velocity of two numbers of three", lambda: least_blow(arm(), Q, [1, 0, 0, 0], "hand")),
    Fault("wants the worst blow of an unknown kind", lambda: worst_blow(arm(), Q, "elbow", "hand", kind="torque")),
    Fault("wants the worst blow for an unknown joint", lambda: worst_blow(arm(), Q, "elbw", "hand")),
    Fault("wants to spare a joint on a line that is a point", lambda: spare_joint(arm(), Q, "elbow", "hand", [0, 0, 0], [0, 0, 0])),
    Fault("wants the centre of percussion of a fixed joint", lambda: centre_of_percussion(arm(), Q, "wrist")),
    Fault("wants the centre of percussion for a frame elsewhere", lambda: centre_of_percussion(arm(), Q, "elbow", "base")),
    Fault("wants the reactions of a joint of another robot", lambda: reaction_map(arm(), Q, "knee", "hand")),
    Fault("plots no effective mass", lambda: plot_effective_mass(None, "xy")),
    Fault("fits None", lambda: fit_impacts(None, restitution=["floor"])),
    Fault("fits numbers", lambda: fit_impacts([1, 2], restitution=["floor"])),
    Fault("fits speeds in words", lambda: fit_impacts([_measured("fast")], restitution=["floor"])),
    Fault("fits with a noise in words", lambda: fit_impacts([_measured(sigma="a")], restitution=["floor"])),
    Fault("fits with a noise of three numbers for two joints", lambda: fit_impacts([_measured(sigma=[1, 1, 1])], restitution=["floor"])),
    Fault("fits no measurements", lambda: fit_impacts([], restitution=["floor"])),
    Fault("fits nothing", lambda: fit_impacts([_measured()])),
    Fault("fits an unknown contact", lambda: fit_impacts([_measured()], restitution=["flor"])),
    Fault("fits an unknown inertia", lambda: fit_impacts([_measured()], inertias={"elbow": ["weight"]})),
    Fault("fits speeds of another robot", lambda: fit_impacts([_measured([1.0])], restitution=["floor"])),
    Fault("fits with a noise of zero", lambda: fit_impacts([_measured(sigma=0.0)], restitution=["floor"])),
)  # fmt: skip


def _report_point() -> Any:
    from impulsekit.scene.points import ReportPoint

    return ReportPoint("hnad")


FAULTS = (*_SOLVING, *_BATCHES, *_AFTER, *_DESIGN)
