"""Every entry of the vocabulary in a small scene, with what it has to do there.

What holds or touches is told by its own gap as a function of q, written with placements alone: its
rows are differences of that, and the truth is M Δv = f + Jᵀ λ with J v⁺ given.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pinocchio as pin

import impulsekit as ik

ARM = ik.Robot.from_urdf(ik.models.pendulum_urdf(3))
BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
MASS, RADIUS, INERTIA = 0.5, 0.05, 0.0005
ON_FLOOR = ik.combine(ball=BALL, floor=ik.Robot.from_urdf("models/floor.urdf"))
TIP = (0.0, 0.0, -1.0)
Q_ARM, V_ARM = np.array([0.4, -0.7, 0.5]), np.array([1.0, -2.0, 0.7])


@dataclass(frozen=True, eq=False)
class Entry:
    """A scene with an entry.

    Attributes:
        gap: function of q that gives the rows which it holds or keeps apart; with ``ends``, the
            velocities of these after over before, or with ``aim`` those after themselves.
        expected: v⁺ in closed form, where there are no such rows.
        plain: whether ``derivatives`` takes it. text: whether a scene file does.
        near: the same where it touches at all states about this one.
    """

    scene: ik.Scene
    q: np.ndarray
    v: np.ndarray
    gap: Callable[[np.ndarray], np.ndarray] | None = None
    ends: float = 0.0
    aim: np.ndarray | None = None
    expected: np.ndarray | None = None
    plain: bool = True
    text: bool = True
    near: ik.Scene | None = None


def at(robot, q, frame, point=(0.0, 0.0, 0.0)):
    """(3,) where a point of a frame is."""
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[robot.frame_id(frame)].act(np.array(point, dtype=float))


def turned(robot, q, start, frame):
    """(3,) how far a frame is turned from where it was, in world axes."""
    model, data, was = robot.model, robot.model.createData(), robot.model.createData()
    pin.framesForwardKinematics(model, data, q)
    pin.framesForwardKinematics(model, was, start)
    i = robot.frame_id(frame)
    return pin.log3(data.oMf[i].rotation @ was.oMf[i].rotation.T)


def slopes(model, function, q):
    """(rows, nv) of a function of q, by differences of order 6."""
    h, rows = 3e-3, []
    for way in np.eye(model.nv):
        up = [np.atleast_1d(function(pin.integrate(model, q, k * h * way))) for k in (1, 2, 3)]
        down = [np.atleast_1d(function(pin.integrate(model, q, -k * h * way))) for k in (1, 2, 3)]
        first, second, third = (a - b for a, b in zip(up, down, strict=True))
        rows.append((45.0 * first - 9.0 * second + third) / (60.0 * h))
    return np.array(rows).T


def true_after(entry):
    """(nv,) v⁺ from M, the blows and the differences of the gap."""
    if entry.expected is not None:
        return entry.expected
    model = entry.scene.robot.model
    M = np.array(pin.crba(model, model.createData(), entry.q))
    M = np.triu(M) + np.triu(M, 1).T
    free = entry.v + np.linalg.solve(M, _blows(entry.scene, entry.q))
    if entry.gap is None:
        return free
    J = slopes(model, entry.gap, entry.q)
    aim = entry.ends * (J @ entry.v) if entry.aim is None else entry.aim
    half = np.linalg.solve(M, J.T)
    return free + half @ np.linalg.pinv(J @ half, rcond=1e-9) @ (aim - J @ free)


def _blows(scene, q):
    """(nv,) by virtual work: differences of what each impulse acts along."""
    robot, total = scene.robot, np.zeros(scene.robot.nv)
    for blow in scene.impulses:
        if isinstance(blow, ik.JointImpulse):
            total[robot.model.joints[robot.joint_id(blow.joint)].idx_v] += blow.impulse[0]
            continue
        turn = np.eye(3)
        if blow.axes == "local":
            data = robot.model.createData()
            pin.framesForwardKinematics(robot.model, data, q)
            turn = data.oMf[robot.frame_id(blow.frame)].rotation
        force, couple = turn @ np.array(blow.linear), turn @ np.array(blow.angular)

        def work(p, blow=blow, force=force, couple=couple):
            turn = turned(robot, p, q, blow.frame)
            return force @ at(robot, p, blow.frame, blow.at) + couple @ turn

        total += slopes(robot.model, work, q)[0]
    return total


def tip_along(q, *ways):
    """Rows of where the arm's tip is."""
    return np.array([np.array(way, dtype=float) @ at(ARM, q, "link_3", TIP) for way in ways])


def tip_distance(q):
    return np.array([np.linalg.norm(at(ARM, q, "link_3", TIP) - [1.0, 0.3, 0.0])])


def wire(q):
    return q[0] + math.sin(q[1])


def cam(q):
    return 0.3 * (math.sin(Q_ARM[2]) - math.sin(q[2])) + (q[1] - Q_ARM[1])


def swing(t):
    return Q_ARM[0] + 0.2 * math.sin(5.0 * t)


def half_of(speed):
    return 0.5 if speed < 100.0 else 0.0


def _arm(gap=None, ends=0.0, aim=None, *, v=V_ARM, text=True, plain=True, near=None, **entries):
    scene, near = ik.Scene(ARM, **entries), near and ik.Scene(ARM, contacts=near)
    return Entry(scene, Q_ARM, v, gap, ends, aim, text=text, plain=plain, near=near)


BOTH = ik.combine(arm=ARM, ball=BALL)
HAND, EAR = (0.1, 0.05, -1.0), (0.03, -0.02, 0.04)


def between(*ways):
    """Where the arm's hand is from a point of the ball, along some directions."""

    def gap(q):
        apart = at(BOTH, q, "arm/link_3", HAND) - at(BOTH, q, "ball/ball", EAR)
        return np.array([apart @ np.array(way, dtype=float) for way in ways])

    return gap


def length_between(q):
    return np.array([np.linalg.norm(between(*np.eye(3))(q))])


def hinged(q):
    """How far the ball is turned in the hand about the hand's x and y, from where it was."""
    turns = []
    for state in (q, Q_BOTH):
        data = BOTH.model.createData()
        pin.framesForwardKinematics(BOTH.model, data, state)
        hand, ball = (data.oMf[BOTH.frame_id(f)].rotation for f in ("arm/link_3", "ball/ball"))
        turns.append(hand.T @ ball)
    return pin.log3(turns[0] @ turns[1].T)[:2]


HALF = np.array([0.3, -0.2, 0.1, 1.0]) / np.sqrt(1.14)
V_BOTH = np.array([1.0, -2.0, 0.7, 0.4, -0.3, 0.9, 2.0, 1.0, -3.0])


def _configuration():
    q = np.concatenate([Q_ARM, [0.5, 0.1, -2.0, *HALF]])
    # Where the two points are one.
    q[3:6] += between(*np.eye(3))(q)
    return q


Q_BOTH = _configuration()
Q_APART = np.add(Q_BOTH, [0.2, 0.1, 0, 0, 0.3, 0, 0, 0, 0, 0])


def _both(gap=None, ends=0.0, q=Q_BOTH, v=V_BOTH, near=None, **entries):
    """The arm and a ball in flight."""
    near = near and ik.Scene(BOTH, contacts=near)
    return Entry(ik.Scene(BOTH, **entries), q, v, gap, ends, near=near)


def _dropped(expected, contact=None, spin=(0.0, 0.0, 0.0), blows=(), fall=-2.0, slide=3.0, **more):
    """A ball that comes down on a plane, with v_x = 3 m/s."""
    flags = {name: more.pop(name) for name in ("plain", "text", "materials") if name in more}
    table = flags.pop("materials", ())
    given = {"at": (0, 0, -RADIUS), "name": "c", **more}
    contact = contact or ik.Contact("ball", **given)
    scene = ik.Scene(BALL, blows, contacts=[contact], materials=table)
    q = BALL.configuration(root_joint=[0, 0, RADIUS, 0, 0, 0, 1])
    v = BALL.velocity(root_joint=[slide, 0, fall, *spin])
    return Entry(scene, q, v, expected=np.array(expected, dtype=float), **flags)


def _slides(mu, e):
    """v⁺ of that ball where it slips all the way: P_n = m (1 + e) 2, P_t = −µ P_n."""
    normal = MASS * (1.0 + e) * 2.0
    return [3.0 - mu * normal / MASS, 0, 2.0 * e, 0, mu * normal * RADIUS / INERTIA, 0]


def _sticks(e, e_t=0.0):
    """v⁺ of that ball where it sticks, or its slip is turned back: u_t = v_x − R ω_y."""
    pull = -(1.0 + e_t) * 3.0 / (1.0 / MASS + RADIUS**2 / INERTIA)
    return [3.0 + pull / MASS, 0, 2.0 * e, 0, -pull * RADIUS / INERTIA, 0]


def _of_table(e):
    """As ``_slides`` with µ = 0.1 + 0.05 |u_t⁺|, u_t⁺ = 3 − µ (1 + e) 2 · 7/2."""
    most = 7.0 * (1.0 + e)
    return _slides(0.1 + 0.05 * (3.0 - 0.1 * most) / (1.0 + 0.05 * most), e)


def _floor(plain=True, pair=("ball/ball", "floor/floor"), **more):
    """The ball with a floor of geometry under it, rolling and turning as it falls."""
    q = ON_FLOOR.configuration(**{"ball/root_joint": [0, 0, RADIUS, 0, 0, 0, 1]})
    v = ON_FLOOR.velocity({"ball/root_joint": [1.0, 0, -2.0, 0, 0, 3.0]})
    collision = ik.Collision(*pair, restitution=0.5, **more)
    deep = ik.Scene(ON_FLOOR, contacts=[replace(collision, margin=0.01)])
    return Entry(
        ik.Scene(ON_FLOOR, contacts=[collision]), q, v,
        lambda p: np.array([at(ON_FLOOR, p, "ball/ball")[2]]), -0.5, plain=plain, near=deep,
    )  # fmt: skip


TABLE = [
    ik.Material("rubber", links=["ball"]),
    ik.Material("steel", links=["world"]),
    ik.MaterialPair("steel", "rubber", restitution=0.5, friction=0.1),
]
TIP_PLACE = at(ARM, Q_ARM, "link_3", TIP)
DOWN = [0.6, 0.0, 0.8]
STILL = np.zeros(3)


def _entries() -> dict[str, Entry]:
    (rope,) = tip_distance(Q_ARM)
    tip = {"at": TIP, "other_at": (1.0, 0.3, 0.0)}
    plane = {"at": TIP, "origin": TIP_PLACE, "normal": DOWN}
    blow = ik.AppliedImpulse("link_2", [1, 2, -1], [0.1, 0.3, 0], at=[0.1, 0, -0.5])
    (far,) = length_between(Q_APART)
    parting = V_BOTH if slopes(BOTH.model, length_between, Q_APART)[0] @ V_BOTH > 0 else -V_BOTH
    ball = BOTH.model.createData()
    pin.framesForwardKinematics(BOTH.model, ball, Q_BOTH)
    side = ball.oMf[BOTH.frame_id("ball/ball")].rotation @ DOWN
    outward = -V_ARM if np.dot(slopes(ARM.model, tip_distance, Q_ARM)[0], V_ARM) < 0 else V_ARM
    toward = (
        V_ARM if slopes(ARM.model, lambda q: tip_along(q, DOWN), Q_ARM)[0] @ V_ARM < 0 else -V_ARM
    )
    return {
        "AppliedImpulse": _arm(impulses=[blow]),
        "AppliedImpulse-local": _arm(
            impulses=[ik.AppliedImpulse("link_3", [1, 2, -1], [0.1, 0.3, 0], axes="local")]
        ),
        "JointImpulse": _arm(impulses=[ik.JointImpulse("joint_2", 0.7)]),
        "PointAnchor": _arm(
            lambda q: tip_along(q, *np.eye(3)),
            constraints=[ik.PointAnchor("link_3", at=TIP)],
        ),
        "PointAnchor-moving": _arm(
            lambda q: tip_along(q, *np.eye(3)),
            aim=np.array([0.3, 0.0, -0.2]),
            constraints=[ik.PointAnchor("link_3", at=TIP, velocity=[0.3, 0, -0.2])],
        ),
        "FrameAnchor": _arm(
            lambda q: np.array([*tip_along(q, [0, 0, 1]), turned(ARM, q, Q_ARM, "link_3")[1]]),
            constraints=[ik.FrameAnchor("link_3", at=TIP, directions=("z", "ry"))],
        ),
        "DistanceAnchor": _arm(
            tip_distance, constraints=[ik.DistanceAnchor("link_3", **tip)], impulses=[blow]
        ),
        "PointAnchor-between": _both(
            between(*np.eye(3)),
            constraints=[ik.PointAnchor("arm/link_3", "ball/ball", HAND, EAR)],
        ),
        "FrameAnchor-between": _both(
            lambda q: np.concatenate([between(*np.eye(3))(q), hinged(q)]),
            constraints=[
                ik.FrameAnchor("arm/link_3", "ball/ball", HAND, EAR,
                               directions=("x", "y", "z", "rx", "ry"), axes="local")
            ],
        ),
        "DistanceAnchor-between": _both(
            length_between, q=Q_APART,
            constraints=[ik.DistanceAnchor("arm/link_3", "ball/ball", HAND, EAR)],
        ),
        "JointLock": _arm(lambda q: q[[1]], constraints=[ik.JointLock("joint_2")]),
        "JointLock-kept": _arm(
            lambda q: q[[1]], 1.0, constraints=[ik.JointLock("joint_2", velocity="kept")],
            impulses=[blow],
        ),
        "JointCoupling": _arm(
            lambda q: q[[1]] + 0.5 * q[[0]] - 2.0 * q[[2]],
            constraints=[ik.JointCoupling("joint_2", ("joint_1", "joint_3"), ratio=(-0.5, 2.0))],
        ),
        "Driven": _arm(
            lambda q: q[[0]], aim=np.ones(1), constraints=[ik.Driven("joint_1", swing)],
            impulses=[blow], text=False,
        ),
        "GapConstraint": _arm(
            lambda q: np.array([wire(q)]), constraints=[ik.GapConstraint(wire)], text=False,
            plain=False,
        ),
        "controlled": _arm(lambda q: q[[1]], 1.0, controlled=["joint_2"], impulses=[blow]),
        "Contact": _arm(
            lambda q: tip_along(q, DOWN), -0.5, v=toward,
            contacts=[ik.Contact("link_3", restitution=0.5, **plane)],
        ),
        "JointStop": _arm(
            lambda q: q[[1]], -0.5,
            contacts=[ik.JointStop("joint_2", lower=Q_ARM[1], restitution=0.5)],
            near=[ik.JointStop("joint_2", lower=Q_ARM[1] + 0.01, restitution=0.5)],
        ),
        "Rope": _arm(
            tip_distance, -0.5, v=outward,
            contacts=[ik.Rope("link_3", length=rope, restitution=0.5, **tip)],
            near=[ik.Rope("link_3", length=rope - 0.01, restitution=0.5, **tip)],
        ),
        "Rope-between": _both(
            length_between, -0.5, q=Q_APART, v=parting,
            contacts=[ik.Rope("arm/link_3", "ball/ball", HAND, EAR, far, restitution=0.5)],
            near=[ik.Rope("arm/link_3", "ball/ball", HAND, EAR, far - 0.01, restitution=0.5)],
        ),
        "Contact-between": _both(
            between(side), -0.5,
            v=V_BOTH if slopes(BOTH.model, between(side), Q_BOTH)[0] @ V_BOTH < 0 else -V_BOTH,
            contacts=[
                ik.Contact("arm/link_3", HAND, DOWN, EAR, "ball/ball", restitution=0.5)
            ],
        ),
        "GapContact": _arm(
            lambda q: np.array([cam(q)]), -0.5, contacts=[ik.GapContact(cam, restitution=0.5)],
            text=False, plain=False,
        ),
        "Collision": _floor(),
        "Collision-by-the-floor": _floor(pair=("floor/floor", "ball/ball")),
        "Collision-turning": _floor(plain=False, rolling=0.001),
        "friction-slides": _dropped(_slides(0.1, 0.5), restitution=0.5, friction=0.1),
        "friction-sticks": _dropped(_sticks(0.5), restitution=0.5, friction=0.9),
        "Restitution": _dropped(
            _slides(0.1, 0.5), restitution=ik.Restitution(0.5, capture_speed=0.1), friction=0.1
        ),
        "Restitution-captures": _dropped(
            _slides(0.1, 0.0), restitution=ik.Restitution(0.5, capture_speed=2.5), friction=0.1
        ),
        "RestitutionTable": _dropped(
            _slides(0.1, 0.6), restitution=ik.RestitutionTable([0, 5], [0.8, 0.3]), friction=0.1
        ),
        "restitution-function": _dropped(
            _slides(0.1, 0.5), restitution=half_of, friction=0.1, text=False
        ),
        "StaticKinetic": _dropped(
            _slides(0.1, 0.5), restitution=0.5, friction=ik.StaticKinetic(0.2, 0.1), plain=False
        ),
        "FrictionTable": _dropped(
            _of_table(0.5), restitution=0.5, friction=ik.FrictionTable([0, 4], [0.1, 0.3]),
            plain=False,
        ),
        "EllipticFriction": _dropped(
            _slides(0.1, 0.5), restitution=0.5, friction=ik.EllipticFriction(0.1, 0.4), plain=False
        ),
        "tangential_restitution": _dropped(
            _sticks(0.5, 0.6), restitution=0.5, friction=2.0, tangential_restitution=0.6
        ),
        "torsion": _dropped(
            [3, 0, 1, 0, 0, 40 - 0.003 * 1.5 / INERTIA], spin=(0, 0, 40), restitution=0.5,
            torsion=0.003, plain=False,
        ),
        "rolling": _dropped(
            [3, 0, 1, 0, 40 - 0.003 * 1.5 / INERTIA, 0], spin=(0, 40, 0), restitution=0.5,
            rolling=0.003, plain=False,
        ),
        "adhesion": _dropped(
            [3, 0, (1.0 - 0.6) / MASS, 0, 0, 0], fall=0.0, adhesion=0.6, holding_force=9.0,
            plain=False, blows=[ik.AppliedImpulse("ball", linear=[0, 0, 1.0])],
        ),
        "Material": _dropped(
            _slides(0.1, 0.5), materials=TABLE, restitution="material", friction="material"
        ),
    }  # fmt: skip


ENTRIES = _entries()


@dataclass(frozen=True, eq=False)
class Pushed:
    """A force in a scene, and where it brings the robot in ``duration``."""

    scene: ik.Scene
    q: np.ndarray
    v: np.ndarray
    duration: float
    expected: Callable[[float], tuple[float, float]]
    text: bool = True


@cache
def wheel() -> ik.Robot:
    """A rod that turns about its middle, of 1/12 kg m²."""
    text = ik.models.pendulum_urdf(1).replace('origin xyz="0 0 -0.5"', 'origin xyz="0 0 0"')
    return ik.Robot.from_urdf(text)


J = 1.0 / 12.0


def torque(t, q, v):
    return 0.3 * t


def pull(t):
    return (0.3 * t, 0.0, 0.0)


def _wheel(force, expected, q=0.0, v=0.0, text=True):
    scene = ik.Scene(wheel(), forces=[force], gravity=(0, 0, 0))
    return Pushed(scene, np.array([q]), np.array([v]), 0.5, expected, text)


def _ball(force, expected, x=0.0, speed=0.0, text=True):
    scene = ik.Scene(BALL, forces=[force], gravity=(0, 0, 0))
    q = BALL.configuration(root_joint=[x, 0, 0, 0, 0, 0, 1])
    v = BALL.velocity(root_joint=[speed, 0, 0, 0, 0, 0])
    return Pushed(scene, q, v, 0.5, expected, text)


def _swings(t, size, rate, damped=0.0):
    """x and dx/dt of x'' + 2 damped x' + rate² x = 0 from x = size at rest."""
    w = math.sqrt(rate**2 - damped**2)
    decay, c, s = math.exp(-damped * t), math.cos(w * t), math.sin(w * t)
    return size * decay * (c + damped / w * s), -size * decay * rate**2 / w * s


FORCES: dict[str, Pushed] = {
    "JointSpring": _wheel(
        ik.JointSpring("joint_1", stiffness=4.0, damping=0.1, rest=0.2),
        lambda t: np.add((0.2, 0), _swings(t, 0.3, math.sqrt(4.0 / J), 0.05 / J)), q=0.5,
    ),
    "JointSpring-above": _wheel(
        ik.JointSpring("joint_1", stiffness=4.0, rest=0.5, acts="above"),
        lambda t: (0.2 + 0.5 * t, 0.5), q=0.2, v=0.5,
    ),
    "JointFriction": _wheel(
        ik.JointFriction("joint_1", 0.01), lambda t: (t - 0.06 * t * t, 1.0 - 0.12 * t), v=1.0
    ),
    "Spring": _ball(
        ik.Spring("ball", stiffness=8.0, damping=0.4),
        lambda t: _swings(t, 0.7, 4.0, 0.4), x=0.7,
    ),
    "Actuator": _wheel(ik.Actuator("joint_1", 0.3), lambda t: (0.15 * t * t / J, 0.3 * t / J)),
    "Actuator-function": _wheel(
        ik.Actuator("joint_1", torque), lambda t: (0.05 * t**3 / J, 0.15 * t * t / J), text=False
    ),
    "PD": _wheel(
        ik.Actuator("joint_1", ik.PD(stiffness=4.0, damping=0.1, target=0.2, velocity=0.4)),
        lambda t: np.add((0.21, 0), _swings(t, -0.21, math.sqrt(4.0 / J), 0.05 / J)),
    ),
    "TorqueTable": _wheel(
        ik.Actuator("joint_1", ik.TorqueTable([0.0, 1.0], [0.0, 0.3])),
        lambda t: (0.05 * t**3 / J, 0.15 * t * t / J),
    ),
    "AppliedForce": _ball(
        ik.AppliedForce("ball", [0.3, 0, 0]), lambda t: (0.3 * t * t, 0.6 * t), speed=0.0
    ),
    "AppliedForce-function": _ball(
        ik.AppliedForce("ball", pull), lambda t: (0.1 * t**3, 0.3 * t * t), text=False
    ),
}  # fmt: skip
