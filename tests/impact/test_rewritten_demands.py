"""One demand, written in many ways: the same velocities, the same resultants."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact.elimination import Elimination
from impulsekit.impact.forces import body_impulses

from ..robots import STRUCK, random_blow, random_state, relative


def wrench_on(impact, names, frame):
    """(6,) what constraints give a frame in all, about its origin, world axes."""
    model, data = impact.scene.robot.model, impact.scene.robot.model.createData()
    pin.framesForwardKinematics(model, data, impact.q)
    frame_id = impact.scene.robot.frame_id(frame)
    total = np.zeros(6)
    for item in body_impulses(impact):
        if item.entry in names and item.frame_id == frame_id:
            total += data.oMi[item.joint_id].act(item.wrench_in_joint).vector
    total[3:] -= np.cross(data.oMf[frame_id].translation, total[:3])
    return total


GRIP = ("near/ball/ball", "near/arm/panda_hand")


@pytest.fixture(scope="module")
def grip():
    """A ball, an arm and a dog; all about a grip of the ball, and what it gives."""
    near = ik.combine(
        arm=ik.Robot.from_example("panda"),
        ball=ik.Robot.from_urdf("models/ball.urdf", root="freeflyer"),
        placements={"arm": [0.2, -0.1, 0.4]},
    )
    world = ik.combine(near=near, dog=ik.Robot.from_example("solo12", root="freeflyer"))
    q, v = random_state(world, 7)
    blows = [random_blow("near/arm/panda_hand", 1), random_blow("dog/FR_FOOT", 2)]

    def grasp(constraints):
        names = [entry.name for entry in constraints if {*entry.frame_names} == {*GRIP}]
        impact = ik.solve(ik.Scene(world, blows, constraints), q, v)
        assert impact.is_valid()
        return impact.v_after, wrench_on(impact, names, GRIP[0])

    return grasp


def other_ways():
    hand, held = GRIP[1], GRIP[0]
    whole = ik.FrameAnchor(held, hand, name="a")
    lines = [ik.FrameAnchor(held, hand, directions=(d,), name=d) for d in "x y z".split()]  # noqa: SIM905
    turns = [ik.FrameAnchor(held, hand, directions=(d,), name=d) for d in ("rx", "ry", "rz")]
    away = {"at": (0.3, -0.2, 0.1)}
    return {
        "in local axes": [ik.FrameAnchor(held, hand, axes="local", name="a")],
        "from the other side": [ik.FrameAnchor(hand, held, at=(1, 0, 0), name="a")],
        "from the other side, in its axes": [ik.FrameAnchor(hand, held, axes="local", name="a")],
        "about another point": [ik.FrameAnchor(held, hand, **away, name="a")],
        "row by row, backwards": [*turns[::-1], *lines[::-1]],
        "twice": [whole, ik.FrameAnchor(held, hand, name="b")],
        "twice, in two frames": [whole, ik.FrameAnchor(hand, held, axes="local", **away, name="b")],
        "by points": [ik.PointAnchor(held, hand, at=at, name=f"{at}")
                      for at in ((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3))],
        "once too often": [whole, lines[1], turns[2]],
    }  # fmt: skip


@pytest.mark.parametrize("way", other_ways())
def test_a_demand_may_be_written_in_many_ways(grip, way):
    rope = ik.PointAnchor("dog/FL_FOOT", GRIP[1], at=(0.01, 0, 0), other_at=(0.1, 0, 0.1), name="r")
    plain = [ik.FrameAnchor(*GRIP, name="a"), rope]
    for changed, original in (
        (other_ways()[way], plain[:1]),
        ([*other_ways()[way], rope], plain),
        ([rope, *other_ways()[way]], plain),
    ):
        (v, wrench), (v_plain, wrench_plain) = grip(changed), grip(original)
        assert relative(v - v_plain, v_plain) < 1e-10
        assert relative(wrench - wrench_plain, wrench_plain) < 1e-10


# -- rows by themselves --------------------------------------------------------------------


@pytest.fixture(scope="module")
def rows():
    """Talos with both feet held: rows, half-solved rows, what they want, and what they do."""
    talos = ik.Robot.from_example("talos", root="freeflyer")
    q, v = random_state(talos, 3)
    feet = [ik.FrameAnchor("left_sole_link"), ik.FrameAnchor("right_sole_link")]
    impact = ik.solve(ik.Scene(talos, [random_blow(STRUCK["talos"], 1)], feet), q, v)
    matrix, masses = impact.mechanics.constraint_matrix, impact.mechanics.mass_matrix
    lower = np.linalg.cholesky(masses)
    free = v + np.linalg.solve(masses, impact.impulse_shares["impulses[0]"])

    def after(change):
        """(nv,) v⁺ for the rows changed (k, 12), and their resultant (nv,)."""
        changed = change @ matrix
        half = np.linalg.solve(lower, changed.T)
        right = -changed @ free
        names = [f"row {i}" for i in range(len(change))]

        def magnitude():
            return (np.abs(change) @ np.abs(matrix)) ** 2 @ (1 / np.diagonal(masses))

        def scale():
            return np.abs(changed) @ np.abs(free)

        found = Elimination(half, magnitude, names).solve(right, scale)
        total = found.impulse @ changed
        return free + np.linalg.solve(masses, total), total, found

    return after


def doubled():
    return np.vstack([np.eye(12)] * 2)


ROW_CHANGES = {
    "doubled": doubled(),
    "doubled and one of each scaled up": np.diag(np.repeat([1, 1e6], 12)) @ doubled(),
    "doubled and one of each scaled down": np.diag(np.repeat([1, 1e-6], 12)) @ doubled(),
    "scaled up": 1e6 * np.eye(12),
    "scaled down": 1e-6 * np.eye(12),
    "scaled one by one": np.diag(10.0 ** np.linspace(-6, 6, 12)),
    "with other signs": np.diag([-1.0, 1] * 6),
    "reordered": np.eye(12)[[7, 3, 11, 0, 5, 2, 9, 1, 10, 4, 8, 6]],
    "turned": np.kron(np.eye(4), pin.exp3(np.array([0.3, -1.2, 0.7]))),
    "mixed": np.random.default_rng(0).normal(size=(12, 12)),
    "mixed, three times as many": np.random.default_rng(1).normal(size=(36, 12)),
    "with rows that are zero": np.vstack([np.eye(12), np.zeros((3, 12))]),
}


@pytest.mark.parametrize("change", ROW_CHANGES)
def test_rows_may_be_changed_into_others_of_the_same_span(rows, change):
    v_plain, total_plain, plain = rows(np.eye(12))
    v, total, found = rows(ROW_CHANGES[change])
    assert plain.rank == found.rank == 12 and plain.unique is None
    assert relative(v - v_plain, v_plain) < 1e-10
    assert relative(total - total_plain, total_plain) < 1e-10
    if len(ROW_CHANGES[change]) > 12:
        assert found.unique is not None
        expected = (
            np.repeat([True, False], [12, 3]) if "zero" in change else np.zeros(1, dtype=bool)
        )
        assert (found.unique == expected).all()


def test_the_share_of_repeated_rows_is_the_least():
    """Of two like rows each takes half; of scaled ones, as much as in equal units."""
    half = np.array([[1.0, 1, 0], [0, 0, 2]])

    def share(factors):
        rows = Elimination(half * factors, lambda: (half**2).sum(axis=0) * factors**2, list("abc"))
        found = rows.solve(np.array([3.0, 3, 4]) * factors, lambda: np.ones(3) * factors)
        assert found.unique.tolist() == [False, False, True]
        return found.impulse * factors

    for factors in ([1.0, 1, 1], [1e6, 1, 1], [1, 1e-6, 1e6]):
        np.testing.assert_allclose(share(np.array(factors)), [1.5, 1.5, 1], rtol=1e-12)
