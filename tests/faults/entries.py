"""Faults in what a scene holds: impulses, constraints, contacts, forces, the law."""

# One fault a line, however long; wrong types are what it is about.
# ruff: noqa: E501
# mypy: disable-error-code="arg-type, list-item"

from __future__ import annotations

import math
from typing import Any

import numpy as np

from impulsekit.impact import solve
from impulsekit.scene import (
    PD,
    Actuator,
    AppliedForce,
    AppliedImpulse,
    Collision,
    Contact,
    FrameAnchor,
    JointCoupling,
    JointImpulse,
    JointLock,
    JointSpring,
    JointStop,
    Law,
    PointAnchor,
    Restitution,
    RestitutionTable,
    Scene,
    Spring,
)
from impulsekit.scene.motion import MotionSettings
from impulsekit.scene.points import DesignPoint, ReportPoint

from .fault import Fault
from .things import arm, ball, both

__all__ = ["FAULTS"]


def _impulse(what: str, *args: Any, **fields: Any) -> Fault:
    return Fault(what, lambda: Scene(arm(), [AppliedImpulse(*args, **fields)]))


def _of(kind: str, what: str, make: Any, robot: Any = arm) -> Fault:
    def act() -> None:
        given: dict[str, Any] = {kind: [make()]}
        Scene(robot(), **given)

    return Fault(what, act)


def _pin(what: str, make: Any) -> Fault:
    return _of("constraints", what, make)


def _contact(what: str, make: Any, robot: Any = ball) -> Fault:
    return _of("contacts", what, make, robot)


def _force(what: str, make: Any, robot: Any = arm) -> Fault:
    return _of("forces", what, make, robot)


def _restitution_by(function: Any) -> None:
    scene = Scene(ball(), contacts=[Contact("ball", restitution=function, name="floor")])
    solve(scene, ball().neutral(), ball().velocity(root_joint=[0, 0, -1, 0, 0, 0]))


_IMPULSES = (
    _impulse("strikes a frame that does not exist", "hnad", [1, 0, 0]),
    _impulse("strikes a joint that does not exist", "elbow_joint", [1, 0, 0]),
    _impulse("strikes nothing", "", [1, 0, 0]),
    _impulse("strikes a frame by number", 3, [1, 0, 0]),
    _impulse("strikes the world", "world", [1, 0, 0]),
    _impulse("strikes the base of a fixed robot", "base", [1, 0, 0]),
    _impulse("strikes by a single number", "hand", 5),
    _impulse("strikes by two numbers", "hand", [5, 0]),
    _impulse("strikes by a NaN", "hand", [0, math.nan, 0]),
    _impulse("strikes by words", "hand", ["hard", 0, 0]),
    _impulse("strikes by numpy's complex numbers", "hand", [np.complex128(1), 0, 0]),
    _impulse("strikes by durations", "hand", np.ones(3, "m8[ns]")),
    _impulse("strikes by 1e200 N s", "hand", [1e200, 0, 0]),
    _impulse("gives a couple of four numbers", "hand", angular=[0, 0, 0, 1]),
    _impulse("strikes at a point given by name", "hand", [1, 0, 0], at="tip"),
    _impulse("invents axes", "hand", [1, 0, 0], axes="body"),
    _impulse("gives an impulse an empty name", "hand", [1, 0, 0], name=""),
    _impulse("gives an impulse a name that clears the screen", "hand", [1, 0, 0], name="\x1b[2J"),
    _of("impulses", "kicks a joint that does not exist", lambda: JointImpulse("elbo", 1)),
    _of("impulses", "kicks a joint by two numbers", lambda: JointImpulse("elbow", [1, 2])),
    _of("impulses", "kicks a joint by words", lambda: JointImpulse("elbow", "hard")),
    _of("impulses", "kicks a fixed joint", lambda: JointImpulse("wrist", 1)),
    _of("impulses", "gives a contact as an impulse", lambda: Contact("hand")),
    Fault("gives one impulse without a list", lambda: Scene(arm(), AppliedImpulse("hand"))),
    Fault("gives two impulses one name", lambda: Scene(arm(), [JointImpulse("elbow", 1, name="a"), JointImpulse("shoulder", 1, name="a")])),
    Fault("makes a scene of a path", lambda: Scene("arm.urdf")),
    Fault("gives gravity as one number", lambda: Scene(arm(), gravity=-9.81)),
    Fault("gives a law by name", lambda: Scene(arm(), law="newton")),
)  # fmt: skip

_CONSTRAINTS = (
    _pin("anchors a frame that does not exist", lambda: PointAnchor("hnd")),
    _pin("anchors a frame to itself", lambda: PointAnchor("hand", "hand")),
    _pin("anchors a frame within one body", lambda: PointAnchor("hand", "fore_arm")),
    _pin("anchors the base of a fixed robot", lambda: PointAnchor("base")),
    _pin("anchors at two numbers", lambda: PointAnchor("hand", at=[0, 1])),
    _pin("anchors with a velocity in words", lambda: PointAnchor("hand", velocity="slow")),
    _pin("anchors a point with two velocities", lambda: PointAnchor("hand", velocity=[0, 1])),
    _pin("invents a direction", lambda: FrameAnchor("hand", directions=["x", "w"])),
    _pin("gives a direction twice", lambda: FrameAnchor("hand", directions=["x", "x"])),
    _pin("gives no direction", lambda: FrameAnchor("hand", directions=[])),
    _pin("gives directions as a number", lambda: FrameAnchor("hand", directions=3)),
    _pin("anchors a frame in invented axes", lambda: FrameAnchor("hand", axes="tool")),
    _pin("locks a joint that does not exist", lambda: JointLock("elbw")),
    _pin("locks a fixed joint", lambda: JointLock("wrist")),
    _pin("locks a joint with two velocities", lambda: JointLock("elbow", [0, 1])),
    _pin("couples a joint to itself", lambda: JointCoupling("elbow", "elbow")),
    _pin("couples a joint to nothing", lambda: JointCoupling("elbow", [])),
    _pin("couples with two ratios for one leader", lambda: JointCoupling("elbow", "shoulder", [1, 2])),
    _pin("couples with a ratio of NaN", lambda: JointCoupling("elbow", "shoulder", math.nan)),
    _of("constraints", "couples a free-flyer", lambda: JointCoupling("ball/root_joint", "arm/elbow"), both),
    _pin("gives an impulse as a constraint", lambda: AppliedImpulse("hand")),
)  # fmt: skip

_CONTACTS = (
    _contact("touches with a frame that does not exist", lambda: Contact("bal")),
    _contact("touches a frame with itself", lambda: Contact("ball", against="ball")),
    _contact("touches the base of a fixed robot", lambda: Contact("base"), arm),
    _contact("gives a normal without length", lambda: Contact("ball", normal=[0, 0, 0])),
    _contact("gives a normal of two numbers", lambda: Contact("ball", normal=[0, 1])),
    _contact("gives a restitution of 1.2", lambda: Contact("ball", restitution=1.2)),
    _contact("gives a restitution of -0.1", lambda: Contact("ball", restitution=-0.1)),
    _contact("gives a restitution of NaN", lambda: Contact("ball", restitution=math.nan)),
    _contact("gives a restitution by name", lambda: Contact("ball", restitution="steel")),
    _contact("gives a negative friction", lambda: Contact("ball", friction=-0.1)),
    _contact("gives an infinite friction", lambda: Contact("ball", friction=math.inf)),
    _contact("gives three numbers for friction", lambda: Contact("ball", friction=[0.1, 0.2, 0.3])),
    _contact("gives a kinetic friction above the static", lambda: Contact("ball", friction=(0.1, 0.2))),
    _contact("gives a negative rolling", lambda: Contact("ball", rolling=-1e-3)),
    _contact("gives an infinite torsion", lambda: Contact("ball", torsion=float("inf"))),
    _contact("gives a tangential restitution of 2", lambda: Contact("ball", tangential_restitution=2)),
    _contact("gives a Restitution above 1", lambda: Contact("ball", restitution=Restitution(1.5))),
    _contact("gives a negative capture speed", lambda: Contact("ball", restitution=Restitution(0.5, -1))),
    _contact("gives a restitution table of falling speeds", lambda: RestitutionTable([1, 0], [0.5, 0.5])),
    _contact("gives a restitution table two speeds and one value", lambda: RestitutionTable([0, 1], [0.5])),
    _contact("gives a restitution table of nothing", lambda: RestitutionTable([], [])),
    Fault("gives a restitution function that answers 2", lambda: _restitution_by(lambda speed: 2.0)),
    Fault("gives a restitution function that answers nothing", lambda: _restitution_by(lambda speed: None)),
    _contact("stops a joint that does not exist", lambda: JointStop("elbw"), arm),
    _contact("stops a free-flyer", lambda: JointStop("root_joint")),
    _contact("stops a joint above its upper limit", lambda: JointStop("elbow", lower=1, upper=0), arm),
    _contact("stops a joint above the limit of the URDF", lambda: JointStop("elbow", lower=3), arm),
    _contact("lets a body collide that does not exist", lambda: Collision("fore_am", "base"), arm),
    _contact("lets a body collide with itself", lambda: Collision("hand", "hand"), arm),
    _contact("lets a link without geometry collide", lambda: Collision("hand", "base"), arm),
    _contact("gives a negative margin", lambda: Collision("fore_arm", "base", margin=-1), arm),
    _contact("gives a law as a contact", lambda: Law()),
)  # fmt: skip

_FORCES = (
    _force("springs a joint that does not exist", lambda: JointSpring("elbw", 1)),
    _force("springs a free-flyer", lambda: JointSpring("root_joint", 1), ball),
    _force("gives a negative stiffness", lambda: JointSpring("elbow", -1)),
    _force("gives a damping of NaN", lambda: JointSpring("elbow", 1, math.nan)),
    _force("springs a frame to itself", lambda: Spring("hand", "hand")),
    _force("springs two frames of one body", lambda: Spring("hand", "fore_arm")),
    _force("gives a spring a negative length", lambda: Spring("hand", rest_length=-1)),
    _force("drives a joint that does not exist", lambda: Actuator("elbw", 1)),
    _force("drives a joint by two torques", lambda: Actuator("elbow", [1, 2])),
    _force("drives a joint by words", lambda: Actuator("elbow", "full")),
    _force("drives a free-flyer by a PD", lambda: Actuator("root_joint", PD(1)), ball),
    _force("gives a PD a negative limit", lambda: Actuator("elbow", PD(1, limit=-1))),
    _force("pushes the world", lambda: AppliedForce("world", [0, 0, 1])),
    _force("pushes by two numbers", lambda: AppliedForce("hand", [0, 1])),
    _force("gives an impulse as a force", lambda: AppliedImpulse("hand")),
)  # fmt: skip

_SETTINGS = (
    Fault("misspells a law of restitution", lambda: Law("newtn")),
    Fault("invents a law of slip", lambda: Law(slip="start")),
    Fault("invents an order", lambda: Law(order="random")),
    Fault("gives a law a number", lambda: Law(restitution=0.5)),
    Fault("takes Stronge's law with slip at the end", lambda: Law("stronge")),
    Fault("follows a motion for -1 s", lambda: MotionSettings(duration=-1)),
    Fault("wants 0 samples", lambda: MotionSettings(samples=0)),
    Fault("wants 2.5 samples", lambda: MotionSettings(samples=2.5)),
    Fault("wants a tolerance of 0", lambda: MotionSettings(rtol=0)),
    Fault("wants an absolute tolerance of 0", lambda: MotionSettings(atol=0)),
    Fault("misspells an integrator", lambda: MotionSettings(method="dopri853")),
    Fault("wants a step of 0 s", lambda: MotionSettings(step=0)),
    Fault("reports a point of two numbers", lambda: ReportPoint("hand", [0, 1])),
    Fault("labels a point with a number", lambda: ReportPoint("hand", label=3)),
    Fault("gives a design point no frame", lambda: DesignPoint("")),
)  # fmt: skip

FAULTS = (*_IMPULSES, *_CONSTRAINTS, *_CONTACTS, *_FORCES, *_SETTINGS)
