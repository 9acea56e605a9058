"""Impacts inside MuJoCo: the laws hold at each, and nothing else of a simulation changes."""

import mujoco
import numpy as np
import pytest

import impulsekit as ik
from impulsekit.mujoco import Impacts

FLOOR = '<geom name="floor" type="plane" size="9 9 .1" condim="1" friction="{mu} 0.01 0.002"/>'
BALL = (
    '<body name="ball" pos="{at}"><freejoint/>'
    '<geom name="ball" size=".1" mass="1" condim="{condim}" friction="{mu} 0.01 0.002"/></body>'
)
BOX = (
    '<body name="{name}" pos="{at}"><freejoint/>'
    '<geom name="{name}" type="box" size=".1 .1 .1" mass="1" friction="0.3"/></body>'
)
ARM = """<body name="upper" pos="0 0 .5"><joint name="a" type="hinge" axis="0 1 0" armature=".02"/>
<geom type="capsule" fromto="0 0 0 .4 0 0" size=".02" mass="1" contype="0" conaffinity="0"/>
<body name="lower" pos=".4 0 0"><joint name="b" type="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .4 0 0" size=".02" mass="1" contype="0" conaffinity="0"/>
<body name="tip" pos=".4 0 0"><geom name="tip" size=".03" mass=".2" friction=".4"/></body>
</body></body>"""


def made(bodies, option='integrator="RK4" timestep="0.002"', extra="", mu=0.3):
    text = f"<mujoco><option {option}/><worldbody>{FLOOR.format(mu=mu)}{bodies}</worldbody>{extra}"
    model = mujoco.MjModel.from_xml_string(f"{text}</mujoco>")
    return model, mujoco.MjData(model)


def stepped_to_impact(impacts, data, most=2000):
    for _ in range(most):
        impacts.step(data)
        if impacts.last:
            return impacts.last[0]
    raise AssertionError("nothing hit anything")


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
@pytest.mark.parametrize("condim", [1, 3, 4, 6])
@pytest.mark.parametrize("integrator", ["RK4", "Euler", "implicitfast"])
def test_the_separation_speed_is_e_times_the_approach_speed(cone, condim, integrator):
    option = f'integrator="{integrator}" cone="{cone}" timestep="0.003"'
    model, data = made(BALL.format(at="0 0 .5", condim=condim, mu=0.3), option)
    data.qvel[:] = [1, 0.5, -1, 3, -2, 5]
    hit = stepped_to_impact(Impacts(model, restitution=0.7), data)
    assert hit.status is ik.Status.SOLVED
    assert hit.pairs == (("floor", "ball"),)
    assert np.allclose(hit.separation, 0.7 * hit.approach, rtol=1e-13)
    tangential = np.linalg.norm(hit.impulses[0, :2])
    assert (tangential == 0.0) == (condim == 1)
    assert (np.abs(hit.moments).max() > 0.0) == (condim > 3)
    assert hit.energy_change < 0.0


@pytest.mark.parametrize("dt", [0.0005, 0.002, 0.01])
def test_each_bounce_keeps_e_squared_of_the_energy(dt):
    option = f'integrator="RK4" timestep="{dt}"'
    model, data = made(BALL.format(at="0 0 .6", condim=3, mu=0.3), option)
    impacts = Impacts(model, restitution=0.8)
    log = impacts.log()
    while len(log) < 10:
        impacts.step(data)
    approach = np.array([hit.approach[0] for hit in log])
    assert np.allclose(approach[0] ** 2, 2 * 9.81 * 0.5, rtol=1e-9)
    assert np.allclose((approach[1:] / approach[:-1]) ** 2, 0.64, rtol=2e-9)


def test_a_sphere_that_must_stick_rolls_on():
    option = 'gravity="0 0 0" timestep="0.002"'
    model, data = made(BALL.format(at="0 0 .1005", condim=3, mu=0.3), option)
    data.qvel[:3] = 2, 0, -3
    Impacts(model, restitution=0.6).step(data)
    assert np.allclose(data.qvel, [10 / 7, 0, 1.8, 0, 100 / 7, 0], atol=1e-9)


def test_a_box_lands_flat_in_one_impact_of_four_contacts():
    model, data = made(BOX.format(name="box", at="0 0 .3"))
    impacts = Impacts(model, restitution=0.5)
    hit = stepped_to_impact(impacts, data)
    assert len(hit.pairs) == 4
    assert np.allclose(hit.separation, 0.5 * hit.approach, rtol=1e-12)
    assert hit.impulses[:, 2].sum() == pytest.approx(1.5 * hit.approach[0], rel=1e-12)


@pytest.mark.parametrize("integrator", ["RK4", "Euler", "implicit", "implicitfast"])
def test_boxes_at_rest_keep_every_bit(integrator):
    boxes = "".join(
        BOX.format(name=n, at=f"0 0 {0.0999 + 0.1999 * i}") for i, n in enumerate("abc")
    )
    model, data = made(boxes, f'integrator="{integrator}" timestep="0.002"')
    plain, impacts = mujoco.MjData(model), Impacts(model, restitution=0.5)
    for _ in range(500):
        impacts.step(data)
        mujoco.mj_step(model, plain)
        assert not impacts.last
    assert np.array_equal(data.qpos, plain.qpos)
    assert np.array_equal(data.qvel, plain.qvel)
    assert data.time == plain.time


def test_a_slow_touch_is_left_to_mujoco_to_the_bit():
    model, data = made(BOX.format(name="box", at="0 0 .1001"), 'timestep="0.002"')
    plain, impacts = mujoco.MjData(model), Impacts(model, restitution=0.5, threshold=0.2)
    for _ in range(200):
        impacts.step(data)
        mujoco.mj_step(model, plain)
        assert not impacts.last
    assert np.array_equal(data.qpos, plain.qpos)


def test_a_row_of_balls_passes_the_blow_on():
    bodies = "".join(
        f'<body pos="{x} 0 1"><joint type="slide" axis="1 0 0"/><geom size=".1" mass="1"/></body>'
        for x in (-0.5, 0.0, 0.2)
    )
    model, data = made(bodies, 'gravity="0 0 0" integrator="RK4"')
    data.qvel[0] = 1.0
    impacts = Impacts(model, restitution=1.0, law=ik.Law(order="sequential"))
    for _ in range(400):
        impacts.step(data)
    assert np.allclose(data.qvel, [0, 0, 1], atol=1e-9)


@pytest.mark.parametrize("law", [ik.Law(), ik.Law("poisson"), ik.Law("stronge", slip="path")])
def test_an_arm_hits_as_in_a_scene_of_impulsekit(law):
    model, data = made(ARM, mu=0.4)
    data.qpos[:], data.qvel[:] = [0.6, -0.9], [3, -1]
    impacts = Impacts(model, restitution=0.5, law=law)
    hit = stepped_to_impact(impacts, data)
    robot = ik.Robot.from_mjcf(model)
    q = robot.configuration(a=hit.qpos[0], b=hit.qpos[1])
    # The contact is the sphere's lowest point, not its centre.
    lowest = robot.placement(q, "tip").rotation.T @ [0, 0, -0.03]
    contact = ik.Contact("tip", at=lowest, restitution=0.5, friction=0.4)
    scene = ik.Scene(robot, contacts=[contact], law=law)
    impact = ik.solve(scene, q, robot.velocity(a=hit.qvel[0], b=hit.qvel[1]))
    assert np.allclose(hit.dv, impact.dv, rtol=0, atol=1e-8)
    assert np.allclose(hit.impulses[0], impact.contacts[0].impulse, atol=1e-8)
    assert np.allclose(hit.joint_impulses["upper"], impact.reactions["a"], atol=1e-8)
    assert np.allclose(hit.joint_impulses["lower"], impact.reactions["b"], atol=1e-8)


def test_a_limit_gives_back_e_times_the_speed():
    rod = """<body name="rod" pos="0 0 1"><joint name="hinge" type="hinge" axis="0 1 0"
    range="-30 30" limited="true"/>
    <geom type="capsule" fromto="0 0 0 0 0 -.4" size=".02"/></body>"""
    model, data = made(rod, 'gravity="0 0 0" integrator="RK4"')
    data.qvel[0] = 4.0
    hit = stepped_to_impact(Impacts(model, restitution=0.0, limits=0.6), data)
    assert hit.limits == ("hinge",)
    assert len(hit.pairs) == 0
    assert hit.limit_impulses[0] > 0.0
    assert hit.time == pytest.approx(np.deg2rad(30) / 4.0, abs=1e-10)
    assert data.qvel[0] == pytest.approx(-0.6 * 4.0, rel=1e-12)


def test_a_loop_stays_closed():
    bodies = BOX.format(name="a", at="-.3 0 .5") + BOX.format(name="b", at=".3 0 .5")
    weld = '<equality><connect body1="a" body2="b" anchor=".3 0 0"/></equality>'
    model, data = made(bodies, extra=weld)
    impacts = Impacts(model, restitution=0.5)
    data.qvel[4] = 1.0
    hit = stepped_to_impact(impacts, data)
    data.qpos[:] = hit.qpos
    mujoco.mj_fwdPosition(model, data)
    point = data.xpos[1] + data.xmat[1].reshape(3, 3) @ [0.3, 0, 0]
    jacobians = np.zeros((2, 3, model.nv))
    for body, to in ((1, jacobians[0]), (2, jacobians[1])):
        # The second body's point is where it is, which MuJoCo's soft loop lets drift a little.
        at = point if body == 1 else data.xpos[2] + data.xmat[2].reshape(3, 3) @ [-0.3, 0, 0]
        mujoco.mj_jac(model, data, to, None, at, body)
    apart = (jacobians[0] - jacobians[1]) @ hit.dv
    assert np.abs(apart).max() < 1e-12 * np.abs(jacobians[0] @ hit.dv).max()
    with pytest.raises(ik.errors.InputError, match="equality"):
        _ = hit.joint_impulses


@pytest.mark.parametrize(
    "law",
    [
        ik.Law("poisson"),
        ik.Law("newton", order="sequential"),
        ik.Law("poisson", order="sequential"),
    ],
)
def test_a_tumbling_box_never_gains_energy_and_comes_to_rest(law):
    random = np.random.default_rng(1)
    for _ in range(4):
        model, data = made(BOX.format(name="box", at="0 0 .5"), mu=0.5)
        data.qvel[:] = random.normal(size=6) * [1, 1, 1, 4, 4, 4]
        impacts = Impacts(model, restitution=0.4, law=law)
        log = impacts.log()
        for _ in range(1500):
            impacts.step(data)
        assert len(log) > 3
        assert max(hit.energy_change for hit in log) < 1e-12
        assert data.qpos[2] == pytest.approx(0.1, abs=1e-3)
        assert np.abs(data.qvel).max() < 1e-6


def test_the_impulse_at_the_start_of_the_step_keeps_e():
    model, data = made(BOX.format(name="box", at="0 0 .3"), 'timestep="0.004"')
    hit = stepped_to_impact(Impacts(model, restitution=0.5, instant="step"), data)
    assert np.allclose(hit.separation, 0.5 * hit.approach, rtol=1e-12)
    assert len(hit.pairs) == 4


def two_balls(heights, speeds, extra=""):
    """Balls above the floor that touch it at different times of one step of 10 ms."""
    balls = "".join(
        f'<body pos="{i} 0 {0.1 + z}"><freejoint/><geom size=".1" mass="1" {extra}/></body>'
        for i, z in enumerate(heights)
    )
    model, data = made(balls, 'gravity="0 0 0" integrator="RK4" timestep="0.01"')
    data.qvel[[2, 8]] = speeds
    return model, data


def test_each_contact_of_a_step_hits_at_its_own_time():
    model, data = two_balls((0.002, 0.006), (-1.0, -1.0))
    impacts = Impacts(model, restitution=0.5)
    impacts.step(data)
    assert np.allclose([hit.time for hit in impacts.last], [0.002, 0.006], atol=1e-10)
    assert np.allclose(data.qpos[[2, 9]] - 0.1, [0.004, 0.002], atol=1e-8)
    assert np.allclose(data.qvel[[2, 8]], 0.5, rtol=1e-9)


def test_a_slow_touch_hides_no_later_impact_of_the_step():
    model, data = two_balls((0.0001, 0.006), (-0.1, -1.0))
    impacts = Impacts(model, restitution=0.5, threshold=0.2)
    impacts.step(data)
    assert [hit.time for hit in impacts.last] == [pytest.approx(0.006, abs=1e-10)]


def test_contacts_that_the_gap_lists_before_they_touch_hit():
    model, data = two_balls((0.006, 0.006), (-1.0, -1.0), 'gap="0.01"')
    assert model.geom_gap.max() == 0.01
    impacts = Impacts(model, restitution=0.5)
    impacts.step(data)
    assert np.allclose(data.qvel[[2, 8]], 0.5, rtol=1e-9)


def test_a_state_that_was_set_anew_is_looked_at_anew():
    model, data = made(BALL.format(at="0 0 .6", condim=3, mu=0.3))
    impacts = Impacts(model, restitution=0.5)
    first = stepped_to_impact(impacts, data)
    mujoco.mj_resetData(model, data)
    again = stepped_to_impact(impacts, data)
    assert again.time == first.time
    assert np.array_equal(again.impulses, first.impulses)


@pytest.mark.parametrize(
    ("given", "e"),
    [
        ({"restitution": {"ball": 0.3}}, 0.3),
        ({"restitution": {"ball": 0.3, "floor": 0.9}}, 0.9),
        ({"restitution": {"ball": 0.3, "floor": 0.9}, "combine": "min"}, 0.3),
        ({"restitution": {"ball": 0.3, "floor": 0.9}, "combine": "average"}, 0.6),
        ({"restitution": {"ball": 0.3, "floor": 0.9}, "combine": "multiply"}, 0.27),
        ({"restitution": {"ball": 0.3, ("floor", "ball"): 0.1}}, 0.1),
        ({"restitution": ik.RestitutionTable([0, 10], [1.0, 0.0])}, None),
    ],
)
def test_the_restitution_of_a_pair(given, e):
    model, data = made(BALL.format(at="0 0 .6", condim=3, mu=0.3))
    hit = stepped_to_impact(Impacts(model, **given), data)
    expected = 1.0 - hit.approach[0] / 10 if e is None else e
    assert hit.restitution[0] == pytest.approx(expected, rel=1e-12)
    assert hit.separation[0] == pytest.approx(expected * hit.approach[0], rel=1e-12)


def test_the_restitution_in_the_file():
    ball = BALL.replace('mass="1"', 'mass="1" user="0.35"')
    model, data = made(ball.format(at="0 0 .6", condim=3, mu=0.3))
    assert stepped_to_impact(Impacts(model, "user"), data).restitution[0] == 0.35


def test_pairs_that_are_left_out_are_mujocos():
    boxes = BOX.format(name="a", at="0 0 .4") + BOX.format(name="b", at="1 0 .4")
    model, data = made(boxes)
    impacts = Impacts(model, restitution=0.5, pairs=["a"])
    log = impacts.log()
    for _ in range(300):
        impacts.step(data)
    assert {pair for hit in log for pair in hit.pairs if "b" in pair} <= {("floor", "b")}
    assert all(("floor", "a") in hit.pairs for hit in log)


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"restitution": 1.5}, ik.errors.RangeError, "0 to 1"),
        ({"restitution": {"bal": 0.5}}, ik.errors.UnknownNameError, 'did you mean "ball"'),
        ({"restitution": "users"}, ik.errors.InputError, '"user"'),
        ({"restitution": "user"}, ik.errors.InputError, "user="),
        ({"restitution": 0.5, "combine": "mean"}, ik.errors.RangeError, '"average"'),
        ({"restitution": 0.5, "friction": -1.0}, ik.errors.RangeError, "friction"),
        ({"restitution": 0.5, "threshold": -1.0}, ik.errors.RangeError, "threshold"),
        ({"restitution": 0.5, "instant": "late"}, ik.errors.RangeError, '"exact"'),
        ({"restitution": 0.5, "law": "poisson"}, ik.errors.InputError, "Law"),
        ({"restitution": 0.5, "law": ik.Law("lzb")}, ik.errors.InputError, "stiffness"),
        ({"restitution": 0.5, "limits": 2.0}, ik.errors.RangeError, "limits"),
        ({"restitution": 0.5, "pairs": ["nobody"]}, ik.errors.UnknownNameError, "nobody"),
    ],
)
def test_what_cannot_be_is_refused(given, error, words):
    model, _ = made(BALL.format(at="0 0 .6", condim=3, mu=0.3))
    with pytest.raises(error, match=words):
        Impacts(model, **given)


def test_data_of_another_model_is_refused_and_unchanged():
    model, _ = made(BALL.format(at="0 0 .6", condim=3, mu=0.3))
    _, other = made(ARM)
    before = other.qpos.copy()
    with pytest.raises(ik.errors.ShapeError, match="data"):
        Impacts(model, 0.5).step(other)
    assert np.array_equal(other.qpos, before)
    with pytest.raises(ik.errors.InputError, match="Impacts"):
        Impacts("scene.xml", 0.5)


@pytest.mark.parametrize("flag", ["sleep", "speculative"])
def test_flags_that_cannot_be_are_refused(flag):
    model, _ = made(BALL.format(at="0 0 .6", condim=3, mu=0.3))
    model.opt.enableflags |= int(getattr(mujoco.mjtEnableBit, f"mjENBL_{flag.upper()}"))
    with pytest.raises(ik.errors.InputError, match=flag):
        Impacts(model, 0.5)
