"""Design measures against closed forms and against solved impacts."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.design import (
    centre_of_percussion,
    effective_mass,
    impact_ellipsoid,
    least_blow,
    plot_effective_mass,
    plot_sparing,
    reaction_map,
    spare_joint,
    worst_blow,
)
from impulsekit.models import pendulum_urdf
from tests.robots import random_state


def panda():
    return ik.Robot.from_example("panda")


def test_effective_mass_is_one_over_the_mobility():
    robot = panda()
    q, _ = random_state(robot, 1)
    found = impact_ellipsoid(robot, q, "panda_hand", at=[0.01, 0.02, 0.1])
    mechanics = ik.solve(ik.Scene(robot), q, robot.velocity()).mechanics
    jacobian = mechanics.point_jacobian("panda_hand", np.array([0.01, 0.02, 0.1]))[:3]
    mobility = jacobian @ np.linalg.solve(mechanics.mass_matrix, jacobian.T)
    rng = np.random.default_rng(0)
    for n in rng.normal(size=(5, 3)):
        unit = n / np.linalg.norm(n)
        assert found.effective_mass(n) == pytest.approx(1 / (unit @ mobility @ unit), rel=1e-10)
    for axis, mass in zip(found.axes.T, found.masses, strict=True):
        assert mobility @ axis == pytest.approx(axis / mass, rel=1e-9, abs=1e-12)
    assert (np.diff(found.masses) <= 0).all()


def test_effective_mass_against_solved_blows_under_constraints():
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    q, _ = random_state(solo, 2)
    hold = [ik.PointAnchor("FL_FOOT", velocity=[1, 2, 3]), ik.JointLock("FR_KFE")]
    scene = ik.Scene(solo, constraints=hold)
    n = np.array([0.3, -0.5, 0.8])
    n /= np.linalg.norm(n)
    mass = effective_mass(scene, q, "HR_FOOT", n)
    still = [ik.PointAnchor("FL_FOOT"), ik.JointLock("FR_KFE")]
    struck = ik.Scene(solo, [ik.AppliedImpulse("HR_FOOT", linear=n)], still)
    impact = ik.solve(struck, q, solo.velocity())
    assert n @ impact.velocity_at("HR_FOOT").after == pytest.approx(1 / mass, rel=1e-9)


def test_the_sweet_spot_of_a_uniform_rod_is_at_two_thirds():
    rod = ik.Robot.from_urdf(pendulum_urdf(1))
    for angle in (0.0, 0.7):
        found = centre_of_percussion(rod, [angle], "joint_1")
        assert found.at == pytest.approx([0, 0, -2 / 3], abs=1e-12)
        assert found.share < 1e-12


def test_the_centre_of_percussion_in_a_chain_spares_the_joint_when_struck():
    rods = ik.Robot.from_urdf(pendulum_urdf(3))
    q = [0.3, -0.5, 0.9]
    found = centre_of_percussion(rods, q, "joint_2", "link_2")
    blow = ik.AppliedImpulse("link_2", linear=found.direction, at=found.at)
    reaction = ik.solve(ik.Scene(rods, [blow]), q, np.zeros(3)).reactions["joint_2"]
    assert np.linalg.norm(reaction[:3]) == pytest.approx(found.share, abs=1e-12)
    for shift in (-0.01, 0.01):
        at = found.at + np.array([0, 0, shift])
        near = ik.AppliedImpulse("link_2", linear=found.direction, at=at)
        other = ik.solve(ik.Scene(rods, [near]), q, np.zeros(3)).reactions["joint_2"]
        assert np.linalg.norm(other[:3]) > found.share


def test_worst_and_kindest_directions_bound_all_others():
    robot = panda()
    q, _ = random_state(robot, 4)
    for kind, rows in (("force", slice(0, 3)), ("couple", slice(3, 6))):
        found = worst_blow(robot, q, "panda_joint2", "panda_hand", kind=kind)
        for n in [*np.random.default_rng(1).normal(size=(6, 3)), found.direction, found.kindest]:
            unit = n / np.linalg.norm(n)
            scene = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=unit)])
            borne = ik.solve(scene, q, robot.velocity()).reactions["panda_joint2"][rows]
            assert found.kindest_share - 1e-9 <= np.linalg.norm(borne) <= found.share + 1e-9
        assert np.linalg.norm(borne) == pytest.approx(found.kindest_share, abs=1e-9)


def test_the_least_blow_gives_what_is_wanted():
    robot = panda()
    q, _ = random_state(robot, 5)
    wanted = [0.1, -0.2, 0.3]
    found = least_blow(robot, q, wanted, "panda_hand", of="panda_link5")
    impact = ik.solve(ik.Scene(robot, [found.blow]), q, robot.velocity())
    assert impact.velocity_at("panda_link5").after == pytest.approx(wanted, abs=1e-9)
    assert impact.dv == pytest.approx(found.dv, abs=1e-10)
    assert found.shortfall < 1e-9
    # A generalized velocity is out of the reach of one blow but for its own image.
    whole = least_blow(robot, q, frame="panda_hand", wanted_dv=found.dv)
    assert whole.blow.linear == pytest.approx(found.blow.linear, rel=1e-6, abs=1e-9)
    assert (
        least_blow(robot, q, frame="panda_hand", wanted_dv=robot.velocity() + 1.0).shortfall > 0.1
    )


def test_pictures_take_and_return_axes():
    pytest.importorskip("matplotlib").use("Agg")
    from matplotlib.figure import Figure

    rod = ik.Robot.from_urdf(pendulum_urdf(2))
    ax = Figure().subplots()
    q = [0.4, 0.3]
    found = impact_ellipsoid(rod, q, "link_2", [0, 0, -1])
    assert plot_effective_mass(found, "xz", ax) is ax
    line = ("joint_2", "link_2", [0, 0, 0], [0, 0, -1], [1, 0, 0])
    assert plot_sparing(rod, q, *line, ax=ax) is ax
    assert len(ax.lines) == 4


HOLDS = {
    "every joint locked": [ik.JointLock(f"joint_{k}") for k in (1, 2, 3)],
    "welded to the world": [ik.FrameAnchor("link_3")],
    "pinned and locked": [ik.PointAnchor("link_1", at=[0, 0, -1]), ik.FrameAnchor("link_3")],
}


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("holds", HOLDS.values(), ids=HOLDS)
def test_what_a_scene_holds_fast_has_infinite_mass_and_no_least_blow(holds, scale):
    rods = ik.Robot.from_urdf(pendulum_urdf(3, mass=scale))
    scene = ik.Scene(rods, constraints=holds)
    for q in ([0, 0, 0], [0.3, -0.5, 0.8]):
        for direction in ([1, 0, 0], [0, 0, 1], [1, 2, 3]):
            assert effective_mass(scene, q, "link_3", direction, at=[0, 0, -1]) == np.inf
        assert (impact_ellipsoid(scene, q, "link_3").masses == np.inf).all()
        with pytest.raises(ik.errors.InputError, match="cannot move"):
            least_blow(scene, q, [1, 0, 0], "link_3", at=[0, 0, -1])


def test_with_three_joints_the_name_says_what_is_wanted():
    rods, q = ik.Robot.from_urdf(pendulum_urdf(3)), [0.3, -0.5, 0.8]
    velocity = least_blow(rods, q, wanted_velocity=[0.5, 0, 0], frame="link_3", at=[0, 0, -1])
    change = least_blow(rods, q, wanted_dv=[0.5, 0, 0], frame="link_3", at=[0, 0, -1])
    after = [ik.solve(ik.Scene(rods, [found.blow]), q, np.zeros(3)) for found in (velocity, change)]
    tip = after[0].velocity_at("link_3", (0, 0, -1)).after
    assert tip[0] == pytest.approx(0.5, abs=1e-12)
    np.testing.assert_allclose(after[1].dv, change.reached, atol=1e-12)
    assert np.abs(velocity.dv - change.dv).max() > 0.1
    with pytest.raises(ik.errors.InputError, match="not both"):
        least_blow(rods, q, [0, 0, 1], "link_3", wanted_dv=[0, 0, 1])
    with pytest.raises(ik.errors.InputError, match="wanted_velocity="):
        least_blow(rods, q, frame="link_3")


def test_the_best_direction_is_no_worse_than_any():
    robot = panda()
    q, _ = random_state(robot, 3)
    line = ([0, 0, 0], [0, 0, 0.2])
    free = spare_joint(robot, q, "panda_joint4", "panda_hand", *line)
    assert 0.0 <= free.along <= 1.0
    rng = np.random.default_rng(0)
    for n, s in zip(rng.normal(size=(9, 3)), np.linspace(0, 1, 9), strict=True):
        table = reaction_map(robot, q, "panda_joint4", "panda_hand", [0, 0, 0.2 * s])
        borne = table[:3, :3] @ n / np.linalg.norm(n)
        assert np.linalg.norm(borne) >= free.share
