"""Faults in calls: misspelt, missing and surplus arguments, and things of the wrong kind."""

# One fault a line, however long; wrong types are what it is about.
# ruff: noqa: E501
# mypy: ignore-errors

from __future__ import annotations

import functools
from typing import Any

import numpy as np

import impulsekit as ik
from impulsekit import compliance, design, long, measured, models, study
from impulsekit.checking import check

from .fault import Fault
from .things import arm, ball, both, resting, struck

Q, V = [0.1, 0.2], [0.0, 0.0]


@functools.cache
def _impact() -> Any:
    return ik.solve(struck(), Q, V)


@functools.cache
def _landing() -> Any:
    return ik.solve(resting(), ball().neutral(), ball().velocity(root_joint=[0, 0, -1, 0, 0, 0]))


@functools.cache
def _motion() -> Any:
    q = ball().configuration(root_joint=[0, 0, 0.01, 0, 0, 0, 1])
    return ik.simulate(resting(), q, ball().velocity(), duration=0.1, samples=5)


def _sim() -> Any:
    return ik.Simulation(struck(), Q, V)


def _assigned() -> None:
    _sim().controls = np.zeros(2)


FAULTS = (
    # Robots.
    Fault("gives one gear ratio for all joints", lambda: arm().with_armature({"elbow": 1e-4}, gear=100)),
    Fault("gives an armature as a number", lambda: arm().with_armature(0.1)),
    Fault("makes a Robot of a path", lambda: ik.Robot("arm.urdf")),
    Fault("makes a Robot of nothing", lambda: ik.Robot()),
    Fault("combines robots without names", lambda: ik.combine(arm(), ball())),
    Fault("combines a robot with a dictionary", lambda: ik.combine({"arm": arm()}, ball())),
    Fault("places robots by a list of points", lambda: ik.combine(arm=arm(), placements=[[0, 0, 0]])),
    Fault("asks for a configuration by a list", lambda: arm().configuration([0, 1])),
    Fault("asks for a configuration by a number", lambda: arm().configuration(0.3)),
    Fault("asks for a velocity by an array", lambda: arm().velocity(np.zeros(2))),
    Fault("asks for a velocity of a misspelt joint", lambda: arm().velocity(elbwo=1.0)),
    Fault("misspells the root of a robot", lambda: ik.Robot.from_urdf("models/ball.urdf", rot="freeflyer")),
    Fault("gives a robot two roots", lambda: ik.Robot.from_example("panda", "fixed", "planar")),
    Fault("asks for an example without a name", lambda: ik.Robot.from_example()),
    Fault("asks for an example by a number", lambda: ik.Robot.from_example(7)),
    Fault("reads a file that is None", lambda: ik.Robot.from_file(None)),
    Fault("adds a body without a mass", lambda: arm().with_body("hand")),
    Fault("adds a body with a weight", lambda: arm().with_body("hand", weight=1.0)),
    Fault("locks a joint at a word", lambda: arm().with_lock({"elbow": "bent"})),
    Fault("locks a number", lambda: arm().with_lock(3)),
    Fault("grounds a robot at a word", lambda: arm().with_ground("low")),
    Fault("grounds a robot by z=", lambda: arm().with_ground(z=-0.1)),
    Fault("asks for the placement of a misspelt frame", lambda: arm().placement(Q, "hnad")),
    Fault("asks for the placement before the configuration", lambda: arm().placement("hand", Q)),
    Fault("asks for a Jacobian without a frame", lambda: arm().jacobian(Q)),
    Fault("asks for a Jacobian of an unknown frame", lambda: arm().jacobian(Q, "hnad")),
    Fault("asks for a velocity that is no vector", lambda: arm().velocity_for("hand", linear=0.5, q=Q)),
    Fault("asks for a velocity without a configuration", lambda: arm().velocity_for("hand", linear=[1, 0, 0])),
    Fault("asks a hinge to lift its hand", lambda: arm().velocity_for("hand", linear=[1, 1, 1], q=Q)),
    Fault("asks for a velocity of nothing", lambda: arm().velocity_for("hand", q=Q)),
    Fault("gives a pose a quaternion", lambda: ik.pose([0, 0, 0], quaternion=[1, 0, 0, 0])),
    Fault("gives a pose two rotations", lambda: ik.pose(rpy=[0, 0, 0], xyzw=[0, 0, 0, 1])),
    Fault("gives a pose in words", lambda: ik.pose("origin")),
    Fault("reads MuJoCo's state off an array", lambda: ik.mujoco_state([1, 2])),
    Fault("reads MuJoCo's state off nothing", lambda: ik.mujoco_state(None)),
    Fault("writes MuJoCo's state into a list", lambda: ik.set_mujoco_state([], [0], [0])),
    Fault("places a robot by a number", lambda: ik.place(arm(), 3)),
    # Entries.
    Fault("gives a contact mu", lambda: ik.Contact("ball", mu=0.5)),
    Fault("gives a contact e", lambda: ik.Contact("ball", e=0.5)),
    Fault("gives a contact a misspelt friction", lambda: ik.Contact("ball", fricton=0.5)),
    Fault("makes a contact of nothing", lambda: ik.Contact()),
    Fault("gives a contact a point in words", lambda: ik.Contact("ball", at="centre")),
    Fault("gives a contact a normal of zeros", lambda: ik.Contact("ball", normal=[0, 0, 0])),
    Fault("gives a collision one body", lambda: ik.Collision("ball")),
    Fault("gives a collision body1", lambda: ik.Collision("ball", other_body="arm")),
    Fault("gives a blow a force", lambda: ik.AppliedImpulse("hand", force=[1, 0, 0])),
    Fault("gives a blow a magnitude", lambda: ik.AppliedImpulse("hand", magnitude=5)),
    Fault("gives a blow a number", lambda: ik.AppliedImpulse("hand", 5)),
    Fault("gives a joint impulse no number", lambda: ik.JointImpulse("elbow")),
    Fault("gives a joint impulse words", lambda: ik.JointImpulse("elbow", "hard")),
    Fault("gives a controller kp", lambda: ik.PD(kp=1.0)),
    Fault("gives a controller kd", lambda: ik.PD(10.0, kd=1.0)),
    Fault("gives a controller a gain in words", lambda: ik.PD("stiff")),
    Fault("gives a spring k", lambda: ik.JointSpring("elbow", k=10)),
    Fault("gives a spring damping in words", lambda: ik.JointSpring("elbow", damping="soft")),
    Fault("gives an actuator a formula", lambda: ik.Actuator("elbow", "sin(t)")),
    Fault("gives an actuator nothing", lambda: ik.Actuator("elbow")),
    Fault("gives an applied force no frame", lambda: ik.AppliedForce(linear=[0, 0, 1])),
    Fault("gives a lock a place", lambda: ik.JointLock("elbow", position=0.3)),
    Fault("gives a coupling one joint", lambda: ik.JointCoupling("elbow")),
    Fault("gives a coupling a ratio in words", lambda: ik.JointCoupling("elbow", "shoulder", ratio="half")),
    Fault("gives an anchor a point of two numbers", lambda: ik.PointAnchor("hand", at=[0, 1])),
    Fault("gives a rope a length in words", lambda: ik.Rope("hand", "world", length="long")),
    Fault("gives a law a friction", lambda: ik.Law(friction="coulomb")),
    Fault("gives a law coulomb", lambda: ik.Law("coulomb")),
    Fault("gives a law an order in capitals", lambda: ik.Law(order="Sequential")),
    Fault("gives a law four words", lambda: ik.Law("newton", "end", "simultaneous", 1.5, "fast")),
    Fault("gives a friction table one column", lambda: ik.FrictionTable([0.1, 0.2])),
    Fault("gives elliptic friction a dictionary", lambda: ik.EllipticFriction({"x": 0.1})),
    Fault("gives a material a colour", lambda: ik.Material("steel", colour="grey")),
    # Scenes.
    Fault("gives a scene an impulse", lambda: ik.Scene(arm(), impulse=[])),
    Fault("gives a scene ground", lambda: ik.Scene(arm(), ground=True)),
    Fault("makes a scene of nothing", lambda: ik.Scene()),
    Fault("makes a scene of a path", lambda: ik.Scene("arm.urdf")),
    Fault("gives a scene one contact, no list", lambda: ik.Scene(ball(), contacts=ik.Contact("ball"))),
    Fault("replaces a misspelt entry", lambda: struck().replace(gravty=[0, 0, 0])),
    Fault("takes file contacts by a misspelt name", lambda: ik.Scene.of_robot(arm(), file_contact=True)),
    Fault("takes file contacts of the floor", lambda: ik.Scene.of_robot(arm(), file_contacts="floor")),
    Fault("asks a scene for a misspelt contact", lambda: resting().contacts["flor"]),
    Fault("asks a scene for a misspelt impulse", lambda: struck().impulses["blw"]),
    Fault("lets everything collide with mu", lambda: ik.collisions(both(), mu=0.2)),
    Fault("excludes a link alone", lambda: ik.collisions(both(), exclude="arm/hand")),
    Fault("excludes half a pair", lambda: ik.collisions(both(), exclude=[("arm/hand",)])),
    Fault("excludes an unknown link", lambda: ik.collisions(both(), exclude=[("arm/hnad", "*")])),
    Fault("lets nothing collide", lambda: ik.collisions(both(), exclude=[("*", "*")])),
    # Solving and following.
    Fault("solves by another law", lambda: ik.solve(struck(), Q, V, law=ik.Law())),
    Fault("solves without a velocity", lambda: ik.solve(struck(), Q)),
    Fault("solves with two arguments too many", lambda: ik.solve(struck(), Q, V, 1, 2)),
    Fault("solves with dq", lambda: ik.solve(struck(), Q, dq=V)),
    Fault("solves a batch with a misspelt friction", lambda: ik.solve_batch(resting(), ball().neutral(), frction=0.2)),
    Fault("follows a motion by dt", lambda: ik.simulate(struck(), Q, V, dt=0.1)),
    Fault("follows a motion for a misspelt duration", lambda: ik.simulate(struck(), Q, V, duratoin=1.0)),
    Fault("follows a motion for a second in words", lambda: ik.simulate(struck(), Q, V, duration="1s")),
    Fault("follows a motion by Euler", lambda: ik.simulate(struck(), Q, V, 0.1, method="euler")),
    Fault("follows a motion in high precision", lambda: ik.simulate(struck(), Q, V, 0.1, accuracy="hgh")),
    Fault("follows many motions for a misspelt duration", lambda: ik.simulate_batch(struck(), [Q], [V], durtion=0.1)),
    Fault("steps a simulation by a setting that is none", lambda: ik.Simulation(struck(), Q, V, rtl=1e-6)),
    Fault("steps a simulation by words", lambda: _sim().step("1ms")),
    Fault("steps a simulation back", lambda: _sim().run_until(-1.0)),
    Fault("steps a simulation by nothing", lambda: _sim().step()),
    Fault("sets all torques at once as an attribute", _assigned),
    Fault("sets torques by a list", lambda: _sim().controls.update([1, 2])),
    Fault("sets a torque of a misspelt joint", lambda: _sim().controls.update(elbwo=1.0)),
    Fault("sets three torques for two joints", lambda: _sim().control([1, 2, 3])),
    Fault("sets torques that are no numbers", lambda: _sim().control(["a", "b"])),
    Fault("sets a torque that is NaN", lambda: _sim().control([float("nan"), 0.0])),
    Fault("restores a simulation from a motion", lambda: _sim().restore(_motion())),
    # What comes of it.
    Fault("asks a motion for the impacts of a contact", lambda: _motion().impacts["floor"]),
    Fault("asks a motion for a misspelt contact", lambda: _motion().contacts["flor"]),
    Fault("asks a motion for the joints by number", lambda: _motion().joints[0]),
    Fault("asks an impact for a misspelt contact", lambda: _landing().contacts["flor"]),
    Fault("asks an impact for a reaction of a misspelt joint", lambda: _impact().reactions["elbwo"]),
    Fault("asks an impact for a velocity by att=", lambda: _impact().velocity_at("hand", att=[0, 0, 0])),
    Fault("asks an impact whether it holds to a word", lambda: _impact().is_valid("tight")),
    Fault("asks for derivatives by a misspelt name", lambda: ik.derivatives(_impact())["v_afer", "q"]),
    Fault("checks to a number of misspelt digits", lambda: check(_impact(), digit=30)),
    Fault("checks nothing", lambda: check()),
    Fault("reports as a PDF", lambda: ik.report(_impact(), form="pdf")),
    Fault("reports a point by a number", lambda: ik.report(_impact(), points=[3])),
    Fault("reports a scene", lambda: ik.report(struck())),
    Fault("looks for what touches in an impact", lambda: ik.touching(_impact(), Q)),
    Fault("draws into a word", lambda: ik.plots.energy_history(_motion(), ax="x")),
    Fault("draws an impact into a number", lambda: ik.plots.velocity_jump(_impact(), ax=3)),
    Fault("replays into a PDF", lambda: ik.replay(_motion(), "motion.pdf")),
    Fault("replays into a misspelt video", lambda: ik.replay(_motion(), vidoe="a.mp4")),
    Fault("replays a film as AVI", lambda: ik.replay(_motion(), video="a.avi")),
    Fault("saves a motion as CSV", lambda: _motion().save("motion.csv")),
    Fault("saves a scene as JSON", lambda: ik.save_scene("scene.json", struck())),
    Fault("saves a scene without a scene", lambda: ik.save_scene("scene.toml")),
    # Further modules.
    Fault("asks for the effective mass along a word", lambda: design.effective_mass(arm(), Q, "hand", "up")),
    Fault("asks for the effective mass of a misspelt frame", lambda: design.effective_mass(arm(), Q, "hnad", [0, 0, 1])),
    Fault("asks for the least blow of a scene", lambda: design.least_blow(struck())),
    Fault("asks for forces over time by a number", lambda: ik.force_history(_landing(), 1e5)),
    Fault("gives Hertz a misspelt modulus", lambda: ik.Hertz(e=1e7, nu=0.5, radius=0.1)),
    Fault("gives a gear's stiffness as a number", lambda: compliance.gear_peaks(_impact(), 1e4)),
    Fault("strikes a body that has no name", lambda: ik.transient_contact(arm(), Q, [1.0, 0.0], body="tail")),
    Fault("identifies a motion", lambda: measured.identify(_motion())),
    Fault("finds impacts in nothing", lambda: measured.find_impacts(None)),
    Fault("makes a study of a name", lambda: study.Study("landing")),
    Fault("varies a misspelt distribution", lambda: study.Variation("velocity", "unifrm", 0, 1)),
    Fault("opens a study that is a number", lambda: study.open_study(3)),
    Fault("makes a chain of half a link", lambda: models.chain_urdf(2.5)),
    Fault("makes a chain of links=", lambda: models.pendulum_urdf(lnks=2)),
    Fault("makes a long chain of words", lambda: long.long_chain("ten")),
    Fault("asks for the rotors of an unknown robot", lambda: models.rotor_inertias("pandda")),
    Fault("loads a scene from a number", lambda: ik.load_scene(5)),
)  # fmt: skip
