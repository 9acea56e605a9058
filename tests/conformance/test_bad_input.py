"""What cannot be: each call with the error it brings and the words that have to be in it."""

# One call a line, however long; wrong types are what it is about.
# ruff: noqa: E501

from __future__ import annotations

import math

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import ImpulsekitError

NAN, INF = math.nan, math.inf


def _arm():
    box = '<collision><geometry><box size="0.1 0.1 1"/></geometry></collision>'

    def link(name, inside=""):
        return (
            f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" '
            f'ixy="0" ixz="0" iyz="0"/></inertial>{inside}</link>'
        )

    def joint(name, kind, parent, child):
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            '<origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="10" velocity="5"/></joint>'
        )

    parts = [link("base", box), link("upper_arm", box), link("fore_arm", box), link("hand")]
    parts += [
        joint("shoulder", "revolute", "base", "upper_arm"),
        joint("elbow", "revolute", "upper_arm", "fore_arm"),
    ]
    parts += [joint("wrist", "fixed", "fore_arm", "hand")]
    return ik.Robot.from_urdf(f'<robot name="arm">{"".join(parts)}</robot>')


ARM = _arm()
BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
BOTH = ik.combine(arm=ARM, ball=BALL)
Q, V = [0.1, 0.2], [0.0, 0.0]
FALL = BALL.velocity(root_joint=[0, 0, -1, 0, 0, 0])
STRUCK = ik.Scene(ARM, [ik.AppliedImpulse("hand", linear=[1, 0, 0], name="blow")])
RESTING = ik.Scene(BALL, contacts=[ik.Contact("ball", restitution=0.5, friction=0.3, name="floor")])


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


def batch(q=Q, v=V, scene=STRUCK, **given):
    return lambda: ik.solve_batch(scene, q, v, **given)


def balls(**given):
    return batch(BALL.neutral(), BALL.velocity(), RESTING, **given)


AT_ONCE = [ik.Contact("ball", at=[x, 0, 0], friction=0.3, restitution=0.5) for x in (0.0, 0.1)]
STIFF = ik.Contact("ball", stiffness=1.0, restitution=0.5)
STRONGE, LZB = ik.Law("stronge", "path"), ik.Law("lzb")

ROWS = [
    # Impulses
    ("frame", blow("hnad", [1, 0, 0]), "UnknownName", "impulses[0]", '"hnad"', '"hand"'),
    ("empty frame", blow("", [1, 0, 0]), "Input", "frame", '""'),
    ("frame by number", blow(3, [1, 0, 0]), "Input", "frame", "3"),
    ("world struck", blow("world", [1, 0, 0]), "Input", "world", "freeflyer"),
    ("base struck", blow("base", [1, 0, 0]), "Input", '"base"', "freeflyer"),
    ("one number", blow("hand", 5), "Shape", "linear", "5"),
    ("two numbers", blow("hand", [5, 0]), "Shape", "linear", "(3,)", "(2,)"),
    ("nan", blow("hand", [0, NAN, 0]), "NotFinite", "linear[1]", "nan"),
    ("words", blow("hand", ["hard", 0, 0]), "NotFinite", "linear[0]", '"hard"'),
    ("complex", blow("hand", [np.complex128(1), 0, 0]), "NotFinite", "linear[0]"),
    ("too large", blow("hand", [1e200, 0, 0]), "Range", "linear[0]", "1e+200"),
    ("four couples", blow("hand", angular=[0, 0, 0, 1]), "Shape", "angular", "(4,)"),
    ("at by name", blow("hand", [1, 0, 0], at="tip"), "Shape", "at", '"tip"'),
    ("axes", blow("hand", [1, 0, 0], axes="body"), "Range", "axes", '"world"', '"local"', '"body"'),
    ("empty name", blow("hand", [1, 0, 0], name=""), "Input", "name"),
    ("unprintable name", blow("hand", [1, 0, 0], name="\x1b[2J"), "Input", "printable"),
    ("joint", kick("elbo", 1), "UnknownName", "impulses[0]", '"elbo"', '"elbow"'),
    ("two in one joint", kick("elbow", [1, 2]), "Shape", '"elbow"', "(1,)", "(2,)"),
    ("fixed joint kicked", kick("wrist", 1), "Input", '"wrist"', "fixed"),
    ("contact as impulse", lambda: ik.Scene(ARM, [ik.Contact("hand")]), "Input", "impulses[0]", "Contact"),
    ("no list", lambda: ik.Scene(ARM, ik.AppliedImpulse("hand")), "Input", "impulses", "list"),
    ("one name twice", lambda: ik.Scene(ARM, [ik.JointImpulse("elbow", 1, name="a"), ik.JointImpulse("shoulder", 1, name="a")]), "Input", '"a"'),
    ("path as robot", lambda: ik.Scene("arm.urdf"), "Input", "robot", "Robot"),
    ("gravity", lambda: ik.Scene(ARM, gravity=-9.81), "Shape", "gravity", "-9.81"),
    ("law by name", lambda: ik.Scene(ARM, law="newton"), "Input", "law", "Law"),
    # Constraints
    ("anchored frame", held(ik.PointAnchor, "hnd"), "UnknownName", "constraints[0]", '"hnd"', '"hand"'),
    ("to itself", held(ik.PointAnchor, "hand", "hand"), "Input", "itself"),
    ("in one body", held(ik.PointAnchor, "hand", "fore_arm"), "Input", '"hand"', '"fore_arm"', "one rigid body"),
    ("base anchored", held(ik.PointAnchor, "base"), "Input", '"base"', "world"),
    ("anchor velocity", held(ik.PointAnchor, "hand", velocity="slow"), "Range", "velocity", "kept", '"slow"'),
    ("anchor velocities", held(ik.PointAnchor, "hand", velocity=[0, 1]), "Shape", "velocity", "(2,)"),
    ("direction", held(ik.FrameAnchor, "hand", directions=["x", "w"]), "Range", "directions", "w"),
    ("direction twice", held(ik.FrameAnchor, "hand", directions=["x", "x"]), "Range", "directions"),
    ("no direction", held(ik.FrameAnchor, "hand", directions=[]), "Range", "directions"),
    ("lock", held(ik.JointLock, "elbw"), "UnknownName", '"elbw"', '"elbow"'),
    ("fixed joint locked", held(ik.JointLock, "wrist"), "Input", '"wrist"', "fixed"),
    ("lock velocities", held(ik.JointLock, "elbow", [0, 1]), "Shape", '"elbow"', "(2,)"),
    ("coupled to itself", held(ik.JointCoupling, "elbow", "elbow"), "Input", "other"),
    ("ratios", held(ik.JointCoupling, "elbow", "shoulder", [1, 2]), "Shape", "ratio", "(2,)"),
    ("free-flyer coupled", held(ik.JointCoupling, "ball/root_joint", "arm/elbow", robot=BOTH), "Input", "6 degrees"),
    ("rod in one body", held(ik.DistanceAnchor, "hand", "fore_arm"), "Input", "one rigid body"),
    ("driven by number", held(ik.Driven, "elbow", 3.0), "Input", "position", "function"),
    ("wrong rate", held(ik.Driven, "elbow", lambda t: t * t, velocity=lambda t: t), "Range", "velocity"),
    ("gap as number", held(ik.GapConstraint, 3.0), "Input", "g must be a function"),
    ("wrong gradient", held(ik.GapConstraint, lambda q: q[0], gradient=lambda q: [[2.0, 0.0]]), "Range", "gradient"),
    ("impulse as constraint", held(ik.AppliedImpulse, "hand"), "Input", "constraints[0]", "AppliedImpulse"),
    ("controlled and locked", lambda: ik.Scene(ARM, controlled=["elbow"], constraints=[ik.JointLock("elbow")]), "Input", "elbow"),
    ("two locks", lambda: ik.solve(ik.Scene(ARM, constraints=[ik.JointLock("elbow", 1.0), ik.JointLock("elbow", 2.0)]), Q, V), "Contradiction", "constraints[0]", "constraints[1]"),
    # Contacts and coefficients
    ("touching frame", touch(ik.Contact, "bal"), "UnknownName", "contacts[0]", '"bal"', '"ball"'),
    ("touches itself", touch(ik.Contact, "ball", against="ball"), "Input", "itself"),
    ("base touches", touch(ik.Contact, "base", robot=ARM), "Input", '"base"', "world"),
    ("no normal", touch(ik.Contact, "ball", normal=[0, 0, 0]), "Range", "normal"),
    ("restitution above 1", touch(ik.Contact, "ball", restitution=1.2), "Range", "restitution", "0 to 1", "1.2"),
    ("restitution below 0", touch(ik.Contact, "ball", restitution=-0.1), "Range", "restitution", "-0.1"),
    ("restitution nan", touch(ik.Contact, "ball", restitution=NAN), "NotFinite", "restitution"),
    ("restitution by name", touch(ik.Contact, "ball", restitution="steel"), "Input", "restitution", '"steel"'),
    ("friction below 0", touch(ik.Contact, "ball", friction=-0.1), "Range", "friction", "-0.1"),
    ("friction infinite", touch(ik.Contact, "ball", friction=INF), "NotFinite", "friction"),
    ("kinetic above static", touch(ik.Contact, "ball", friction=(0.1, 0.2)), "Range", "kinetic", "static"),
    ("rolling below 0", touch(ik.Contact, "ball", rolling=-1e-3), "Range", "rolling"),
    ("tangential above 1", touch(ik.Contact, "ball", tangential_restitution=2), "Range", "tangential_restitution"),
    ("capture speed", made(ik.Restitution, 0.5, -1), "Range", "capture_speed"),
    ("falling speeds", made(ik.RestitutionTable, [1, 0], [0.5, 0.5]), "Range", "speeds"),
    ("one value", made(ik.FrictionTable, [0, 1], [0.5]), "Shape", "values", "(1,)"),
    ("axis without length", made(ik.EllipticFriction, 0.1, 0.2, [0, 0, 0]), "Range", "along"),
    ("function gives 2", bounced(lambda speed: 2.0), "Range", "floor", "restitution", "2.0"),
    ("function gives nothing", bounced(lambda speed: None), "Callback", "floor", "None"),
    ("function raises", bounced(lambda speed: 1 / 0), "Callback", "floor", "ZeroDivisionError"),
    ("stop", touch(ik.JointStop, "elbw", robot=ARM), "UnknownName", '"elbw"', '"elbow"'),
    ("free-flyer stopped", touch(ik.JointStop, "root_joint"), "Input", '"root_joint"'),
    ("stop upside down", touch(ik.JointStop, "elbow", lower=1.0, upper=0.0, robot=ARM), "Range", "lower", "upper"),
    ("no such geometry", touch(ik.Collision, "fore_am", "base", robot=ARM), "UnknownName", '"fore_am"', '"fore_arm"'),
    ("no geometry", touch(ik.Collision, "hand", "base", robot=ARM), "Input", '"hand"', "geometry"),
    ("margin", touch(ik.Collision, "fore_arm", "base", margin=-1.0, robot=ARM), "Range", "margin"),
    ("rope without length", touch(ik.Rope, "ball", length=0.0), "Range", "length", "above 0"),
    ("gap friction", touch(ik.GapContact, lambda q: q[2], friction=0.3), "Input", "tangents"),
    ("law as contact", lambda: ik.Scene(BALL, contacts=[ik.Law()]), "Input", "contacts[0]", "Law"),
    ("no material", touch(ik.Contact, "ball", restitution="material"), "Input", "material"),
    ("unknown pair", lambda: ik.Scene(BALL, materials=[ik.MaterialPair("rubber", "steel")]), "Input", '"rubber"'),
    # Laws
    ("restitution law", made(ik.Law, "newtn"), "Range", '"newton"', '"poisson"', '"stronge"', '"lzb"', '"newtn"'),
    ("slip", made(ik.Law, slip="start"), "Range", '"end"', '"path"'),
    ("order", made(ik.Law, order="random"), "Range", '"simultaneous"', '"sequential"'),
    ("stronge at the end", made(ik.Law, "stronge"), "Input", "stronge", 'slip="path"'),
    ("exponent", made(ik.Law, "lzb", exponent=0.5), "Range", "exponent", "1 to 10"),
    ("lzb in sequence", made(ik.Law, "lzb", order="sequential"), "Input", "lzb", "stronge"),
    ("no stiffness", touch(ik.Contact, "ball", law=LZB), "Input", "stiffness"),
    ("stiffness of 0", touch(ik.Contact, "ball", stiffness=0.0), "Range", "stiffness"),
    ("tangential under lzb", touch(ik.Contact, "ball", stiffness=1.0, friction=0.1, tangential_restitution=0.5, law=LZB), "Input", "tangential"),
    ("adhesion bounces", touch(ik.Contact, "ball", adhesion=1.0, restitution=0.5), "Input", "adhesion", "restitution"),
    ("rolling under stronge", touch(ik.Contact, "ball", rolling=0.1, law=STRONGE), "Input", "rolling"),
    ("two rub along paths", lambda: solved(*AT_ONCE, law=ik.Law(slip="path")), "Input", "path", "sequential"),
    ("two under stronge", lambda: solved(*AT_ONCE, law=STRONGE), "Input", "stronge", "sequential"),
    # Forces
    ("spring", push(ik.JointSpring, "elbw"), "UnknownName", "forces[0]", '"elbow"'),
    ("free-flyer sprung", push(ik.JointSpring, "root_joint", robot=BALL), "Input", "6 degrees"),
    ("stiffness below 0", push(ik.JointSpring, "elbow", -1), "Range", "stiffness"),
    ("damping nan", push(ik.JointSpring, "elbow", damping=NAN), "NotFinite", "damping"),
    ("spring in itself", push(ik.Spring, "hand", "hand"), "Input", "moves nothing"),
    ("two torques", push(ik.Actuator, "elbow", [1, 2]), "Shape", '"elbow"', "(2,)"),
    ("free-flyer by PD", push(ik.Actuator, "root_joint", ik.PD(1.0), robot=BALL), "Input", "PD"),
    ("table of falling times", made(ik.TorqueTable, [1, 0], [0, 0]), "Range", "times"),
    ("dry friction below 0", push(ik.JointFriction, "elbow", -1.0), "Range", "torque"),
    ("world pushed", push(ik.AppliedForce, "world"), "Input", "world"),
    ("impulse as force", push(ik.AppliedImpulse, "hand"), "Input", "forces[0]", "AppliedImpulse"),
    # States
    ("robot solved", lambda: ik.solve(ARM, Q, V), "Input", "solve", "Scene", "Robot"),
    ("short q", lambda: ik.solve(STRUCK, [0.1], V), "Shape", "(2,)", "(1,)"),
    ("q nan", lambda: ik.solve(STRUCK, [NAN, 0.0], V), "NotFinite", "shoulder"),
    ("q complex", lambda: ik.solve(STRUCK, np.array([0.1 + 1j, 0.2]), V), "NotFinite", "q"),
    ("q of texts", lambda: ik.solve(STRUCK, ["0", "0"], V), "Input", "q"),
    ("masked v", lambda: ik.solve(STRUCK, Q, np.ma.masked_array(V, mask=[True, False])), "NotFinite", "v"),
    ("quaternion", lambda: ik.solve(RESTING, np.zeros(7), FALL), "State", "quaternion"),
    ("v too fast", lambda: ik.simulate(STRUCK, Q, [1e150, 0.0]), "Range", "1e+150"),
    ("point", lambda: ik.solve(STRUCK, Q, V).velocity_at("hnad"), "UnknownName", '"hand"'),
    ("reaction", lambda: ik.solve(STRUCK, Q, V).reactions["elbw"], "UnknownName", '"elbow"'),
    ("no derivatives", lambda: ik.derivatives(STRUCK), "Input", "derivatives", "Impact"),
    ("derivatives of adhesion", lambda: ik.derivatives(solved(ik.Contact("ball", adhesion=1.0))), "Input", "adhesion"),
    # Motions
    ("robot followed", lambda: ik.simulate(ARM, Q, V), "Input", "simulate", "Scene"),
    ("time below 0", followed(duration=-1), "Range", "duration"),
    ("time nan", followed(duration=NAN), "NotFinite", "duration"),
    ("setting", followed(rtl=1e-8), "UnknownName", '"rtl"', '"rtol"'),
    ("tolerance of 0", followed(rtol=0), "Range", "rtol"),
    ("integrator", followed(method="dopri853"), "Range", "method", '"dop853"'),
    ("falling samples", followed(duration=1.0, samples=[0.5, 0.1]), "Range", "samples", "rising"),
    ("samples past the end", followed(duration=0.1, samples=[0.0, 0.5]), "Range", "samples"),
    ("settings as dict", followed(settings={"duration": 1.0}), "Input", "settings", "MotionSettings"),
    ("in the floor", lambda: ik.simulate(RESTING, BALL.configuration(root_joint=[0, 0, -1, 0, 0, 0, 1]), BALL.velocity(), duration=0.1), "Input", "floor", "penetration"),
    ("holds no force", lambda: ik.simulate(ik.Scene(BALL, contacts=[ik.Contact("ball", adhesion=1.0)]), BALL.neutral(), FALL, duration=0.1), "Input", "holding_force"),
    # Batches
    ("batch of a robot", batch(scene=ARM), "Input", "solve_batch", "Scene"),
    ("no rows", batch(np.zeros((0, 2))), "Shape", "q", "(0, 2)"),
    ("wide rows", batch(np.zeros((4, 3))), "Shape", "q", "(4, 3)"),
    ("rows disagree", batch(np.zeros((4, 2)), np.zeros((3, 2))), "Shape", "v", "(3, 2)"),
    ("shared nan", batch([NAN, 0.0]), "NotFinite", "shoulder"),
    ("output", batch(outputs=["v_afer"]), "UnknownName", '"v_afer"', '"v_after"'),
    ("threads", batch(threads=-1), "Range", "threads"),
    ("blows of two", batch(impulses=np.zeros((4, 2))), "Shape", "blow", "(4, 2)"),
    ("unknown blow", batch(impulses={"blw": np.zeros((4, 3))}), "UnknownName", '"blow"'),
    ("friction of nothing", batch(friction=0.3), "Input", "friction", "contacts"),
    ("batch restitution", balls(restitution=2.0), "Range", "restitution", "2.0"),
    ("unknown contact", balls(friction={"flor": 0.2}), "UnknownName", '"flor"', '"floor"'),
    ("masses by number", batch(masses=2.0), "Input", "masses"),
    ("unknown link", batch(masses={"hnad": 2.0}), "UnknownName", '"hnad"', '"hand"'),
    ("mass below 0", batch(masses={"hand": -1.0}), "Range", "masses"),
]  # fmt: skip


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_it_is_refused_in_words_that_help(row):
    _, call, kind, *words = row
    with pytest.raises(ImpulsekitError) as told:
        call()
    assert type(told.value).__name__ == f"{kind}Error"
    missing = [word for word in words if word not in str(told.value)]
    assert not missing, str(told.value)


def test_a_row_that_cannot_be_is_flagged_and_the_others_solved():
    q = np.tile(BALL.neutral(), (4, 1))
    v = np.tile(FALL, (4, 1))
    q[1] = 0.0
    v[2, 0] = NAN
    batch = ik.solve_batch(RESTING, q, v, restitution=np.array([[0.5], [0.5], [0.5], [2.0]]))
    assert batch.valid.tolist() == [True, False, False, False]
    assert len(set(batch.status.tolist())) == 4
    assert batch.v_after[0, 2] == pytest.approx(0.5, abs=1e-12)
    assert np.isnan(batch.v_after[1:]).all()
