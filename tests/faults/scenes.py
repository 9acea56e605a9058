"""Faults in scenes: impulses, constraints, contacts, laws and forces that cannot be."""

# One fault a line, however long; wrong types are what it is about.
# ruff: noqa: E501

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

import impulsekit as ik
from impulsekit.compliance import HuntCrossley, MeasuredCurve, force_history, peak_forces

from .fault import Fault
from .things import arm, ball, both, resting, struck

NAN, INF = math.nan, math.inf
ARM, BALL, BOTH = arm(), ball(), both()
STRUCK, RESTING = struck(), resting()
Q, V = [0.1, 0.2], [0.0, 0.0]
FALL = BALL.velocity(root_joint=[0, 0, -1, 0, 0, 0])
FUNCTION = ik.GapConstraint(lambda q: q[0])
FLOOR = RESTING.contacts[0]
RUBBER = MeasuredCurve([0, 0.01], [0, 100.0])
GRIPS = ik.Contact("ball", adhesion=1.0, holding_force=9.0)


def blow(*args, **given):
    return lambda: ik.Scene(ARM, [ik.AppliedImpulse(*args, **given)])


def kick(*args, **given):
    return lambda: ik.Scene(ARM, [ik.JointImpulse(*args, **given)])


def held(kind, *args, robot=ARM, **given):
    return lambda: ik.Scene(robot, constraints=[kind(*args, **given)])


def touch(kind, *args, robot=BALL, law=None, **given):
    return lambda: ik.Scene(robot, contacts=[kind(*args, **given)], law=law or ik.Law())


def push(kind, *args, robot=ARM, **given):
    return lambda: ik.Scene(robot, forces=[kind(*args, **given)])


def made(kind, *args, **given):
    return lambda: kind(*args, **given)


def solved(*contacts, robot=BALL, law=None, v=FALL, **entries):
    scene = ik.Scene(robot, contacts=contacts, law=law or ik.Law(), **entries)
    return ik.solve(scene, robot.neutral(), v)


def bounced(restitution):
    return lambda: solved(ik.Contact("ball", restitution=restitution, name="floor"))


def followed(scene=STRUCK, **given):
    return lambda: ik.simulate(scene, Q, V, **given)


def kept(**entries):
    return ik.solve(ik.Scene(ARM, **entries), Q, [1.0, 0.0])


def points(given):
    return lambda: ik.solve_batch(RESTING, BALL.neutral(), [FALL, FALL], points=given)


def history(curve, *args, v=FALL, **entries):
    return lambda: force_history(solved(FLOOR, v=v, **entries), curve, *args)


def peaks(*contacts, curve=RUBBER, v=FALL, **given):
    law = given.pop("law", ik.Law())
    scene = ik.Scene(BALL, contacts=contacts or [FLOOR], law=law)
    return lambda: peak_forces(scene, BALL.neutral(), [v], curve, **given)


def placed(*args, **given):
    return lambda: ik.place(BOTH, BOTH.neutral(), *args, **given)


def at_once(*given):
    return lambda: ik.solve(STRUCK, Q, V, impulses=given[0])


def gives(value):
    return lambda *_: value


WRONG_VALUES = {
    "a text": "strong", "texts": ["1", "2", "3"], "nothing": None, "complex numbers": [1j, 0, 0],
    "a truth value": True, "two numbers": [1.0, 2.0], "a column": np.zeros((3, 1)),
    "a NaN": [0.0, NAN, 0.0], "a ragged list": [[1.0], [2.0, 3.0]],
}  # fmt: skip
AT_ONCE = [ik.Contact("ball", at=[x, 0, 0], friction=0.3, restitution=0.5) for x in (0.0, 0.1)]
STRONGE, LZB = ik.Law("stronge", "path"), ik.Law("lzb")

_ROWS: tuple[tuple[str, Callable[[], Any]], ...] = (
    # Impulses
    ("an impulse: frame", blow("hnad", [1, 0, 0])),
    ("an impulse: empty frame", blow("", [1, 0, 0])),
    ("an impulse: frame by number", blow(3, [1, 0, 0])),
    ("an impulse: world struck", blow("world", [1, 0, 0])),
    ("an impulse: base struck", blow("base", [1, 0, 0])),
    ("an impulse: one number", blow("hand", 5)),
    ("an impulse: two numbers", blow("hand", [5, 0])),
    ("an impulse: nan", blow("hand", [0, NAN, 0])),
    ("an impulse: words", blow("hand", ["hard", 0, 0])),
    ("an impulse: complex", blow("hand", [np.complex128(1), 0, 0])),
    ("an impulse: too large", blow("hand", [1e200, 0, 0])),
    ("an impulse: four couples", blow("hand", angular=[0, 0, 0, 1])),
    ("an impulse: at by name", blow("hand", [1, 0, 0], at="tip")),
    ("an impulse: axes", blow("hand", [1, 0, 0], axes="body")),
    ("an impulse: empty name", blow("hand", [1, 0, 0], name="")),
    ("an impulse: unprintable name", blow("hand", [1, 0, 0], name="\x1b[2J")),
    ("an impulse: joint", kick("elbo", 1)),
    ("an impulse: two in one joint", kick("elbow", [1, 2])),
    ("an impulse: fixed joint kicked", kick("wrist", 1)),
    ("an impulse: contact as impulse", lambda: ik.Scene(ARM, [ik.Contact("hand")])),
    ("an impulse: no list", lambda: ik.Scene(ARM, ik.AppliedImpulse("hand"))),
    ("an impulse: one name twice", lambda: ik.Scene(ARM, [ik.JointImpulse("elbow", 1, name="a"), ik.JointImpulse("shoulder", 1, name="a")])),
    ("an impulse: path as robot", lambda: ik.Scene("arm.urdf")),
    ("an impulse: gravity", lambda: ik.Scene(ARM, gravity=-9.81)),
    ("an impulse: law by name", lambda: ik.Scene(ARM, law="newton")),
    # Constraints
    ("a constraint: anchored frame", held(ik.PointAnchor, "hnd")),
    ("a constraint: to itself", held(ik.PointAnchor, "hand", "hand")),
    ("a constraint: in one body", held(ik.PointAnchor, "hand", "fore_arm")),
    ("a constraint: base anchored", held(ik.PointAnchor, "base")),
    ("a constraint: anchor velocity", held(ik.PointAnchor, "hand", velocity="slow")),
    ("a constraint: anchor velocities", held(ik.PointAnchor, "hand", velocity=[0, 1])),
    ("a constraint: direction", held(ik.FrameAnchor, "hand", directions=["x", "w"])),
    ("a constraint: direction twice", held(ik.FrameAnchor, "hand", directions=["x", "x"])),
    ("a constraint: no direction", held(ik.FrameAnchor, "hand", directions=[])),
    ("a constraint: lock", held(ik.JointLock, "elbw")),
    ("a constraint: fixed joint locked", held(ik.JointLock, "wrist")),
    ("a constraint: lock velocities", held(ik.JointLock, "elbow", [0, 1])),
    ("a constraint: coupled to itself", held(ik.JointCoupling, "elbow", "elbow")),
    ("a constraint: ratios", held(ik.JointCoupling, "elbow", "shoulder", [1, 2])),
    ("a constraint: free-flyer coupled", held(ik.JointCoupling, "ball/root_joint", "arm/elbow", robot=BOTH)),
    ("a constraint: rod in one body", held(ik.DistanceAnchor, "hand", "fore_arm")),
    ("a constraint: driven by number", held(ik.Driven, "elbow", 3.0)),
    ("a constraint: wrong rate", held(ik.Driven, "elbow", lambda t: t * t, velocity=lambda t: t)),
    ("a constraint: gap as number", held(ik.GapConstraint, 3.0)),
    ("a constraint: wrong gradient", held(ik.GapConstraint, lambda q: q[0], gradient=lambda q: [[2.0, 0.0]])),
    ("a constraint: impulse as constraint", held(ik.AppliedImpulse, "hand")),
    ("a constraint: controlled and locked", lambda: ik.Scene(ARM, controlled=["elbow"], constraints=[ik.JointLock("elbow")])),
    ("a constraint: two locks", lambda: ik.solve(ik.Scene(ARM, constraints=[ik.JointLock("elbow", 1.0), ik.JointLock("elbow", 2.0)]), Q, V)),
    # Contacts and coefficients
    ("a contact: touching frame", touch(ik.Contact, "bal")),
    ("a contact: touches itself", touch(ik.Contact, "ball", against="ball")),
    ("a contact: base touches", touch(ik.Contact, "base", robot=ARM)),
    ("a contact: no normal", touch(ik.Contact, "ball", normal=[0, 0, 0])),
    ("a contact: restitution above 1", touch(ik.Contact, "ball", restitution=1.2)),
    ("a contact: restitution below 0", touch(ik.Contact, "ball", restitution=-0.1)),
    ("a contact: restitution nan", touch(ik.Contact, "ball", restitution=NAN)),
    ("a contact: restitution by name", touch(ik.Contact, "ball", restitution="steel")),
    ("a contact: friction below 0", touch(ik.Contact, "ball", friction=-0.1)),
    ("a contact: friction infinite", touch(ik.Contact, "ball", friction=INF)),
    ("a contact: kinetic above static", touch(ik.Contact, "ball", friction=(0.1, 0.2))),
    ("a contact: rolling below 0", touch(ik.Contact, "ball", rolling=-1e-3)),
    ("a contact: tangential above 1", touch(ik.Contact, "ball", tangential_restitution=2)),
    ("a contact: capture speed", made(ik.Restitution, 0.5, -1)),
    ("a contact: falling speeds", made(ik.RestitutionTable, [1, 0], [0.5, 0.5])),
    ("a contact: one value", made(ik.FrictionTable, [0, 1], [0.5])),
    ("a contact: axis without length", made(ik.EllipticFriction, 0.1, 0.2, [0, 0, 0])),
    ("a contact: function gives 2", bounced(lambda speed: 2.0)),
    ("a contact: function gives nothing", bounced(lambda speed: None)),
    ("a contact: function raises", bounced(lambda speed: 1 / 0)),
    ("a contact: stop", touch(ik.JointStop, "elbw", robot=ARM)),
    ("a contact: free-flyer stopped", touch(ik.JointStop, "root_joint")),
    ("a contact: stop upside down", touch(ik.JointStop, "elbow", lower=1.0, upper=0.0, robot=ARM)),
    ("a contact: no such geometry", touch(ik.Collision, "fore_am", "base", robot=ARM)),
    ("a contact: no geometry", touch(ik.Collision, "hand", "base", robot=ARM)),
    ("a contact: margin", touch(ik.Collision, "fore_arm", "base", margin=-1.0, robot=ARM)),
    ("a contact: rope without length", touch(ik.Rope, "ball", length=0.0)),
    ("a contact: gap friction", touch(ik.GapContact, lambda q: q[2], friction=0.3)),
    ("a contact: law as contact", lambda: ik.Scene(BALL, contacts=[ik.Law()])),
    ("a contact: no material", touch(ik.Contact, "ball", restitution="material")),
    ("a contact: unknown pair", lambda: ik.Scene(BALL, materials=[ik.MaterialPair("rubber", "steel")])),
    # Laws
    ("a law: restitution law", made(ik.Law, "newtn")),
    ("a law: slip", made(ik.Law, slip="start")),
    ("a law: order", made(ik.Law, order="random")),
    ("a law: stronge at the end", made(ik.Law, "stronge")),
    ("a law: exponent", made(ik.Law, "lzb", exponent=0.5)),
    ("a law: lzb in sequence", made(ik.Law, "lzb", order="sequential")),
    ("a law: no stiffness", touch(ik.Contact, "ball", law=LZB)),
    ("a law: stiffness of 0", touch(ik.Contact, "ball", stiffness=0.0)),
    ("a law: tangential under lzb", touch(ik.Contact, "ball", stiffness=1.0, friction=0.1, tangential_restitution=0.5, law=LZB)),
    ("a law: adhesion bounces", touch(ik.Contact, "ball", adhesion=1.0, restitution=0.5)),
    ("a law: rolling under stronge", touch(ik.Contact, "ball", rolling=0.1, law=STRONGE)),
    ("a law: two rub along paths", lambda: solved(*AT_ONCE, law=ik.Law(slip="path"))),
    ("a law: two under stronge", lambda: solved(*AT_ONCE, law=STRONGE)),
    # Forces
    ("a force: spring", push(ik.JointSpring, "elbw")),
    ("a force: free-flyer sprung", push(ik.JointSpring, "root_joint", robot=BALL)),
    ("a force: stiffness below 0", push(ik.JointSpring, "elbow", -1)),
    ("a force: damping nan", push(ik.JointSpring, "elbow", damping=NAN)),
    ("a force: spring in itself", push(ik.Spring, "hand", "hand")),
    ("a force: two torques", push(ik.Actuator, "elbow", [1, 2])),
    ("a force: free-flyer by PD", push(ik.Actuator, "root_joint", ik.PD(1.0), robot=BALL)),
    ("a force: table of falling times", made(ik.TorqueTable, [1, 0], [0, 0])),
    ("a force: dry friction below 0", push(ik.JointFriction, "elbow", -1.0)),
    ("a force: world pushed", push(ik.AppliedForce, "world")),
    ("a force: impulse as force", push(ik.AppliedImpulse, "hand")),
    # States
    ("an impact: quaternion", lambda: ik.solve(RESTING, np.zeros(7), FALL)),
    ("an impact: reaction", lambda: ik.solve(STRUCK, Q, V).reactions["elbw"]),
    ("an impact: derivatives of adhesion", lambda: ik.derivatives(solved(ik.Contact("ball", adhesion=1.0)))),
    # Motions
    ("a motion: tolerance of 0", followed(rtol=0)),
    ("a motion: integrator", followed(method="dopri853")),
    ("a motion: holds no force", lambda: ik.simulate(ik.Scene(BALL, contacts=[ik.Contact("ball", adhesion=1.0)]), BALL.neutral(), FALL, duration=0.1)),
    # More of what scenes, motions and batches refuse
    ("a constraint: an unknown other", held(ik.PointAnchor, "hand", "wrld")),
    ("a constraint: lock nan", held(ik.JointLock, "elbow", NAN)),
    ("a constraint: lock without a name", held(ik.JointLock, "")),
    ("a constraint: a fixed joint coupled", held(ik.JointCoupling, "elbow", "wrist")),
    ("a constraint: coupled twice to one", held(ik.JointCoupling, "elbow", ["shoulder", "shoulder"], [1, 2])),
    ("a constraint: velocities of other directions", held(ik.FrameAnchor, "hand", directions=("x", "rz"), velocity=(1, 2, 3))),
    ("a constraint: a rod of no length", lambda: ik.solve(ik.Scene(BALL, constraints=[ik.DistanceAnchor("ball")]), BALL.neutral(), FALL)),
    ("a constraint: a function that fails", lambda: kept(constraints=[ik.GapConstraint(lambda q: {}[q[0]])])),
    ("a constraint: a gradient of one number", held(ik.GapConstraint, lambda q: q[1], gradient=lambda q: [1])),
    ("controlled: an unknown joint", lambda: ik.Scene(ARM, controlled=["elbw"])),
    ("controlled: a joint twice", lambda: ik.Scene(ARM, controlled=["elbow", "elbow"])),
    ("controlled: a number among names", lambda: ik.Scene(ARM, controlled=[3])),
    ("controlled: a number", lambda: ik.Scene(ARM, controlled=3)),
    ("a contact: three frictions", touch(ik.Contact, "ball", friction=(0.1, 0.2, 0.3))),
    ("a contact: friction in words", touch(ik.Contact, "ball", friction="rough")),
    ("a contact: infinite static friction", touch(ik.Contact, "ball", friction=(INF, 0.5))),
    ("a contact: a function gives friction below 0", lambda: solved(ik.Contact("ball", friction=lambda u: -1.0))),
    ("a contact: an ellipse below 0", made(ik.EllipticFriction, 0.3, -0.1)),
    ("a contact: an ellipse along the normal", lambda: solved(ik.Contact("ball", friction=ik.EllipticFriction(1, 1, along=[0, 0, 1])))),
    ("a contact: static friction and tangential restitution", lambda: solved(ik.Contact("ball", friction=(0.2, 0.1), tangential_restitution=0.5))),
    ("a contact: static friction along the path", touch(ik.Contact, "ball", friction=(0.2, 0.1), law=ik.Law(slip="path"))),
    ("a contact: negative holding force", touch(ik.Contact, "ball", holding_force=-1.0)),
    ("a contact: holding force that bounces", touch(ik.Contact, "ball", holding_force=1.0, restitution=0.5)),
    ("a contact: holding force that rolls", touch(ik.Contact, "ball", holding_force=1.0, rolling=0.1)),
    ("a contact: a wrong normal of a gap", touch(ik.GapContact, lambda q: q[0], normal=lambda q: [0, 2, 0, 0, 0, 0])),
    ("a force: a spring of one side that pulls", made(ik.JointSpring, "elbow", 1.0, acts="pull")),
    ("a force: a spring that acts above", made(ik.Spring, "hand", acts="above")),
    ("a force: a rest length below 0", made(ik.Spring, "hand", rest_length=-1)),
    ("a force: a limit below 0", made(ik.PD, 1.0, limit=-2.0)),
    ("a force: a torque in words", made(ik.Actuator, "elbow", "strong")),
    ("a force: no torques", made(ik.TorqueTable, [], [])),
    ("a force: one torque for two times", made(ik.TorqueTable, [0.0, 1.0], [1.0])),
    ("a force: two numbers", push(ik.AppliedForce, "hand", linear=[1, 2])),
    ("a force: axes", push(ik.AppliedForce, "hand", axes="body")),
    ("a force: base pushed", push(ik.AppliedForce, "base")),
    ("a force: free-flyer by a table", push(ik.Actuator, "root_joint", ik.TorqueTable([0.0], [1.0]), robot=BALL)),
    ("a force: dry friction of a free-flyer", push(ik.JointFriction, "root_joint", 1.0, robot=BALL)),
    ("an impact: derivatives of a function", lambda: ik.derivatives(kept(constraints=[FUNCTION]))),
    ("an impact: a check of a function", lambda: ik.check(kept(constraints=[FUNCTION]))),
    ("an impact: derivatives of static friction", lambda: ik.derivatives(solved(ik.Contact("ball", friction=(0.2, 0.1))))),
    ("a motion: driven from elsewhere", lambda: ik.simulate(ik.Scene(ARM, constraints=[ik.Driven("elbow", math.cos)]), Q, V, 0.1)),
    ("a motion: a longest step of 0", followed(max_step=0.0)),
    ("a motion: a stop time as a number", followed(stop_times=0.5)),
    ("a motion: a stop time below 0", followed(stop_times=[-0.1])),
    ("a motion: half a sample", followed(samples=2.5)),
    ("a motion: a method by number", followed(method=1)),
    ("a motion: dry friction followed by deviations", lambda: ik.sensitivity(ik.simulate(ik.Scene(ARM, forces=[ik.JointFriction("elbow", 1.0)]), Q, V, 0.01))),
    ("a motion: what is held followed by deviations", lambda: ik.sensitivity(ik.simulate(ik.Scene(BALL, contacts=[GRIPS], gravity=(0, 0, 0)), BALL.neutral(), 0.0 * FALL, 0.01))),
    ("a batch: points of an unknown contact", points({"foot": [0, 0, 0]})),
    ("a batch: points of two numbers", points({"floor": [0, 0]})),
    ("a batch: points of other rows", points({"floor": np.zeros((3, 3))})),
    ("a batch: points without a name", points([0, 0, 0])),
    ("a batch: a point of NaN", points({"floor": [NAN, 0, 0]})),
    ("a plane whose axes are askew", made(ik.models.planar_root, [1, 0, 0], [1, 0, 1])),
    # What functions give
    *((f"a force: a function gives {what}", lambda value=value: ik.simulate(ik.Scene(BALL, forces=[ik.AppliedForce("ball", gives(value), name="gust")]), BALL.neutral(), FALL, 0.1)) for what, value in WRONG_VALUES.items()),
    *((f"a torque: a function gives {what}", lambda value=value: ik.simulate(ik.Scene(ARM, forces=[ik.Actuator("elbow", gives(value), name="motor")]), Q, V, 0.1)) for what, value in WRONG_VALUES.items()),
    *((f"a restitution: a function gives {what}", bounced(gives(value))) for what, value in WRONG_VALUES.items()),
    # Forces over time and their peaks
    ("a history: no restitution by Hunt and Crossley", lambda: force_history(solved(ik.Contact("ball")), HuntCrossley(1e6))),
    ("a history: more energy than the curve", lambda: force_history(solved(FLOOR, v=9.0 * FALL), RUBBER)),
    ("a history: of an unknown contact", history(RUBBER, "flor")),
    ("a history: of a list", lambda: force_history([], RUBBER)),
    ("peaks: of a robot", lambda: peak_forces(BALL, BALL.neutral(), [FALL], RUBBER)),
    ("peaks: a number for a curve", peaks(curve=1e6)),
    ("peaks: of two contacts", peaks(FLOOR, ik.Contact("ball"))),
    ("peaks: under Poisson's law", peaks(law=ik.Law("poisson"))),
    ("peaks: more energy than the curve", peaks(v=9.0 * FALL)),
    # Other numbers of impulses, and places
    ("other impulses: an unknown blow", at_once({"blwo": [0, 0, 1]})),
    ("other impulses: two numbers", at_once({"blow": [0, 0]})),
    ("other impulses: rows for one state", at_once({"blow": np.zeros((2, 3))})),
    ("other impulses: nan", at_once({"blow": [0, 0, NAN]})),
    ("a place: of an unknown frame", placed("ball/bal", at_frame="arm/hand")),
    ("a place: of what a joint moves", placed("arm/hand", at_frame="ball/ball")),
    ("a place: at itself", placed("ball/ball", at_frame="ball/ball")),
    ("a place: of what is fixed", placed("arm/base", at_frame="ball/ball")),
    ("a place: a mirror for a rotation", placed("ball/ball", rotation=np.diag([1.0, 1.0, -1.0]))),
    ("a place: two numbers", placed("ball/ball", at=[1, 2])),
    ("a pose: two rotations", made(ik.pose, rpy=[0, 0, 0], wxyz=[1, 0, 0, 0])),
    ("a pose: a quaternion of zeros", made(ik.pose, wxyz=[0, 0, 0, 0])),
    ("a pose: two angles", made(ik.pose, rpy=[0, 0])),
    ("a robot that stands on nothing", lambda: BALL.stand(BALL.neutral())),
    ("an arm that stands", lambda: ARM.with_ground().stand(Q)),
    ("collisions with a ground that is not there", lambda: ik.collisions(ARM, "*", "ground")),
    ("collisions of an unknown link", lambda: ik.collisions(ARM, "fore_am")),
    ("collisions of a link without geometry", lambda: ik.collisions(ARM, "hand")),
    ("collisions by a word that is none", lambda: ik.Scene(ARM, collisions="none")),
    ("a constraint: a number for directions", made(ik.FrameAnchor, "a", "b", directions=3)),
    ("a constraint: a number for a joint", made(ik.JointCoupling, "a", 3)),
    ("a batch: a number for a client", lambda: ik.solve_batch(STRUCK, Q, V, client=1)),
    ("a batch: friction beside what is no number", lambda: ik.solve_batch(ik.Scene(BALL, contacts=[ik.Contact("ball", friction=ik.EllipticFriction(0.8, 0.2), name="a"), FLOOR]), BALL.neutral(), friction={"floor": [0.1, 0.2]})),
    ("a batch: an output that was not asked for", lambda: ik.solve_batch(STRUCK, Q, V).dv),
    # Sentences that send to the right place
    ("a collision with a ground that is not there", touch(ik.Collision, "fore_arm", "ground", robot=ARM)),
    ("a contact against the ground", touch(ik.Contact, "ball", against="ground")),
    ("a state for a scene", lambda: ik.Scene(ARM, ARM.neutral(), ARM.velocity())),
)  # fmt: skip

FAULTS = tuple(Fault(what, act) for what, act in _ROWS)
