"""Tables of resting points: rows and rates against differences, accelerations against M a = f."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.motion.dynamics.accelerations import Dynamics
from impulsekit.motion.gaps.contacts import Gaps
from impulsekit.motion.gaps.resting import RestingContact
from impulsekit.motion.tree.memory import Memory
from impulsekit.motion.tree.pressed import rows_and_bias
from impulsekit.rows.reach import reached_model

from ...robots import one_body

BOX = """<robot name="box"><link name="box"><inertial><mass value="{mass}"/>
<inertia ixx="0.2" iyy="0.3" izz="0.4" ixy="0.01" ixz="0" iyz="0.02"/></inertial>
<collision><geometry><box size="0.4 0.3 0.2"/></geometry></collision></link></robot>"""


def boxes():
    one, two = (ik.Robot.from_urdf(BOX.format(mass=m), root="freeflyer") for m in (1.0, 2.5))
    return ik.combine(a=one, b=two)


def state(robot, place):
    rng = np.random.default_rng(4)
    q = robot.neutral().copy()
    q[7:10] = place[:3]
    q[10:14] = pin.Quaternion(pin.exp3(np.array(place[3:]))).coeffs()
    return q, rng.normal(size=robot.nv)


def kinematics(memory, model, q, v):
    pin.forwardKinematics(model, memory.data, q, v, np.zeros(model.nv))
    pin.computeJointJacobians(model, memory.data)
    return memory.kinematics


SCENES = {
    # A point over a plane in the world, one over a plane that another body carries.
    "planes": (
        [
            ik.Contact("a/box", at=[0.2, -0.15, 0.1], normal=[0.1, 0.3, 1.0], origin=[0, 1, 0]),
            ik.Contact("b/box", at=[0.1, 0.1, -0.1], normal=[1, 0, 2], against="a/box"),
        ],
        [0.3, 0.1, 0.5, 0.3, -0.2, 0.4],
        True,
    ),
    # A corner over a face of the other box, and one edge across another.
    "corner": ([ik.Collision("b/box", "a/box")], None, False),
    "edges": ([ik.Collision("a/box", "b/box")], None, False),
}


def on_its_corner(way):
    """(6,) where box b touches box a with its lowest corner, or edge on edge."""
    if way == "corner":
        turn = np.array([0.5, 0.6, 0.2])
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        low = (corners * [0.2, 0.15, 0.1] @ pin.exp3(turn).T)[:, 2].min()
        return [0.02, 0.01, 0.1 - low, *turn]
    # Edge along y of box a's top at x = 0.2; box b turned so that one of its edges lies across.
    turn = pin.exp3(np.array([0.0, 0.0, 0.8])) @ pin.exp3(np.array([np.pi / 4, 0.0, 0.0]))
    both = pin.exp3(np.array([0.0, np.pi / 4, 0.0]))
    turn = both @ turn
    low = both @ np.array([0, 0, 1.0])
    return [*(np.array([0.2, 0, 0.1]) + low * (0.15 + 0.1) / np.sqrt(2)), *pin.log3(turn)]


@pytest.mark.parametrize("name", SCENES)
def test_rows_and_rates_are_those_of_the_gaps_and_of_velocities_that_change(name):
    contacts, place, rated = SCENES[name]
    robot = boxes()
    scene = ik.Scene(robot, contacts=contacts)
    reached = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True)
    gaps, model = Gaps(scene, reached), reached.model
    q, v = state(robot, on_its_corner(name) if place is None else place)
    resting = [RestingContact(i, i, 0.0, 0.0) for i in range(len(contacts))]
    gaps.hold(resting, q)
    table = gaps.table(resting)
    memory = Memory(model)
    normals = rows_and_bias(table, kinematics(memory, model, q, v))[0][2::3]
    if not rated:
        # Bodies that touch, and go on touching.
        v = v - np.linalg.pinv(normals) @ (normals @ v)
    rows, bias = (a.copy() for a in rows_and_bias(table, kinematics(memory, model, q, v)))
    h = 1e-5

    def there(step):
        moved = pin.integrate(model, q, step * v)
        found = rows_and_bias.py_func(table, kinematics(memory, model, moved, v))[0]
        distances = gaps.measure(moved, v)[0] if rated else gaps.of_points(resting, moved, v)
        return found @ v, distances

    (after, gap_after), (before, gap_before) = there(h), there(-h)
    np.testing.assert_allclose(bias, (after - before) / (2 * h), rtol=0, atol=1e-8)
    np.testing.assert_allclose(
        (rows @ v)[2::3], (gap_after - gap_before) / (2 * h), rtol=0, atol=1e-8
    )


def test_points_that_stick_are_accelerated_by_nothing_and_forces_account_for_the_rest():
    """M a = τ − h + JᵀP with J a + J̇ v = 0 at three points, which determine a box."""
    robot = ik.Robot.from_urdf(BOX.format(mass=2.0), root="freeflyer")
    feet = [(0.1, 0.1), (-0.1, 0.1), (0.0, -0.12)]
    contacts = [ik.Contact("box", at=[*at, -0.1], normal=[0, 0, 1], friction=3.0) for at in feet]
    dynamics = Dynamics(ik.Scene(robot, contacts=contacts))
    dynamics.resting.contacts = [RestingContact(i, i, 3.0, 0.0) for i in range(3)]
    q, v = robot.neutral().copy(), np.zeros(6)
    q[2] = 0.1
    acceleration = dynamics.acceleration(0.0, q, v)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-11)
    forces = dynamics.resting.forces.reshape(3, 3)
    # Columns are the two axes across the normal, and the normal.
    np.testing.assert_allclose(forces.sum(axis=0), [0, 0, 2.0 * 9.81], atol=1e-10)
    turning = sum(np.cross([*at, 0.0], [0, 0, p[2]]) for at, p in zip(feet, forces, strict=True))
    np.testing.assert_allclose(turning, 0.0, atol=1e-10)


def test_sliding_points_push_along_their_cones():
    """A particle on a plane: v̇ = −µ g along the slip, whatever way that goes."""
    ball = one_body("p", 3, 1000000000.0)
    dynamics = Dynamics(ik.Scene(ball, contacts=[ik.Contact("p", normal=[0, 0, 1], friction=0.25)]))
    slip = np.array([0.6, -0.8, 0.0])
    contact = RestingContact(0, 0, 0.25, 0.0)
    dynamics.resting.contacts = [contact]
    q, v = ball.neutral(), np.concatenate([2.0 * slip, np.zeros(3)])
    dynamics.resting.begin(dynamics.gaps.velocities([contact], q, v))
    found = dynamics.acceleration(0.0, q, v)
    np.testing.assert_allclose(found[:3], -0.25 * 9.81 * slip, atol=1e-8)
