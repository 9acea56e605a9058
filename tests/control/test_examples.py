"""Examples of optimal control across impacts, and the closed forms behind them."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import impulsekit as ik

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
EXAMPLES = Path(__file__).parents[2] / "examples"
GRAVITY = 9.81
RAM = """<robot name="ram"><link name="rail"/><link name="ram"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="fall" type="prismatic"><parent link="rail"/><child link="ram"/><axis xyz="0 0 1"/>
<limit lower="-10" upper="10" effort="1e9" velocity="1e9"/></joint></robot>"""


def ran(name):
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


def test_a_ram_drives_a_nail_as_deep_as_a_mass_on_dry_friction():
    ram, nail = ik.Robot.from_urdf(RAM), ik.Robot.from_urdf("models/nail.urdf")
    world, wood, speed = ik.combine(ram=ram, nail=nail), 400.0, 3.0
    blow = ik.Contact("ram/ram", against="nail/nail", name="blow")
    friction = ik.JointFriction("nail/driven", wood)
    scene = ik.Scene(world, contacts=[blow], forces=[friction], gravity=(0, 0, 0))
    start = world.velocity({"ram/fall": -speed})
    motion = ik.simulate(scene, world.configuration(), start, duration=0.1)
    both = 2.0 + nail.mass
    depth = both * (2.0 * speed / both) ** 2 / (2.0 * wood)
    assert motion.q[-1, 1] == pytest.approx(depth, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("bound", [0.2, 0.4])
def test_the_blow_on_a_nail_keeps_to_the_bound_of_the_joints(bound):
    pytest.importorskip("casadi")
    names = ran("nail_by_a_panda")
    q, v = names["planned"](bound)
    loads = ik.solve(names["scene"], q, v).joint_loads
    most = max(np.linalg.norm(loads[name].moment) for name in names["arm"].joint_names)
    # The bound is what holds the blow back.
    assert most == pytest.approx(bound, rel=1e-6)


@pytest.mark.slow
def test_a_catch_spares_the_joints():
    pytest.importorskip("casadi")
    names = ran("catch_by_a_panda")
    most = [
        names["most_loaded"](ik.solve(names["scene"], names["q"], v))[1]
        for v in (names["flying"], names["sparing"]())
    ]
    assert most[1] < 0.5 * most[0]


def test_the_bouncing_ball_of_the_saltation_tutorial():
    """Ξ = ((−e, 0), (−(1 + e) g/v⁻, −e)) on (z, ż), Kong et al. 2024."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    fall = [0, 0, -GRAVITY, 0, 0, 0]
    for e, speed in ((0.8, -2.0), (0.5, -0.3), (1.0, -7.0)):
        scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=e, name="floor")])
        impact = ik.solve(scene, ball.neutral(), [0, 0, speed, 0, 0, 0])
        found = ik.saltation(impact, "floor", acceleration_before=fall, acceleration_after=fall)
        wanted = [[-e, 0.0], [-(1.0 + e) * GRAVITY / speed, -e]]
        assert np.abs(found.matrix[np.ix_([2, 8], [2, 8])] - wanted).max() < 1e-10


def test_ilqr_across_an_impact_has_the_gradient_of_differences_and_converges():
    names = ran("planned_bounce")
    thrusts, costs = names["planned"]()
    assert costs[-1] < 0.6783

    def gradient(thrusts):
        states, As, Bs, _ = names["rolled"](thrusts)
        value, found = names["END"] @ (states[-1] - names["GOAL"]), []
        for A, B, thrust in zip(As[::-1], Bs[::-1], thrusts[::-1], strict=True):
            found.append(names["EFFORT"] * thrust + B.T @ value)
            value = A.T @ value
        return np.array(found[::-1])

    assert np.abs(gradient(thrusts)).max() < 1e-8
    moved = thrusts + 0.1 * np.random.default_rng(0).normal(size=thrusts.shape)
    ours, h = gradient(moved), 1e-5
    for at in ((0, 0), (5, 1), (20, 0), (45, 1)):
        unit = np.zeros_like(moved)
        unit[at] = h
        ends = [names["rolled"](moved + s * unit)[3] for s in (1, -1)]
        assert ours[at] == pytest.approx((ends[0] - ends[1]) / (2 * h), rel=1e-6, abs=1e-8)


def test_bounces_scanned_mapped_and_compiled_by_jax():
    jax = pytest.importorskip("jax")
    from impulsekit.jax import solve

    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", at=[0, 0, -0.05], friction=0.05)])

    def distance(v, e):
        """How far a ball gets in ten bounces."""

        def bounce(v, _):
            after = solve(scene, ball.neutral(), v, restitution=e)
            time = 2.0 * after[2] / GRAVITY
            return after.at[2].add(-GRAVITY * time), after[0] * time

        return jax.lax.scan(bounce, v, None, length=10)[1].sum()

    with jax.enable_x64(True):
        slope = jax.value_and_grad(distance, argnums=(0, 1))
        V = np.array([3.0, 0.1, -4, 0, 5, 0]) + 0.1 * np.random.default_rng(0).normal(size=(3, 6))
        far, (by_v, by_e) = jax.jit(jax.vmap(slope, in_axes=(0, None)))(V, 0.8)
        for i, v in enumerate(V):
            one, (own_v, own_e) = slope(v, 0.8)
            np.testing.assert_allclose(far[i], one, rtol=1e-14)
            np.testing.assert_allclose(by_v[i], own_v, rtol=1e-12, atol=1e-13)
            np.testing.assert_allclose(by_e[i], own_e, rtol=1e-12)
        h, direction = 1e-5, np.array([0.3, -0.2, 0.4, 0.1, 0.5, 0.2])
        ends = [distance(V[0] + s * h * direction, 0.8) for s in (1, -1)]
        np.testing.assert_allclose(by_v[0] @ direction, (ends[0] - ends[1]) / (2 * h), rtol=1e-7)
        ends = [distance(V[0], 0.8 + s * h) for s in (1, -1)]
        np.testing.assert_allclose(by_e[0], (ends[0] - ends[1]) / (2 * h), rtol=1e-7)
