"""Balls that collide, in batches: their points are found in the kernels."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from tests.batch.compare import worst_difference

pytest.importorskip("numba")

RADIUS = 0.05
SHAPES = {
    "box": '<box size="0.4 0.6 0.2"/>',
    "cylinder": '<cylinder radius="0.2" length="0.5"/>',
    "sphere": '<sphere radius="0.3"/>',
}


def body(shape):
    """A floating body whose one shape stands off its frame, and turned."""
    return ik.Robot.from_urdf(
        f"""<robot name="body"><link name="body">
        <inertial><mass value="2"/><origin xyz="0.1 0 0.05"/>
          <inertia ixx="0.03" iyy="0.04" izz="0.05" ixy="0.001" ixz="0" iyz="0"/></inertial>
        <collision><origin xyz="0.05 -0.1 0.2" rpy="0.3 -0.5 1.1"/>
          <geometry>{SHAPES[shape]}</geometry></collision></link></robot>""",
        root="freeflyer",
    )


def meetings(robot, shape, count, seed=0, gaps=(0.0, -1e-7, -1e-4, 3e-3)):
    """States in which the ball, robot "ball", stands at such gaps from the shape of "body"."""
    rng = np.random.default_rng(seed)
    model, data = robot.model, robot.model.createData()
    geometry = robot.collision_model
    ball, other = (
        geometry.geometryObjects[
            next(i for i, g in enumerate(geometry.geometryObjects) if g.name.startswith(name))
        ]
        for name in ("ball/", "body/")
    )
    q = np.empty((count, robot.nq))
    for i in range(count):
        q[i] = pin.integrate(model, robot.neutral(), rng.uniform(-1, 1, robot.nv))
        pin.forwardKinematics(model, data, q[i])
        placement = data.oMi[other.parentJoint] * other.placement
        core, normal, around = surface(shape, rng)
        away = around + RADIUS + gaps[i % len(gaps)]
        centre = placement.act(core + away * normal)
        at = model.joints[ball.parentJoint].idx_q
        q[i, at : at + 3] = centre
    return q, rng.normal(size=(count, robot.nv))


def surface(shape, rng):
    """A point of a shape's core, the direction away from it there, and the radius around."""
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    if shape == "sphere":
        return np.zeros(3), normal, 0.3
    if shape == "box":
        half = np.array([0.2, 0.3, 0.1])
        point = rng.uniform(-1, 1, 3) * half
        chosen = rng.permutation(3)[: rng.integers(1, 4)]
        point[chosen] = np.sign(normal[chosen]) * half[chosen]
        normal[np.setdiff1d(range(3), chosen)] = 0.0
        return point, normal / np.linalg.norm(normal), 0.0
    on_rim = rng.random() < 0.5
    round_way = normal[:2] / np.linalg.norm(normal[:2])
    height = rng.uniform(-0.25, 0.25)
    if not on_rim:
        return np.r_[0.2 * round_way, height], np.r_[round_way, 0.0], 0.0
    end = np.sign(height)
    across = np.r_[round_way * rng.uniform(0, 1), end]
    return np.r_[0.2 * round_way, end * 0.25], across / np.linalg.norm(across), 0.0


@pytest.fixture(scope="module")
def robots():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    return {shape: ik.combine(ball=ball, body=body(shape)) for shape in SHAPES}


@pytest.mark.slow
@pytest.mark.parametrize("ball_first", [True, False])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_ball_and_a_shape_that_float(robots, shape, ball_first):
    names = ("ball/ball", "body/body")[:: 1 if ball_first else -1]
    collision = ik.Collision(*names, restitution=0.6, friction=0.4)
    scene = ik.Scene(robots[shape], contacts=[collision])
    q, v = meetings(robots[shape], shape, 60)
    worst, batch = worst_difference(scene, q, v)
    assert worst < 1e-12
    # Those 3 mm apart do not touch.
    apart = np.arange(60) % 4 == 3
    assert (batch.contact_impulses[apart] == 0.0).all()
    assert (np.abs(batch.contact_impulses[~apart]).sum(axis=(1, 2)) > 0.0).any()


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [ik.Law("poisson"), ik.Law(order="sequential"), ik.Law("stronge", "path", "sequential")],
    ids=str,
)
def test_two_balls_on_a_floor(law):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    floor = ik.Robot.from_urdf("models/floor.urdf")
    robot = ik.combine(a=ball, b=ball, floor=floor)
    contacts = [
        ik.Collision("a/ball", "floor/floor", restitution=0.7, friction=0.3),
        ik.Collision("floor/floor", "b/ball", restitution=0.5, friction=0.2),
        ik.Collision("a/ball", "b/ball", restitution=ik.RestitutionTable([0, 2], [0.9, 0.3])),
    ]
    scene = ik.Scene(robot, contacts=contacts, law=law)
    rng = np.random.default_rng(3)
    q = np.tile(robot.neutral(), (60, 1))
    angle = rng.uniform(0, 2 * np.pi, 60)
    q[:, 0:3] = np.c_[rng.uniform(-1, 1, (60, 2)), np.full(60, RADIUS)]
    q[:, 7:10] = q[:, 0:3] + 2 * RADIUS * np.c_[np.cos(angle), np.sin(angle), np.zeros(60)]
    q[::3, 9] += 0.01
    v = rng.normal(size=(60, robot.nv))
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


def test_a_ball_inside_a_box_is_left_to_the_single_path(robots):
    robot = robots["box"]
    scene = ik.Scene(robot, contacts=[ik.Collision("ball/ball", "body/body")])
    q, v = meetings(robot, "box", 8, gaps=(-1.5 * RADIUS,))
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-9
