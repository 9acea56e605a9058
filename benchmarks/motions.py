"""Motions with contact beside MuJoCo's steps of 1 ms: processor time, one run after the other."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin

from impulsekit.batch.motions.simulate import simulate_batch
from impulsekit.motion import simulate
from impulsekit.motion.simulation import Simulation
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import AppliedForce, Collision, Contact, JointSpring, Scene

from .urdf import one_body, solid_box

# As published: side [m], restitution and friction (tilt test).
WIDTH, RESTITUTION, FRICTION = 0.1048, 0.125, 0.18
MASS, INERTIA = 0.37, 0.00081


def cube_scene() -> Scene:
    """The cube of the tosses with its eight corners over a table."""
    robot = one_body("cube", MASS, INERTIA)
    half = 0.5 * WIDTH
    signs = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    contacts = [
        Contact("cube", at=[half * a, half * b, half * c], restitution=RESTITUTION,
                friction=FRICTION, name=f"corner_{i}")
        for i, (a, b, c) in enumerate(signs)
    ]  # fmt: skip
    return Scene(robot, contacts=contacts, gravity=[0, 0, -9.81])


GRAVITY = (0.0, 0.0, -9.81)
# Of MuJoCo [s].
STEP = 1e-3
# How often times are measured, and how many tosses are one measurement.
ROUNDS, TOSSES = 3, 12
# Steps of a control loop that are one measurement.
CONTROLS = 200
PLANE = '<geom type="plane" size="0 0 1" friction="{mu} .005 .0001"/>'
BOX = (
    '<body pos="{x} 0 {z}"><freejoint/><geom type="box" size="{a} {b} {c}" mass="{mass}"'
    ' friction="{mu} .005 .0001"/></body>'
)
FLOOR = """<robot name="floor"><link name="floor"><collision><origin xyz="0 0 -0.1"/><geometry>
<box size="2 2 0.2"/></geometry></collision></link></robot>"""


def _world(mu: float, bodies: str) -> str:
    return f"<mujoco><worldbody>{PLANE.format(mu=mu)}{bodies}</worldbody></mujoco>"


def _ratios(
    ours: Callable[[], object],
    world: str,
    starts: list[tuple[np.ndarray, np.ndarray]],
    duration: float,
    push: Callable[[float], float] | None = None,
) -> list[float]:
    """Our processor time over MuJoCo's, of some rounds; none where MuJoCo is not installed.

    Args:
        starts: qpos and qvel of MuJoCo's motions. push: force [N] along x on its first body.
    """
    if importlib.util.find_spec("mujoco") is None:
        return []
    import mujoco

    model = mujoco.MjModel.from_xml_string(world)
    model.opt.timestep = STEP
    data, steps = mujoco.MjData(model), round(duration / STEP)

    def theirs() -> None:
        for qpos, qvel in starts:
            mujoco.mj_resetData(model, data)
            data.qpos, data.qvel = qpos, qvel
            if push is None:
                mujoco.mj_step(model, data, steps)
                continue
            for k in range(steps):
                data.xfrc_applied[1, 0] = push(k * STEP)
                mujoco.mj_step(model, data)

    ours()
    return [_processor(ours) / _processor(theirs) for _ in range(ROUNDS)]


def _processor(job: Callable[[], object]) -> float:
    begin = time.process_time()
    job()
    return time.process_time() - begin


def thrown(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """q and v of cubes thrown like those that were recorded."""
    rng, states = np.random.default_rng(0), []
    for _ in range(count):
        turn = rng.normal(size=4)
        q = np.array([0.0, 0.0, 0.2, *(turn / np.linalg.norm(turn))])
        rotation = pin.Quaternion(*q[[6, 3, 4, 5]]).matrix()
        linear, angular = rng.normal(size=3) * [1.0, 1.0, 0.5], rng.normal(size=3) * 5.0
        states.append((q, np.concatenate([rotation.T.dot(linear), angular])))
    return states


def _start(q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """MuJoCo's qpos and qvel of a free body: w first, the linear velocity in world axes."""
    rotation = pin.Quaternion(*q[[6, 3, 4, 5]]).matrix()
    return q[[0, 1, 2, 6, 3, 4, 5]], np.concatenate([rotation.dot(v[:3]), v[3:]])


def tosses() -> list[float]:
    """Tosses of the recorded cube, thrown like those."""
    scene, states = cube_scene(), thrown(TOSSES)
    starts = [_start(q, v) for q, v in states]
    half = 0.5 * WIDTH
    body = BOX.format(x=0, z=half, a=half, b=half, c=half, mass=0.37, mu=FRICTION)

    def ours() -> None:
        for q, v in states:
            simulate(scene, q, v, 0.7)

    return _ratios(ours, _world(FRICTION, body), starts, 0.7)


def _on_its_sole(mu: float, force: AppliedForce) -> tuple[Scene, np.ndarray, np.ndarray]:
    block = solid_box("box", 1.0, (0.2, 0.2, 0.2))
    corners = [
        Contact("box", at=[x, y, -0.1], friction=mu) for x in (-0.1, 0.1) for y in (-0.1, 0.1)
    ]
    scene = Scene(block, contacts=corners, forces=[force], gravity=GRAVITY)
    return scene, block.configuration(root_joint=[0, 0, 0.1, 0, 0, 0, 1]), block.velocity()


def drawn_box() -> list[float]:
    """A box drawn to and fro over the floor for 2 s."""

    def push(t: float) -> float:
        return float(8.0 * np.cos(t))

    force = AppliedForce("box", linear=lambda t: (push(t), 0.0, 0.0))
    scene, q, v = _on_its_sole(0.3, force)
    body = BOX.format(x=0, z=0.1, a=0.1, b=0.1, c=0.1, mass=1, mu=0.3)
    start = np.array([0, 0, 0.1, 1, 0, 0, 0]), np.zeros(6)
    return _ratios(lambda: simulate(scene, q, v, 2.0), _world(0.3, body), [start], 2.0, push)


def shaken_block() -> list[float]:
    """Seconds for 8.1 s of a block that a force at its sole rocks and does not move."""
    force = AppliedForce(
        "box", linear=lambda t: (8.0 * float(np.cos(t)), 0.0, 0.0), at=[0, 0, -0.1]
    )
    scene, q, v = _on_its_sole(0.8, force)
    simulate(scene, q, v, 0.1)
    return [_processor(lambda: simulate(scene, q, v, 8.1)) for _ in range(ROUNDS)]


# Of a domino: sides [m], mass [kg], and the distance from one to the next [m].
DOMINO, DOMINO_MASS, APART = (0.012, 0.025, 0.05), 0.01, 0.03


def domino_row() -> tuple[Scene, np.ndarray, np.ndarray]:
    """Five dominoes, of which the first is pushed over."""
    names = [f"d{i}" for i in range(5)]
    one, floor = solid_box("box", DOMINO_MASS, DOMINO), Robot.from_urdf(FLOOR)
    row = combine(d0=one, d1=one, d2=one, d3=one, d4=one, floor=floor)
    contacts = [Collision(f"{name}/box", "floor/floor", friction=0.4) for name in names]
    contacts += [
        Collision(f"{left}/box", f"{right}/box", friction=0.3, restitution=0.1)
        for left, right in pairwise(names)
    ]
    scene = Scene(row, contacts=contacts, gravity=GRAVITY)
    high = DOMINO[2] / 2
    places = {f"{n}/root_joint": [APART * i, 0, high, 0, 0, 0, 1] for i, n in enumerate(names)}
    v = row.velocity(**{"d0/root_joint": [0.25, 0, 0, 0, 5.0, 0]})
    return scene, row.configuration(**places), v


def dominoes() -> list[float]:
    """Five dominoes, of which the first is pushed over, for 0.3 s."""
    scene, q, v = domino_row()
    (a, b, c), mass, apart = DOMINO, DOMINO_MASS, APART
    bodies = "".join(
        BOX.format(x=apart * i, z=c / 2, a=a / 2, b=b / 2, c=c / 2, mass=mass, mu=0.4)
        for i in range(5)
    )
    poses = np.array([[apart * i, 0, c / 2, 1, 0, 0, 0] for i in range(5)], dtype=float).ravel()
    speeds = np.zeros(30)
    speeds[:6] = [0.25, 0, 0, 0, 5.0, 0]
    world = _world(0.4, bodies)
    return _ratios(lambda: simulate(scene, q, v, 0.3), world, [(poses, speeds)], 0.3)


def ten_boxes() -> list[float]:
    """Ten boxes on top of each other, each let go of 1 mm above the one below, for 1 s."""
    a, b, c, mass, fall, count = 0.3, 0.2, 0.1, 1.0, 1e-3, 10
    names = [f"b{i}" for i in range(count)]
    one, floor = solid_box("box", mass, (a, b, c)), Robot.from_urdf(FLOOR)
    parts: dict[str, Any] = {"floor": floor} | dict.fromkeys(names, one)
    pile = combine(**parts)
    pairs = pairwise(("floor/floor", *(f"{name}/box" for name in names)))
    contacts = [Collision(upper, lower, friction=0.5) for lower, upper in pairs]
    scene = Scene(pile, contacts=contacts, gravity=GRAVITY)
    heights = [0.5 * c + i * c + (i + 1) * fall for i in range(count)]
    places = {
        f"{name}/root_joint": [0, 0, z, 0, 0, 0, 1] for name, z in zip(names, heights, strict=True)
    }
    q, v = pile.configuration(**places), pile.velocity()
    bodies = "".join(
        BOX.format(x=0, z=z, a=a / 2, b=b / 2, c=c / 2, mass=mass, mu=0.5) for z in heights
    )
    poses = np.array([[0, 0, z, 1, 0, 0, 0] for z in heights], dtype=float).ravel()
    start = poses, np.zeros(6 * count)
    return _ratios(lambda: simulate(scene, q, v, 1.0), _world(0.5, bodies), [start], 1.0)


def rolling() -> list[float]:
    """A thrown box with rolling friction at its corners over one without."""
    states = thrown(TOSSES)
    box, table = solid_box("box", MASS, (WIDTH, WIDTH, WIDTH)).with_ground(), {}
    for resists in (0.0, 1e-3):
        touch = Collision("box", "ground", friction=FRICTION, rolling=resists)
        table[resists] = Scene(box, contacts=[touch], gravity=GRAVITY)

    def ours(resists: float) -> None:
        for q, v in states:
            simulate(table[resists], q, v, 0.7)

    return [_processor(lambda: ours(1e-3)) / _processor(lambda: ours(0.0)) for _ in range(ROUNDS)]


def threads() -> list[float]:
    """A batch of tosses on one thread over the same on two, in time on the clock."""
    scene, states = cube_scene(), thrown(100)
    q, v = (np.array(x) for x in zip(*states, strict=True))

    def seconds(count: int) -> float:
        begin = time.perf_counter()
        simulate_batch(scene, q, v, 0.7, samples=2, threads=count)
        return time.perf_counter() - begin

    return [seconds(1) / seconds(2) for _ in range(ROUNDS)]


def _standing() -> tuple[Scene, np.ndarray]:
    """Solo12 on its four feet."""
    solo = Robot.from_example("solo12", root="freeflyer")
    legs = ("FL", "FR", "HL", "HR")
    feet = [Contact(f"{leg}_FOOT", friction=0.6) for leg in legs]
    bend = {f"{leg}_HFE": 0.8 for leg in legs} | {f"{leg}_KFE": -1.6 for leg in legs}
    q = solo.configuration(root_joint=[0, 0, 0, 0, 0, 0, 1], **bend)
    q[2] -= min(solo.placement(q, foot.frame).position[2] for foot in feet)
    return Scene(solo, contacts=feet), q


def stepped() -> list[float]:
    """Steps of 1 ms of Solo12 standing, by ``Simulation`` over one ``simulate`` of the whole."""
    scene, q = _standing()
    solo = scene.robot
    holds = [
        JointSpring(joint, 50.0, 1.0, rest=q[solo.model.joints[solo.joint_id(joint)].idx_q])
        for joint in solo.joint_names[1:]
    ]
    scene, v = scene.replace(forces=holds), solo.velocity()

    def by_steps() -> None:
        sim = Simulation(scene, q, v)
        for _ in range(1000):
            sim.step(STEP)

    return [
        _processor(by_steps) / _processor(lambda: simulate(scene, q, v, 1.0)) for _ in range(ROUNDS)
    ]


def controlled() -> list[float]:
    """A PD loop at 1 kHz that holds Solo12 on its feet, over the same with MuJoCo's steps."""
    if importlib.util.find_spec("mujoco") is None:
        return []
    import mujoco

    from .landing_rank import CROUCHED, solo12

    scene, q = _standing()
    sim = Simulation(scene, q, scene.robot.velocity(), record=False)
    model = solo12()
    model.opt.timestep = STEP
    data, torques = mujoco.MjData(model), np.zeros(scene.robot.nv)
    data.qpos[2], data.qpos[7:] = q[2], CROUCHED

    def ours() -> None:
        for _ in range(CONTROLS):
            torques[6:] = 20.0 * (q[7:] - sim.q[7:]) - 0.5 * sim.v[6:]
            sim.control(torques).step(STEP)

    def theirs() -> None:
        for _ in range(CONTROLS):
            data.qfrc_applied[6:] = 20.0 * (CROUCHED - data.qpos[7:]) - 0.5 * data.qvel[6:]
            mujoco.mj_step(model, data)

    ours()
    theirs()
    return [_processor(ours) / _processor(theirs) for _ in range(5 * ROUNDS)]
