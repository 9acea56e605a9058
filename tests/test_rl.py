"""``Landing``: impacts of feet as torch functions, in the layouts of simulators."""

import numpy as np
import pytest

import impulsekit as ik

torch = pytest.importorskip("torch")
mujoco = pytest.importorskip("mujoco")

from impulsekit.mujoco import Impacts  # noqa: E402
from impulsekit.rl import OUTPUTS, Landing, Layout  # noqa: E402

# A trunk on one leg: hip about y, ball in the knee, a small foot.
LEG = """<mujoco><option gravity="0 0 0" timestep="{dt}"/><worldbody>
<geom name="floor" type="plane" size="9 9 .1" friction=".5"/>
<body name="trunk" pos="0 0 1"><freejoint name="root"/><geom type="box" size=".2 .1 .1" mass="5"
  contype="0" conaffinity="0"/>
<body name="thigh" pos=".1 0 -.1"><joint name="hip" axis="0 1 0" armature=".02"/>
<geom type="capsule" fromto="0 0 0 0 0 -.3" size=".03" mass="1" contype="0" conaffinity="0"/>
<body name="shank" pos="0 0 -.3"><joint name="knee" axis="1 0 0" armature=".01"/>
<geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02" mass=".5" contype="0" conaffinity="0"/>
<geom name="foot" type="sphere" pos="0 0 -.32" size="1e-9" mass=".1" friction=".5"/>
</body></body></body></worldbody></mujoco>"""


def leg(dt=0.002):
    return mujoco.MjModel.from_xml_string(LEG.format(dt=dt))


def states(count, seed=0):
    """qpos and qvel of the leg, its foot at the floor, falling."""
    random = np.random.default_rng(seed)
    model = leg()
    data = mujoco.MjData(model)
    rows = []
    for _ in range(count):
        turn = random.normal(size=4) * 0.2 + [1, 0, 0, 0]
        data.qpos[:] = [*random.normal(size=2), 1, *turn, *random.normal(size=2) * 0.4]
        data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
        mujoco.mj_kinematics(model, data)
        data.qpos[2] -= data.geom("foot").xpos[2]
        rows.append((data.qpos.copy(), random.normal(size=8) - [0, 0, 3, 0, 0, 0, 0, 0]))
    return tuple(torch.from_numpy(np.array(each)) for each in zip(*rows, strict=True))


def landing(outputs=OUTPUTS, dt=0.002, **given):
    return Landing.from_mujoco(
        leg(dt), ["foot"], restitution=0.2, friction=0.5, outputs=outputs,
        gear_stiffness={"hip": 500.0, "knee": 300.0}, **given,
    )  # fmt: skip


@pytest.mark.parametrize("dt", [0.0005, 0.01])
def test_it_is_the_impact_that_mujoco_finds_whatever_its_time_step(dt):
    q, v = states(6)
    found = landing(dt=dt)(q, v)
    assert torch.equal(found["impulse"], landing()(q, v)["impulse"])
    model = leg(dt)
    for i in range(6):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = q[i], v[i]
        data.qpos[2] += 2e-9
        impacts = Impacts(model, restitution=0.2, instant="step", threshold=0.0)
        impacts.step(data)
        hit = impacts.last[0]
        assert np.allclose(found["impulse"][i, 0], hit.impulses[0], atol=1e-6)
        assert found["lost_energy"][i] == pytest.approx(-hit.energy_change, abs=1e-6)
        for k, body in ((1, "thigh"), (2, "shank")):
            assert np.allclose(found["joint_impulse"][i, k], hit.joint_impulses[body], atol=1e-6)
        torque = np.abs(hit.dv[6:]) * np.sqrt([500 * 0.02, 300 * 0.01])
        assert np.allclose(found["gear_torque"][i], torque, atol=1e-6)


def test_a_ball_has_its_closed_forms():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    sole = ik.Contact("ball", at=[0, 0, -0.1], restitution=0.5, friction=10.0)
    mass, inertia = ball.model.inertias[1].mass, ball.model.inertias[1].inertia[0, 0]
    q = torch.tensor([[0, 0, 0.1, 1, 0, 0, 0]], dtype=torch.float64)
    v = torch.tensor([[1, 0, -2, 0, 0, 0]], dtype=torch.float64)
    found = Landing(ball, [sole])(q, v)
    across = mass * inertia / (inertia + mass * 0.01)
    assert np.allclose(found["impulse"][0, 0], [-across, 0, 3.0 * mass], rtol=1e-12)
    lost = 0.5 * mass * (4 - 1) + 0.5 * across
    assert found["lost_energy"].item() == pytest.approx(lost, rel=1e-12)


def test_the_layouts_are_one_state():
    q, v = states(5)
    model = leg()
    data, qs, vs, isaac = mujoco.MjData(model), [], [], []
    for i in range(5):
        data.qpos[:], data.qvel[:] = q[i], v[i]
        own_q, own_v = ik.mujoco_state(data)
        qs.append(own_q)
        vs.append(own_v)
        mujoco.mj_kinematics(model, data)
        turn = data.body("trunk").xmat.reshape(3, 3)
        isaac.append(np.concatenate([v[i, :3], turn @ v[i, 3:6].numpy(), v[i, 6:]]))
    first = landing()(q, v)
    second = landing(layout="pinocchio")(*(torch.from_numpy(np.array(x)) for x in (qs, vs)))
    third = landing(layout="isaac")(q, torch.from_numpy(np.array(isaac)))
    swapped = Layout("mujoco", ["root", "knee", "hip"])
    order_q, order_v = [*range(7), 8, 7], [*range(6), 7, 6]
    fourth = landing(layout=swapped)(q[:, order_q], v[:, order_v])
    for name, value in first.items():
        for other in (second, third, fourth):
            assert torch.allclose(value.double(), other[name].double(), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("layout", ["mujoco", "isaac"])
def test_gradients_are_those_of_differences(layout):
    q, v = (each.requires_grad_() for each in states(4))
    own = landing(("impulse", "lost_energy", "gear_torque"), layout=layout)
    for name in own.outputs:
        assert torch.autograd.gradcheck(
            lambda a, b, name=name: own(a, b)[name], (q, v), eps=1e-6, atol=1e-7, rtol=1e-7
        )


def test_the_gap_weighs_before_touch_down():
    q, v = states(3)
    lifted = q.clone()
    lifted[:, 2] += 0.1
    own = landing(("lost_energy", "impulse"))
    touching, above = own(q, v), own(lifted, v, gap=0.05)
    assert torch.allclose(above["lost_energy"], np.exp(-2.0) * touching["lost_energy"], rtol=1e-4)
    assert torch.allclose(above["impulse"], np.exp(-2.0) * touching["impulse"], rtol=1e-4)


def test_a_foot_of_a_body_without_a_name():
    text = LEG.format(dt=0.002).replace('body name="shank"', "body")
    own = Landing.from_mujoco(mujoco.MjModel.from_xml_string(text), ["foot"], restitution=0.2)
    assert own.scene.contacts[0].frame == "body_3"
    named = Landing.from_mujoco(leg(), ["foot"], restitution=0.2)
    q, v = states(2)
    assert torch.equal(own(q, v)["impulse"], named(q, v)["impulse"])


def test_rows_that_are_no_states_are_marked():
    q, v = states(3)
    v[1, 0] = torch.nan
    found = landing(("lost_energy",))(q.float(), v.float())
    assert found["lost_energy"].dtype == torch.float32
    assert found["valid"].tolist() == [True, False, True]
    assert found["lost_energy"].isnan().tolist() == [False, True, False]


Q, V = torch.zeros(2, 9), torch.zeros(2, 8)


@pytest.mark.parametrize(
    ("called", "error", "words"),
    [
        (lambda: Landing("leg", ["foot"]), "InputError", "robot"),
        (lambda: Landing(ROBOT, []), "InputError", "feet"),
        (lambda: Landing(ROBOT, "shank"), "InputError", "feet must be a list"),
        (lambda: Landing(ROBOT, ["shnk"]), "UnknownNameError", 'did you mean "shank"'),
        (lambda: Landing(ROBOT, ["shank"], restitution=2.0), "RangeError", "0 to 1"),
        (lambda: Landing(ROBOT, ["shank"], layout="mujco"), "UnknownNameError", "mujoco"),
        (lambda: Landing(ROBOT, ["shank"], outputs=["torque"]), "UnknownNameError", "gear_torque"),
        (lambda: Landing(ROBOT, ["shank"], outputs=OUTPUTS), "InputError", "gear_stiffness"),
        (lambda: gears({"hip": 100.0}, BARE), "InputError", "rotor inertia .* unknown"),
        (lambda: gears({"hipp": 100.0}), "UnknownNameError", 'did you mean "hip"'),
        (lambda: gears({"root": 100.0}), "InputError", "degrees of freedom"),
        (lambda: gears({"hip": 0.0}), "RangeError", "above"),
        (lambda: Landing(ROBOT, ["shank"], layout=Layout("isaac", ["hip"])), "InputError", "once"),
        (lambda: Landing.from_mujoco(leg(), ["fot"]), "UnknownNameError", 'did you mean "foot"'),
        (lambda: landing()(Q[:, :8], V), "ShapeError", "q: expected shape"),
        (lambda: landing()(Q, V[:1]), "ShapeError", "v: expected shape"),
        (lambda: landing()(Q.numpy(), V), "InputError", "torch tensor"),
        (lambda: landing()(*states(2), gap=0.0), "RangeError", "gap"),
    ],
)
def test_what_cannot_be_is_one_clear_error(called, error, words):
    with pytest.raises(getattr(ik.errors, error), match=words):
        called()


ROBOT = ik.Robot.from_mjcf(leg())
BARE = ik.Robot.from_mjcf(LEG.format(dt=0.002).replace("armature", 'user="0" damping'))


def gears(stiffness, robot=ROBOT):
    return Landing(robot, ["shank"], outputs=["gear_torque"], gear_stiffness=stiffness)
