"""A box that is thrown on a floor: it strikes, rocks, slides, spins and comes to rest."""

import numpy as np
import pinocchio as pin
import pytest
import scipy.integrate

import impulsekit as ik

from .models import GRAVITY, MODELS

CORNERS = np.array([(x, y, z) for x in (-0.15, 0.15) for y in (-0.1, 0.1) for z in (-0.05, 0.05)])
LOWER = CORNERS[CORNERS[:, 2] < 0]


def heights(q):
    """(8,) of the corners."""
    return np.array([pin.XYZQUATToSE3(q[:7]).act(corner)[2] for corner in CORNERS])


def thrown(kind, seed):
    """A scene and a state: any tilt, slip and spin, µ from 0.1 to 0.8, e up to 0.5."""
    rng = np.random.default_rng(seed)
    law = {"friction": rng.uniform(0.1, 0.8), "restitution": rng.uniform(0.0, 0.5)}
    turn = pin.Quaternion(pin.rpy.rpyToMatrix(*rng.uniform(-0.5, 0.5, 2), rng.uniform(-3, 3)))
    height = 0.05 + rng.uniform(0.0, 0.2) - (CORNERS @ turn.matrix().T)[:, 2].min()
    speed = np.concatenate([rng.uniform(-1, 1, 3), rng.uniform(-4, 4, 3)])
    robot, root = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer"), "root_joint"
    if kind == "planes":
        contacts = [ik.Contact("box", at=corner, **law) for corner in CORNERS]
    elif kind == "ground":
        robot, root = robot.with_ground(), "root_joint"
        contacts = [ik.Collision("box", "ground", **law)]
    else:
        floor = ik.Robot.from_urdf(MODELS / "floor.urdf")
        robot, root = ik.combine(floor=floor, box=robot), "box/root_joint"
        pair = ("box/box", "floor/floor")
        contacts = [ik.Collision(*(pair if kind == "collision" else pair[::-1]), **law)]
    q = robot.configuration({root: [0, 0, height, *turn.coeffs()]})
    return ik.Scene(robot, contacts=contacts), q, robot.velocity({root: speed})


def check_drop(kind, seed):
    scene, q, v = thrown(kind, seed)
    motion = ik.simulate(scene, q, v, duration=4.0, samples=2001, accuracy="high")
    assert motion.status.finished, motion.detail
    assert np.abs(motion.v[-1]).max() < 1e-9
    # Slip that stops, turns or begins holds up no steps.
    assert motion.steps < 1500
    assert np.diff(motion.energy().total).max() < 1e-9
    lowest = min(heights(q).min() for q in motion.q)
    assert lowest > -2e-9
    # It lies flat on one of its faces, all four corners down.
    assert np.sort(np.abs(heights(motion.q[-1])))[3] < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed"), [("planes", 4), ("planes", 11), ("collision", 1), ("ground", 4)]
)
def test_a_thrown_box_comes_to_rest(kind, seed):
    check_drop(kind, seed)


def sliding(friction, velocity, duration, **changes):
    """A box that slides on its four lower corners."""
    box = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
    contacts = [ik.Contact("box", at=corner, friction=friction) for corner in LOWER]
    q = box.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1])
    v = box.velocity(root_joint=velocity)
    scene = ik.Scene(box, contacts=contacts)
    return ik.simulate(scene, q, v, duration=duration, samples=41, **changes, accuracy="high")


def test_a_box_that_slides_and_spins_shares_its_load_as_equal_springs_do():
    mass, inertia, mu, high = 3.0, 0.0325, 0.25, 0.05
    start, end = np.array([0.8, 0.3, 5.0]), 0.25

    def rates(t, y):
        """(x, y, angle, and their rates): loads are a plane over the corners' places."""
        turn = np.array([[np.cos(y[2]), -np.sin(y[2])], [np.sin(y[2]), np.cos(y[2])]])
        places = LOWER[:, :2] @ turn.T
        slip = y[3:5] + y[5] * np.column_stack([-places[:, 1], places[:, 0]])
        s = slip / np.linalg.norm(slip, axis=1)[:, None]
        springs = np.column_stack([np.ones(4), places])
        # Weight; and no turn about x and y, where friction acts below the centre.
        balance = np.array([np.ones(4), places[:, 1] - mu * high * s[:, 1]])
        balance = np.vstack([balance, -places[:, 0] + mu * high * s[:, 0]])
        loads = springs @ np.linalg.solve(balance @ springs, [mass * GRAVITY, 0, 0])
        assert (loads > 0).all()
        force = -mu * loads[:, None] * s
        torque = places[:, 0] @ force[:, 1] - places[:, 1] @ force[:, 0]
        return np.concatenate([y[3:], force.sum(axis=0) / mass, [torque / inertia]])

    motion = sliding(mu, [*start[:2], 0, 0, 0, start[2]], end)
    path = scipy.integrate.solve_ivp(
        rates, (0, end), [0, 0, 0, *start], "DOP853", motion.t, rtol=1e-13, atol=1e-14
    )
    assert not motion.impacts
    np.testing.assert_allclose(motion.q[:, :2], path.y[:2].T, rtol=0, atol=1e-9)
    angle = 2.0 * np.arctan2(motion.q[:, 5], motion.q[:, 6])
    np.testing.assert_allclose(angle, path.y[2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.v[:, 5], path.y[5], rtol=0, atol=1e-8)
