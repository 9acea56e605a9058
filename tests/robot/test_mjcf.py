"""MJCF, compiled by MuJoCo: mass matrix, places and speeds of the model are MuJoCo's own."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import (
    AssumptionWarning,
    MjcfError,
    SetupWarning,
    ShapeError,
    UnknownNameError,
)

mujoco = pytest.importorskip("mujoco")
truth = pytest.importorskip("tests.robot.mujoco_truth")


def mjcf(body, more=""):
    return f"<mujoco>{more}<worldbody>{body}</worldbody></mujoco>"


BALL = "<geom size='.1'/>"
ROD = "<geom type='capsule' size='.03' fromto='0 0 0 .1 .2 .5'/>"
TEXTS = {
    "two trees": mjcf(
        f"<body name='a'><joint axis='0 1 0'/>{ROD}</body>"
        f"<body name='b' pos='1 0 0'><freejoint/>{ROD}</body>"
    ),
    "joints off the body's origin": mjcf(
        f"<body pos='.1 .2 .3' euler='10 20 30'><joint axis='1 2 3' pos='.3 -.1 .2'/>{ROD}"
        f"<body pos='0 0 .5'><joint type='slide' axis='1 1 0' pos='1 2 3'/>{ROD}</body></body>"
    ),
    "three joints on a body": mjcf(
        "<body euler='30 0 50'><joint type='slide' axis='1 0 0'/>"
        f"<joint axis='0 1 0' pos='0 .1 0'/><joint axis='1 0 1' pos='.2 0 0'/>{ROD}"
        f"<body pos='0 0 1'><joint/>{BALL}</body></body>"
    ),
    "joints with a reference": mjcf(
        f"<body><joint axis='0 1 0' ref='40' pos='.1 .2 .3'/>{ROD}"
        f"<body pos='0 0 1'><joint type='slide' axis='0 1 1' ref='.7'/>{ROD}</body></body>"
    ),
    "ball and free joints": mjcf(
        f"<body pos='1 2 3' euler='40 50 60'><freejoint/>{ROD}"
        f"<body pos='0 0 .5' euler='10 0 70'><joint type='ball' pos='.1 .1 0'/>{ROD}</body></body>"
    ),
    "armature": mjcf(
        f"<body><joint axis='0 1 0' armature='.3'/>{ROD}"
        f"<body pos='0 0 1'><joint type='ball' armature='.2'/>{ROD}</body></body>"
    ),
    "axis off unit": mjcf(f"<body><joint axis='0 3 4'/>{ROD}</body>"),
    "bodies in a <frame>": mjcf(
        f"<frame pos='0 0 1' euler='0 90 0'><body><joint/>{ROD}</body></frame>"
    ),
    "mass given to a geom by its class": mjcf(
        f"<body><joint axis='1 0 0'/>{ROD}</body>",
        "<default><geom mass='2.5'/></default>",
    ),
    "total mass set": mjcf(
        f"<body><joint axis='1 0 0'/>{ROD}<body pos='0 0 1'><joint axis='1 0 0'/>{ROD}</body>"
        "</body>",
        "<compiler settotalmass='14'/>",
    ),
    "inertia of some groups": mjcf(
        f"<body><joint axis='1 0 0'/>{ROD}<geom size='.3' group='4'/></body>",
        "<compiler inertiagrouprange='0 1'/>",
    ),
    "angles in radian, another Euler sequence": mjcf(
        f"<body euler='.1 .2 .3'><joint axis='1 0 0'/>{ROD}</body>",
        "<compiler angle='radian' eulerseq='zyx'/>",
    ),
    "inertia as it is written": mjcf(
        "<body><freejoint/><inertial pos='.1 .2 .3' mass='3' "
        "fullinertia='.5 .6 .7 .01 .02 .03'/></body>"
    ),
    "bodies fixed to each other": mjcf(
        f"<body pos='0 0 1'>{BALL}<body pos='1 0 0'><joint/>{ROD}<body pos='0 1 0'>{BALL}</body>"
        "</body></body>"
    ),
}


def speeds_from_ours(mj, data):
    """(nv, nv) MuJoCo's qvel out of our v at a state."""
    columns = []
    for unit in np.eye(mj.nv):
        _, ours = truth.state_from_mujoco(mj, data.qpos, unit)
        columns.append(ours)
    return np.linalg.inv(np.array(columns).T)


def whole(upper):
    return np.triu(upper) + np.triu(upper, 1).T


def quiet(text, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AssumptionWarning)
        return ik.Robot.from_mjcf(text, **options)


@pytest.mark.parametrize("case", TEXTS)
def test_mass_matrix_and_places_are_those_of_mujoco(case):
    mj = mujoco.MjModel.from_xml_string(TEXTS[case])
    robot = ik.Robot.from_mjcf(TEXTS[case])
    assert (robot.nq, robot.nv) == (mj.nq, mj.nv)
    rng = np.random.default_rng(1)
    for _ in range(5):
        data = truth.state(mj, rng)
        q, v = truth.state_from_mujoco(mj, data.qpos, data.qvel)
        turned = speeds_from_ours(mj, data)
        expected = turned.T @ truth.full_mass(mj, data) @ turned
        ours = robot.model.createData()
        mass = whole(pin.crba(robot.model, ours, q))
        np.testing.assert_allclose(mass, expected, atol=1e-13 * abs(expected).max())
        np.testing.assert_allclose(turned @ v, data.qvel, atol=1e-13)
        pin.framesForwardKinematics(robot.model, ours, q)
        for link, place in zip(robot.links, data.xpos[1:], strict=True):
            np.testing.assert_allclose(ours.oMf[link.frame_id].translation, place, atol=1e-12)
        assert robot.mass == pytest.approx(
            sum(mj.body_mass[i] for i in range(mj.nbody) if mj.body_weldid[i] > 0), rel=1e-13
        )


@pytest.mark.parametrize("case", TEXTS)
def test_states_go_to_mujoco_and_back(case):
    mj = mujoco.MjModel.from_xml_string(TEXTS[case])
    data, again = truth.state(mj, np.random.default_rng(3)), mujoco.MjData(mj)
    ik.set_mujoco_state(again, *ik.mujoco_state(data))
    np.testing.assert_allclose(again.qpos, data.qpos, atol=1e-15)
    np.testing.assert_allclose(again.qvel, data.qvel, atol=1e-14)
    with pytest.raises(ShapeError, match="set_mujoco_state: q: expected shape"):
        ik.set_mujoco_state(again, [1.0] * 99, data.qvel)


@pytest.mark.parametrize("case", TEXTS)
def test_a_blow_moves_it_as_mujocos_own_matrices_say(case):
    mj = mujoco.MjModel.from_xml_string(TEXTS[case])
    robot = ik.Robot.from_mjcf(TEXTS[case])
    rng = np.random.default_rng(2)
    body, blow, at = mj.nbody - 1, rng.normal(size=3), rng.normal(size=3)
    link = robot.links[-1].name
    scene = ik.Scene(robot, [ik.AppliedImpulse(link, linear=blow, at=at)])
    data = truth.state(mj, rng)
    q, v = truth.state_from_mujoco(mj, data.qpos, data.qvel)
    impact = ik.solve(scene, q, v)
    expected = truth.jump(mj, data, body, at, blow)
    _, ours = truth.state_from_mujoco(mj, data.qpos, expected)
    np.testing.assert_allclose(impact.dv, ours, atol=1e-11 * abs(ours).max())
    assert impact.is_valid()
    batch = ik.solve_batch(scene, q[None], v[None])
    np.testing.assert_allclose(batch.v_after[0], impact.v_after, atol=1e-11 * abs(ours).max())


FOUR_BAR = mjcf(
    "<body name='a'><joint name='j1' axis='0 1 0'/><geom type='capsule' size='.02' "
    "fromto='0 0 0 0 0 1'/><body name='b' pos='0 0 1'><joint name='j2' axis='0 1 0'/>"
    "<geom type='capsule' size='.02' fromto='0 0 0 2 0 .4'/></body></body>"
    "<body name='c' pos='2 0 0'><joint name='j3' axis='0 1 0'/><geom type='capsule' size='.02' "
    "fromto='0 0 0 0 0 1.4'/></body>"
).replace("</mujoco>", "<equality>{}</equality></mujoco>")
EQUALITIES = {
    "connect": "<connect body1='b' body2='c' anchor='2 0 .4'/>",
    "weld": "<weld body1='b' body2='c'/>",
    "joint": "<joint joint1='j1' joint2='j3' polycoef='0 -.7 0 0 0'/>",
    "lock": "<joint joint1='j2'/>",
}


@pytest.mark.parametrize("kind", EQUALITIES)
def test_an_equality_becomes_a_constraint(kind):
    """v⁺ against the dense KKT system with the constraint rows of MuJoCo."""
    text = FOUR_BAR.format(EQUALITIES[kind])
    mj = mujoco.MjModel.from_xml_string(text)
    robot = ik.Robot.from_mjcf(text)
    scene = ik.Scene.of_robot(
        robot, impulses=[ik.AppliedImpulse("b", linear=[1, 0, 2], at=[0.5, 0, 0.1])]
    )
    assert len(scene.constraints) == 1
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    data = mujoco.MjData(mj)
    mujoco.mj_forward(mj, data)
    blow = mj.body("b").id, [0.5, 0, 0.1], [1, 0, 2]
    free, expected = (truth.jump(mj, data, *blow, loops=loops) for loops in (False, True))
    assert abs(expected - free).max() > 0.01 * abs(free).max()
    np.testing.assert_allclose(impact.dv, expected, atol=1e-10 * abs(free).max())


def test_a_site_called_like_its_body_is_the_site():
    """A connect between sites, one of which has the name of a body."""
    text = mjcf(
        "<site name='wall' pos='.5 0 -.5'/><body name='rod'><joint axis='0 1 0'/>"
        "<geom size='.02' type='capsule' fromto='0 0 0 0 0 -1'/><body name='end' pos='0 0 -.5'>"
        "<joint type='slide' axis='1 0 0'/><geom size='.05'/><site name='end' pos='.5 0 0'/>"
        "</body></body>"
    ).replace("</mujoco>", "<equality><connect site1='wall' site2='end'/></equality></mujoco>")
    with pytest.warns(AssumptionWarning, match='site "end" is called "end_site"'):
        robot = ik.Robot.from_mjcf(text)
    np.testing.assert_allclose(
        robot.placement(robot.neutral(), "end_site").position, [0.5, 0, -0.5], atol=1e-15
    )
    assert truth.difference(mujoco.MjModel.from_xml_string(text), loops=True) < 1e-12


LEFT_OUT = {
    "tendons": "<tendon><fixed name='wire'><joint joint='h' coef='1'/></fixed></tendon>",
    "actuators": "<actuator><motor name='motor' joint='h'/></actuator>",
    "equality": "<equality><joint name='cam' joint1='h' polycoef='0 0 1 0 0' active='false'/>"
    "</equality>",
}


@pytest.mark.parametrize("what", LEFT_OUT)
def test_what_is_left_out_is_said_by_name(what):
    name = {"tendons": "wire", "actuators": "motor", "equality": "cam"}[what]
    text = mjcf(f"<body><joint name='h'/>{ROD}</body>").replace(
        "</mujoco>", LEFT_OUT[what] + "</mujoco>"
    )
    with pytest.warns(AssumptionWarning, match=f'"{name}"'):
        robot = ik.Robot.from_mjcf(text)
    assert any(what in sentence for sentence in robot.assumptions)


def test_what_no_rigid_model_can_hold_is_refused():
    tendon = "<tendon><fixed name='wire' armature='1'><joint joint='h' coef='1'/></fixed></tendon>"
    text = mjcf(f"<body><joint name='h'/>{ROD}</body>").replace("</mujoco>", tendon + "</mujoco>")
    with pytest.raises(MjcfError, match=r'"wire".*armature'):
        ik.Robot.from_mjcf(text)


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("<mujoco><worldbody><bdy/></worldbody></mujoco>", "bdy"),
        ("nowhere.xml", "no such file"),
        ("<scene/>", "MuJoCo refuses it"),
        (3, "an int"),
        ("/dev/zero", "device"),
    ],
)
def test_a_broken_source_is_named(source, words):
    with pytest.raises(MjcfError, match=words):
        ik.Robot.from_mjcf(source)


def test_a_file_a_compiled_model_and_an_editable_one_are_the_same_robot(tmp_path):
    text = TEXTS["ball and free joints"]
    (tmp_path / "robot.xml").write_text(text)
    robots = [
        ik.Robot.from_mjcf(source)
        for source in (
            text,
            tmp_path / "robot.xml",
            mujoco.MjModel.from_xml_string(text),
            mujoco.MjSpec.from_string(text),
        )
    ]
    for robot in robots[1:]:
        assert robot.model == robots[0].model
    copy = pickle.loads(pickle.dumps(robots[0]))
    assert copy.model == robots[0].model
    assert len(copy.collision_model.geometryObjects) == 2


FLOOR = "<geom name='floor' type='plane' size='1 1 1' friction='.4'/>"


@pytest.mark.parametrize("shape", ["sphere", "box", "capsule", "cylinder", "ellipsoid"])
def test_geoms_meet_with_the_friction_of_the_file(shape):
    text = mjcf(
        FLOOR + "<body name='b' pos='0 0 1'><freejoint name='r'/>"
        f"<geom name='g' type='{shape}' size='.1 .1 .1' friction='.3'/></body>"
    )
    robot = ik.Robot.from_mjcf(text)
    scene = ik.Scene.of_robot(robot, file_contacts="world", restitution=0.5)
    (contact,) = scene.contacts
    assert (contact.first, contact.other, contact.friction) == ("g", "floor", 0.4)
    half = 0.2 if shape == "capsule" else 0.1
    q = robot.configuration(r=[0, 0, half, 0, 0, 0, 1])
    impact = ik.solve(scene, q, robot.velocity(r=[0, 0, -2, 0, 0, 0]))
    np.testing.assert_allclose(impact.v_after, [0, 0, 1, 0, 0, 0], atol=1e-6)
    # The file's contacts are there unless they are refused, and that is warned of.
    assert len(ik.Scene.of_robot(robot).contacts) == 1
    bare = ik.Scene.of_robot(robot, file_contacts=False)
    assert bare.contacts == ()
    with pytest.warns(SetupWarning, match="nothing can be hit"):
        ik.simulate(bare, q, robot.velocity(), duration=0.01)
    bare = ik.Scene.of_robot(robot, file_contacts=False)
    with pytest.warns(SetupWarning, match="nothing can be hit"):
        ik.solve_batch(bare, q, robot.velocity())
    with pytest.raises(UnknownNameError, match="file_contacts"):
        ik.Scene.of_robot(robot, file_contacts="floor")


@pytest.mark.parametrize("seed", range(6))
def test_friction_is_that_of_mujocos_contacts(seed):
    """condim, priorities, pairs and overrides, as MuJoCo's own list of contacts has them."""
    rng = np.random.default_rng(seed)

    def geom(name, kind):
        numbers = " ".join(f"{x:.3f}" for x in rng.uniform(0.1, 2.0, 3) * [1, 0.1, 0.01])
        return (
            f"<geom name='{name}' type='{kind}' size='.1 .1 .1' friction='{numbers}' "
            f"condim='{rng.choice([1, 3, 4, 6])}' priority='{rng.integers(0, 2)}'/>"
        )

    bodies = "".join(
        f"<body pos='{k} 0 .05'><freejoint/>{geom(f'g{k}', 'sphere')}</body>" for k in range(4)
    )
    spin, roll = rng.uniform(0.01, 0.1, 2).tolist()
    more = (
        f"<contact><pair geom1='g1' geom2='floor' condim='{rng.choice([1, 3, 4, 6])}' "
        f"friction='.7 .7 {spin:.4f} {roll:.4f} {roll:.4f}'/></contact>"
    )
    if seed == 5:
        more += "<option o_friction='.3 .3 .02 .01 .01'><flag override='enable'/></option>"
    text = mjcf(geom("floor", "plane") + bodies, more)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 4
    scene = ik.Scene.of_robot(quiet(text), file_contacts="world")
    ours = {c.first: c for c in scene.contacts}
    for one in data.contact:
        name = next(n for i in one.geom if (n := model.geom(int(i)).name) != "floor")
        theirs = one.friction * [one.dim >= 3, 0, one.dim >= 4, one.dim >= 6, 0]
        found = ours[name].friction, ours[name].torsion, ours[name].rolling
        np.testing.assert_allclose(found, theirs[[0, 2, 3]], rtol=1e-15)
    plain = ik.Scene.of_robot(quiet(text), file_contacts="world", file_turning=False)
    assert all(c.rolling == c.torsion == 0.0 for c in plain.contacts)


def test_a_ball_of_condim_6_stops_rolling():
    """MuJoCo's limit of the rolling moment is µ_r F_n: ω' = −µ_r m g/(7/5 m R²)."""
    text = mjcf(
        "<geom name='floor' type='plane' size='9 9 1' condim='1' friction='0 0 0'/>"
        "<body pos='0 0 .1'><freejoint name='r'/>"
        "<geom name='g' size='.1' mass='1' condim='6' friction='1 .1 .004'/></body>"
    )
    robot = ik.Robot.from_mjcf(text)
    scene = ik.Scene.of_robot(robot, file_contacts=True)
    v = robot.velocity(r=[0.2, 0, 0, 0, 2.0, 0])
    motion = ik.simulate(scene, robot.configuration(r=[0, 0, 0.1, 0, 0, 0, 1]), v, 0.2)
    slower = 2.0 - 0.004 * 9.81 / (1.4 * 0.01) * 0.2
    assert motion.v[-1][4] == pytest.approx(slower, abs=1e-8)


def test_a_body_without_a_name_gets_one_that_the_file_leaves():
    """A frame of a name that was there already was left out, with its mass."""
    text = mjcf(
        "<body name='body_2'><freejoint name='free_joint_1'/><geom size='.1' mass='1'/></body>"
        "<body pos='1 0 0'><freejoint/><geom size='.1' mass='5'/></body>"
        "<body name='free'><freejoint/><geom size='.1' mass='7'/></body>"
        "<body name='world_body'><joint/><geom size='.1' mass='11'/></body>"
    )
    with pytest.warns(AssumptionWarning, match='body number 2, which has no name, is called "bo'):
        robot = ik.Robot.from_mjcf(text)
    assert robot.mass == pytest.approx(mujoco.MjModel.from_xml_string(text).body_mass.sum())
    assert len(set(robot.joint_names)) == 4
    assert len({link.name for link in robot.links}) == 4


def test_limits_come_along_and_an_unlimited_hinge_has_none():
    text = mjcf(
        f"<body><joint name='a' range='-20 30' limited='true'/>{ROD}"
        f"<body><joint name='b' type='slide'/>{ROD}</body></body>"
    )
    model = ik.Robot.from_mjcf(text).model
    np.testing.assert_allclose(model.lowerPositionLimit, [np.deg2rad(-20), -np.inf])
    np.testing.assert_allclose(model.upperPositionLimit, [np.deg2rad(30), np.inf])


@pytest.mark.parametrize(
    ("flag", "meets"),
    [("", False), ("<flag filterparent='disable'/>", True), ("<flag warmstart='disable'/>", False)],
)
def test_a_parent_meets_its_child_where_the_file_says_so(flag, meets):
    """As MuJoCo's own list of contacts has it; a number for the flag held for other versions."""
    child = "<body name='b'><joint/><geom name='h' size='.1'/></body>"
    text = mjcf(
        f"<body name='a'><freejoint/><geom name='g' size='.1'/>{child}</body>",
        f"<option>{flag}</option>",
    )
    data = mujoco.MjData(model := mujoco.MjModel.from_xml_string(text))
    mujoco.mj_forward(model, data)
    assert bool(data.ncon) == bool(quiet(text).touching_pairs) == meets


def test_a_file_that_disables_contacts_has_none():
    text = mjcf(
        FLOOR + "<body pos='0 0 1'><freejoint/><geom size='.1'/></body>",
        "<option><flag contact='disable'/></option>",
    )
    assert quiet(text).touching_pairs == () and not ik.Scene.of_robot(quiet(text)).contacts
