"""The core's rows of every entry of a scene, beside Jacobians of Pinocchio's frames."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit._core import ball_shape
from impulsekit.geometry.axes import place_numbers
from impulsekit.impact.flat.scene import flat_scene

from ..robots import random_state

EXACT = 1e-13
AT, ELSEWHERE = (0.1, -0.2, 0.05), (-0.3, 0.1, 0.2)


@pytest.fixture(scope="module")
def robot():
    """Two dogs and a ball in one world."""
    dog = ik.Robot.from_example("solo12", root="freeflyer")
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    return ik.combine(dog=dog, arm=ik.Robot.from_example("panda"), ball=ball)


class Bodies:
    """Points of frames and their velocities at a state, by Pinocchio."""

    def __init__(self, robot, q):
        self.model, self.data = robot.model, robot.model.createData()
        pin.computeJointJacobians(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        self.robot = robot

    def place(self, frame, at=(0, 0, 0)):
        return self.data.oMf[self.robot.frame_id(frame)].act(np.array(at, dtype=float))

    def axes(self, frame):
        return self.data.oMf[self.robot.frame_id(frame)].rotation

    def jacobian(self, frame, point):
        """(6, nv) of the point of a body at a place of the world."""
        item = self.model.frames[self.robot.frame_id(frame)]
        if item.parentJoint == 0:
            return np.zeros((6, self.model.nv))
        there = pin.SE3(np.eye(3), self.data.oMi[item.parentJoint].actInv(point))
        return pin.getFrameJacobian(
            self.model, self.data, item.parentJoint, there, pin.LOCAL_WORLD_ALIGNED
        )

    def between(self, frame, point, other, other_point):
        return self.jacobian(frame, point) - self.jacobian(other, other_point)


def turned(axes, rows):
    return np.vstack([axes.T @ rows[:3], axes.T @ rows[3:]])


def rows_at(scene, q, v, **more):
    """The core's rows: by its own columns, the same by Pinocchio's."""
    flat, model = flat_scene(scene), scene.robot.model
    found = flat.rows(q, v, **more)
    data = model.createData()
    own = flat.rows(q, v, jacobian=pin.computeJointJacobians(model, data, q), **more)
    for name in ("A", "J", "target"):
        assert np.allclose(getattr(found, name), getattr(own, name), rtol=0.0, atol=1e-12)
    return found


def same(found, truth):
    size = max(1.0, np.abs(truth).max(initial=0.0))
    return found.shape == np.ravel(truth).shape and np.allclose(
        found, np.ravel(truth), rtol=0.0, atol=EXACT * size
    )


@pytest.mark.parametrize("other", ["world", "arm/panda_hand", "dog/FL_FOOT"])
@pytest.mark.parametrize("other_at", [None, ELSEWHERE])
def test_anchors(robot, other, other_at):
    q, v = random_state(robot, 1)
    at = {"at": AT, "other_at": other_at}
    directions = ("x", "z", "ry", "rz")
    scene = ik.Scene(
        robot,
        constraints=[
            ik.PointAnchor("dog/FR_FOOT", other, **at, velocity=(1, 2, 3)),
            ik.FrameAnchor("dog/HR_FOOT", other, **at, velocity="kept"),
            ik.FrameAnchor("dog/HL_FOOT", other, **at, directions=directions, axes="local"),
        ],
    )
    found, bodies = rows_at(scene, q, v), Bodies(robot, q)
    truth = []
    for frame in ("dog/FR_FOOT", "dog/HR_FOOT", "dog/HL_FOOT"):
        point = bodies.place(frame, AT)
        there = point if other_at is None else bodies.place(other, other_at)
        truth.append(bodies.between(frame, point, other, there))
    local = turned(bodies.axes("dog/HL_FOOT"), truth[2])[[0, 2, 4, 5]]
    assert same(found.A, np.vstack([truth[0][:3], truth[1], local]))
    assert same(found.target, np.concatenate([[1, 2, 3], truth[1] @ v, np.zeros(4)]))


def test_rods_and_ropes(robot):
    q, v = random_state(robot, 2)
    bodies = Bodies(robot, q)
    ends = [bodies.place("ball/ball", AT), bodies.place("arm/panda_hand", ELSEWHERE)]
    way = ends[0] - ends[1]
    length, n = np.linalg.norm(way), way / np.linalg.norm(way)
    at = {"at": AT, "other_at": ELSEWHERE}
    rope = {"frame": "ball/ball", "other": "arm/panda_hand", **at}
    scene = ik.Scene(
        robot,
        constraints=[ik.DistanceAnchor("ball/ball", "arm/panda_hand", **at)],
        contacts=[
            ik.Rope(**rope, length=length - 0.1, name="taut"),
            ik.Rope(**rope, length=length + 0.1, name="slack"),
        ],
    )
    found = rows_at(scene, q, v)
    rate = n @ bodies.between("ball/ball", ends[0], "arm/panda_hand", ends[1])[:3]
    assert same(found.A, rate[None])
    assert found.entries == [0]
    assert same(found.J, np.vstack([np.zeros((2, robot.nv)), -rate]))
    assert same(found.gaps, np.array([-0.1]))
    assert rows_at(scene, q, v, only=[False, True]).entries == [1]


def test_a_line_needs_two_points(robot):
    q, v = robot.neutral(), np.zeros(robot.nv)
    bodies = Bodies(robot, q)
    there = tuple(bodies.place("ball/ball"))
    scene = ik.Scene(robot, constraints=[ik.DistanceAnchor("ball/ball", other_at=there)])
    with pytest.raises(ik.errors.InputError, match="no line joins them"):
        flat_scene(scene).rows(q, v)


def test_speeds_of_joints(robot):
    q, v = random_state(robot, 3)
    index = {name: robot.model.joints[robot.joint_id(name)].idx_v for name in robot.joint_names}
    a, b, c = "arm/panda_joint1", "arm/panda_joint2", "dog/FL_HIP_JOINT"
    if c not in index:
        c = [name for name in robot.joint_names if name.startswith("dog/")][3]
    scene = ik.Scene(
        robot,
        constraints=[
            ik.JointLock(a, velocity=0.5),
            ik.JointCoupling(b, c, ratio=-2.0),
            ik.Driven("arm/panda_joint3", lambda t: 0.1 * np.sin(2 * t)),
        ],
        controlled=["arm/panda_joint4"],
    )
    found = rows_at(scene, q, v)
    truth = np.zeros((4, robot.nv))
    truth[0, index[a]] = truth[1, index[b]] = 1.0
    truth[1, index[c]] = 2.0
    truth[2, index["arm/panda_joint3"]] = truth[3, index["arm/panda_joint4"]] = 1.0
    assert same(found.A, truth)
    assert np.allclose(found.target, [0.5, 0.0, 0.2, truth[3] @ v], atol=1e-9)


def test_stops_and_the_control_that_yields_to_them(robot):
    q, v = random_state(robot, 4)
    index = robot.joint_id("arm/panda_joint4")
    at, speed = robot.model.joints[index].idx_q, robot.model.joints[index].idx_v
    stop = ik.JointStop("arm/panda_joint4", lower=-2.0, upper=-1.0)
    scene = ik.Scene(robot, contacts=[stop], controlled=["arm/panda_joint4"])
    row = np.zeros((1, robot.nv))
    row[0, speed] = 1.0
    v[speed] = -0.7
    for place, normal, held in ((-2.1, 1.0, False), (-1.5, 0.0, True), (-0.9, -1.0, True)):
        q[at] = place
        found = rows_at(scene, q, v)
        assert same(found.A, row if held else 0.0 * row)
        assert same(found.target, np.array([-0.7 if held else 0.0]))
        if normal:
            assert found.entries == [0]
            assert same(found.J, np.vstack([np.zeros((2, robot.nv)), normal * row]))
            assert not found.of_bodies[0]
        else:
            assert found.entries == []
    q[at] = -1.6
    near = rows_at(scene, q, v, only=[True])
    assert same(near.J[2 * robot.nv :], row)
    assert same(near.gaps, np.array([0.4]))


@pytest.mark.parametrize("against", ["world", "arm/panda_hand", "dog/base_link"])
def test_points_on_planes(robot, against):
    q, v = random_state(robot, 5)
    normal = np.array([0.3, -0.5, 0.7])
    turning = {"rolling": 0.1, "torsion": 0.2}
    friction = ik.scene.coefficients.EllipticFriction(0.5, 0.2, along=(1, 2, 0))
    on = {"at": AT, "normal": normal, "origin": ELSEWHERE, "against": against}
    scene = ik.Scene(
        robot,
        contacts=[
            ik.Contact("dog/FR_FOOT", **on, friction=0.5, **turning),
            ik.Contact("dog/HL_FOOT", **on, friction=friction),
        ],
    )
    found, bodies = rows_at(scene, q, v), Bodies(robot, q)
    assert found.entries == [0, 1]
    assert found.turning_of == [0]
    n = bodies.axes(against) @ normal / np.linalg.norm(normal)
    truth, spins = [], []
    for k, frame in enumerate(("dog/FR_FOOT", "dog/HL_FOOT")):
        axes, place = found.axes.reshape(-1, 3, 3)[k], bodies.place(frame, AT)
        assert np.allclose(axes[:, 2], n, atol=EXACT)
        assert np.allclose(axes.T @ axes, np.eye(3), atol=EXACT)
        assert np.linalg.det(axes) > 0.0
        assert same(found.places[3 * k : 3 * k + 3], place)
        assert np.isclose(found.gaps[k], n @ (place - bodies.place(against, ELSEWHERE)), atol=1e-13)
        rows = turned(axes, bodies.between(frame, place, against, place))
        truth.append(rows[:3])
        spins.append(rows[3:])
        along = axes[:, :2].T @ bodies.axes(against) @ np.array([1, 2, 0])
        if k == 1:
            assert np.allclose(found.ellipses[2:], along / np.linalg.norm(along), atol=EXACT)
    assert same(found.J, np.vstack([*truth, spins[0]]))


def test_rows_by_functions(robot):
    q, v = random_state(robot, 6)
    scale = np.arange(robot.nv) + 1.0
    joint = robot.model.joints[robot.joint_id("arm/panda_joint1")]
    at = joint.idx_q

    def gradient(q):
        rows = np.zeros(robot.nv)
        rows[joint.idx_v] = 2.0 * q[at]
        return rows

    kept = ik.GapConstraint(lambda q: q[at] ** 2, gradient=gradient, velocity=0.3)
    touching = ik.GapContact(lambda q: q[at] ** 2 - 9.0, normal=gradient, tangents=lambda q: scale)
    open_one = ik.GapContact(lambda q: q[at] ** 2 + 9.0, normal=gradient)
    scene = ik.Scene(robot, constraints=[kept], contacts=[open_one, touching])
    found = rows_at(scene, q, v)
    assert same(found.A, gradient(q)[None])
    assert same(found.target, np.array([0.3]))
    assert found.entries == [1]
    assert same(found.J, np.vstack([scale, np.zeros(robot.nv), gradient(q)]))


def nearest(pieces, data):
    """The distance of two shapes, the middle of the nearest points, the normal from the second."""
    import coal

    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    ends = []
    for piece in pieces:
        place = data.oMi[piece.parentJoint] * piece.placement
        ends += [piece.geometry, coal.Transform3s(place.rotation, place.translation)]
    gap = coal.distance(*ends, request, result)
    points = result.getNearestPoint1(), result.getNearestPoint2()
    return gap, 0.5 * (points[0] + points[1]), -result.normal


def test_what_meets_a_ball():
    """The point, the normal and the gap that coal finds, whichever of the two is named first."""
    shapes = {
        "sphere": '<sphere radius="0.3"/>',
        "box": '<box size="0.4 0.6 0.8"/>',
        "cylinder": '<cylinder radius="0.3" length="0.8"/>',
    }
    rng, compared = np.random.default_rng(7), 0
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    for shape, geometry in shapes.items():
        text = f"""<robot name="{shape}"><link name="{shape}"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><geometry>{geometry}</geometry>
        </collision></link></robot>"""
        robot = ik.combine(ball=ball, body=ik.Robot.from_urdf(text, root="freeflyer"))
        names, pieces = ("ball/ball", f"body/{shape}"), robot.collision_model.geometryObjects
        for way in (1, -1):
            first, other = names[::way]
            flat = flat_scene(ik.Scene(robot, contacts=[ik.Collision(first, other, margin=1.0)]))
            assert not flat.shaped
            for _ in range(10):
                q = pin.integrate(robot.model, robot.neutral(), rng.uniform(-0.8, 0.8, robot.nv))
                bodies, found = Bodies(robot, q), flat.rows(q, np.zeros(robot.nv))
                gap, place, normal = nearest(list(pieces)[::way], bodies.data)
                if gap < 1e-3:
                    continue
                assert found.entries == ([0] if gap <= 1.0 else [])
                if not found.entries:
                    continue
                axes = found.axes.reshape(3, 3)
                assert np.isclose(found.gaps[0], gap, atol=1e-6)
                assert np.allclose(axes[:, 2], normal, atol=1e-5)
                assert np.allclose(found.places, place, atol=1e-5)
                rows = bodies.between(first, found.places, other, found.places)
                assert same(found.J, turned(axes, rows)[:3])
                compared += 1
    assert compared > 20


def test_points_of_shapes(robot):
    q, v = random_state(robot, 8)
    flat = flat_scene(ik.Scene(robot, contacts=[ik.Contact("ball/ball")]))
    place, normal = np.array([0.3, 0.2, 0.1]), np.array([0.0, 0.6, 0.8])
    ids = [robot.joint_id(name) for name in ("arm/panda_joint7", "dog/root_joint")]
    # Balls of 5 cm on either side of two places, of which the second are a centimetre apart.
    shapes = [
        [
            ball_shape(0.05, place_numbers(pin.SE3(np.eye(3), at)))
            for k in range(2)
            for at in [joint.actInv(place + k + side * (0.05 + 0.005 * k) * normal)]
        ]
        for joint, side in zip(map(flat.placements(q), ids), (1.0, -1.0), strict=True)
    ]
    sites = [(flat.model.bodies[joint], np.eye(4, 3).ravel()) for joint in ids]
    flat.core.touch_bodies(*sites, 0.02, True, None, *shapes)
    found = flat.core.rows(q, v)
    assert found.entries == [0, 1, 1]
    assert found.turning_of == [1, 2]
    bodies = Bodies(robot, q)
    own, spin = [], []
    for k in range(2):
        there = place + k
        rows = bodies.between("arm/panda_link7", there, "dog/base_link", there)
        rows = turned(found.axes.reshape(-1, 3, 3)[1 + k], rows)
        own.append(rows[:3])
        spin.append(rows[3:])
    assert same(found.J[3 * robot.nv :], np.vstack([*own, *spin]))
    assert same(found.gaps[1:], np.array([0.0, 0.01]))


def test_far_away(robot):
    """However far a robot stands, rows between it and the world keep their digits."""
    dog = ik.Robot.from_example("solo12", root="freeflyer")
    scene = ik.Scene(dog, contacts=[ik.Contact("FR_FOOT", at=AT), ik.Contact("HL_FOOT")])
    q, v = random_state(dog, 9)
    near = flat_scene(scene).rows(q, v)
    q[:3] += (1e6, -3e6, 1e6)
    far = flat_scene(scene).rows(q, v)
    assert same(far.J, near.J)
