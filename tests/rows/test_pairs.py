"""Rows of pairs of frames are rates of places: held against differences of placements."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact.derivatives.expanded import expanded_model
from impulsekit.impact.derivatives.motion import Motion
from impulsekit.impact.derivatives.pairs import PairRows
from impulsekit.impact.derivatives.pulls import Pulls
from impulsekit.rows.constraints import ConstraintRows
from impulsekit.rows.contacts import ContactRows
from impulsekit.rows.entries import FramePair, rows_of_entry
from impulsekit.rows.pair import Pair
from impulsekit.rows.reach import reached_model

STEP = 1e-5


def _robot(seed: int) -> ik.Robot:
    """A random tree of joints of many kinds, with two free bodies beside it."""
    random = np.random.default_rng(seed)
    pin.seed(seed)
    kinds = (
        pin.JointModelFreeFlyer,
        pin.JointModelRZ,
        pin.JointModelPX,
        pin.JointModelSpherical,
        pin.JointModelRUBY,
        pin.JointModelPlanar,
        lambda: pin.JointModelRevoluteUnaligned(*_unit(random)),
    )
    model = pin.Model()
    way: list[int] = []
    for i in range(8):
        # Depth first: a joint hangs on the one before it, or on one that that one hangs on.
        way = [] if i in (0, 5) else way[: int(random.integers(1, len(way) + 1))]
        parent = way[-1] if way else 0
        kind = kinds[0] if i == 5 else kinds[int(random.integers(len(kinds)))]
        joint = model.addJoint(parent, kind(), pin.SE3.Random(), f"joint {i}")
        way = [*way, joint]
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Random())
        model.addFrame(
            pin.Frame(f"body {i}", joint, 0, pin.SE3.Random(), pin.FrameType.BODY), False
        )
    model.addFrame(pin.Frame("fixed", 0, 0, pin.SE3.Random(), pin.FrameType.BODY), False)
    return ik.Robot.from_model(model)


def _unit(random: np.random.Generator) -> np.ndarray:
    axis = random.normal(size=3)
    return axis / np.linalg.norm(axis)


def _entries(robot: ik.Robot, random: np.random.Generator) -> list:
    """One of every kind that speaks of two frames, on frames drawn at random."""

    def point() -> list[float]:
        return random.normal(size=3).tolist()

    def two() -> list[str]:
        return [str(name) for name in random.permutation([f"body {i}" for i in range(8)])[:2]]

    first, other = two()
    directions = tuple(random.permutation(["x", "y", "z", "rx", "ry", "rz"])[:4].tolist())
    entries = []
    for a, b in ((first, other), (first, "world"), ("world", other), (first, "fixed")):
        for other_at in (None, point()):
            entries.append(ik.PointAnchor(a, b, at=point(), other_at=other_at))
            for axes in ("world", "local"):
                entries.append(
                    ik.FrameAnchor(
                        a, b, at=point(), other_at=other_at, axes=axes, directions=directions
                    )
                )
    for against in (other, "world", "fixed"):
        plane = {"normal": _unit(random).tolist(), "origin": point(), "against": against}
        entries.append(ik.Contact(first, at=point(), **plane))
    for b in (other, "world"):
        entries.append(ik.DistanceAnchor(first, b, at=point(), other_at=point()))
    for axes in ("world", "local"):
        entries.append(ik.AppliedImpulse(first, linear=[1, 0, 0], at=point(), axes=axes))
    return entries


def _state(robot: ik.Robot, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    q = pin.integrate(robot.model, pin.neutral(robot.model), random.normal(size=robot.nv))
    return q, random.normal(size=robot.nv)


def _frames(robot: ik.Robot, entry: object) -> tuple[str, list[float], str, list[float] | None]:
    """The frames and points of an entry, as its own words say them."""
    if isinstance(entry, ik.Contact):
        return entry.frame, entry.at, entry.against, None
    if isinstance(entry, ik.AppliedImpulse):
        return entry.frame, entry.at, "world", None
    return entry.frame, entry.at, entry.other, entry.other_at


def _rates(robot: ik.Robot, entry: object, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(6,) of the first point against the other, world axes, by differences of placements."""
    frame, at, other, other_at = _frames(robot, entry)
    model, data = robot.model, robot.model.createData()

    def places(t: float) -> tuple[pin.SE3, pin.SE3]:
        pin.framesForwardKinematics(model, data, pin.integrate(model, q, t * v))
        first, second = (data.oMf[robot.frame_id(name)] for name in (frame, other))
        return pin.SE3(first), pin.SE3(second)

    here, there = places(0.0)
    met = here.act(np.array(at))
    on_other = np.array(other_at) if other_at is not None else there.actInv(met)
    (a1, b1), (a2, b2) = places(-STEP), places(STEP)
    moved = [a.act(np.array(at)) - b.act(on_other) for a, b in ((a1, b1), (a2, b2))]
    turns = [pin.log3(y.rotation @ x.rotation.T) for x, y in ((a1, a2), (b1, b2))]
    return np.concatenate([moved[1] - moved[0], turns[0] - turns[1]]) / (2.0 * STEP)


@pytest.mark.parametrize("seed", range(6))
def test_rows_are_rates_of_places(seed: int) -> None:
    random, robot = np.random.default_rng(seed), _robot(seed)
    for entry in _entries(robot, random):
        reached = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True)
        said = rows_of_entry(robot, entry)
        assert isinstance(said, FramePair)
        pair = Pair(reached, said)
        data = reached.model.createData()
        q, v = _state(robot, random)
        rates = _rates(robot, entry, q, v)
        pin.forwardKinematics(reached.model, data, q)
        turn = np.kron(np.eye(2), pair.axes(data).T)
        wanted = (turn @ rates)[list(said.select)]
        scale = 1.0 + np.abs(rates).max()
        assert (
            np.abs(pair.jacobian(reached.model.createData(), q) @ v - wanted).max() < 1e-8 * scale
        )
        pin.computeJointJacobians(reached.model, data, q)
        assert np.abs(pair.rows(data) @ v - wanted).max() < 1e-8 * scale


@pytest.mark.parametrize("seed", range(6))
def test_bias_is_the_rate_of_the_rows_at_constant_speeds(seed: int) -> None:
    random, robot = np.random.default_rng(100 + seed), _robot(seed)
    for entry in _entries(robot, random):
        reached = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True)
        said = rows_of_entry(robot, entry)
        assert isinstance(said, FramePair)
        pair, model = Pair(reached, said), reached.model
        data, (q, v) = model.createData(), _state(robot, random)
        speeds = [
            pair.jacobian(data, pin.integrate(model, q, sign * STEP * v)) @ v for sign in (-1, 1)
        ]
        wanted = (speeds[1] - speeds[0]) / (2.0 * STEP)
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        scale = 1.0 + np.abs(wanted).max()
        assert np.abs(pair.bias(data) - wanted).max() < 1e-7 * scale


@pytest.mark.parametrize("seed", range(4))
def test_an_anchor_in_the_frame_has_the_rows_of_the_world_turned(seed: int) -> None:
    random, robot = np.random.default_rng(200 + seed), _robot(seed)
    q, _ = _state(robot, random)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    axes = data.oMf[robot.frame_id("body 3")].rotation
    rows = []
    for kind in ("world", "local"):
        scene = ik.Scene(
            robot, constraints=[ik.FrameAnchor("body 3", "body 6", at=[1, 2, 3], axes=kind)]
        )
        reached = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True)
        own = ConstraintRows.of(scene, reached)
        rows.append(own.matrix(reached.model.createData(), q))
    assert np.abs(np.kron(np.eye(2), axes.T) @ rows[0] - rows[1]).max() < 1e-13


def test_rows_of_joints_are_their_speeds() -> None:
    robot = ik.Robot.from_model(pin.buildSampleModelManipulator())
    first, other = robot.joint_names[:2]
    constraints = [ik.JointLock(other), ik.JointCoupling(first, other, ratio=-2.0)]
    scene = ik.Scene(robot, constraints=constraints, contacts=[ik.JointStop(first)])
    reached = reached_model(robot.model, range(1, robot.model.njoints))
    rows = ConstraintRows.of(scene, reached)
    matrix = rows.matrix(reached.model.createData(), pin.neutral(robot.model))
    wanted = np.zeros((2, robot.nv))
    wanted[0, 1] = 1.0
    wanted[1, 0], wanted[1, 1] = 1.0, 2.0
    assert (matrix == wanted).all()
    q = pin.neutral(robot.model)
    q[0] = robot.model.upperPositionLimit[0]
    (touch,) = ContactRows(scene, reached).touching(reached.model.createData(), q)
    assert (touch.jacobian[2] == -np.eye(robot.nv)[0]).all()


@pytest.mark.parametrize("seed", range(4))
def test_the_rows_of_a_contact_on_a_moving_plane_are_those_of_its_point(seed: int) -> None:
    random, robot = np.random.default_rng(300 + seed), _robot(seed)
    normal = _unit(random)
    contact = ik.Contact("body 2", at=[0.3, -1, 2], normal=normal.tolist(), against="body 6")
    scene = ik.Scene(robot, contacts=[contact])
    reached = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True)
    q, v = _state(robot, random)
    (touch,) = ContactRows(scene, reached).touching(reached.model.createData(), q)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    assert touch.axes is not None
    assert (
        np.abs(touch.axes[:, 2] - data.oMf[robot.frame_id("body 6")].rotation @ normal).max()
        < 1e-14
    )
    rates = _rates(robot, contact, q, v)
    scale = 1.0 + np.abs(rates).max()
    assert np.abs(touch.jacobian @ v - touch.axes.T @ rates[:3]).max() < 1e-8 * scale


@pytest.mark.parametrize("seed", range(3))
def test_derivatives_of_rows_are_differences(seed: int) -> None:
    random, robot = np.random.default_rng(400 + seed), _robot(seed)
    model = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True).model
    expanded = expanded_model(model)
    for entry in _entries(robot, random)[seed::3]:
        said = rows_of_entry(robot, entry)
        assert isinstance(said, FramePair)
        rows = PairRows(expanded, said)
        reached = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True)
        pair = Pair(reached, said)
        data = reached.model.createData()
        q, v = _state(robot, random)
        impulse = random.normal(size=len(said.select))
        placed = rows.placed(Motion(expanded, expanded.model.createData(), q, v))
        assert np.abs(placed.matrix - pair.jacobian(data, q)).max() < 1e-12
        change, pulls = placed.change_of_velocity(), Pulls(expanded)
        placed.pull(pulls, impulse)
        pulled = pulls.total()
        assert change is not None and pulled is not None
        for j in range(robot.nv):
            step = STEP * np.eye(robot.nv)[j]
            ahead, back = (
                pair.jacobian(data, pin.integrate(model, q, sign * step)) for sign in (1, -1)
            )
            rate = (ahead - back) / (2.0 * STEP)
            scale = 1.0 + np.abs(rate).max()
            assert np.abs(change[:, j] - rate @ v).max() < 1e-7 * scale * np.abs(v).sum()
            assert np.abs(pulled[:, j] - rate.T @ impulse).max() < 1e-7 * scale * 6.0
