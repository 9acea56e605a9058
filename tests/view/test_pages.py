"""Pages of replays in a real browser: they load, move rightly, and show what they should."""

import pathlib

import coal
import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.measured import Recording
from impulsekit.models import chain_urdf

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
# Whether a scene takes the player more than a moment to load.
SCENES = [
    pytest.param("whittaker_chain", marks=pytest.mark.slow),
    pytest.param("pendulum_10", marks=pytest.mark.slow),
    "four_bar",
    pytest.param("solo12_landing", marks=pytest.mark.slow),
    pytest.param("talos_hand", marks=pytest.mark.slow),
    pytest.param("thrown_ball", marks=pytest.mark.slow),
]


def example(name):
    scene_file = ik.load_scene(EXAMPLES / f"{name}.toml")
    return ik.solve(scene_file.scene, scene_file.q, scene_file.v), scene_file.points


def tracks_of(page, path):
    return page.run(
        """(path) => {
            const target = viewer.scene_tree.find(path.split("/").filter(x => x)).object;
            return viewer.animator.actions.filter(a => a.getRoot() === target)
                .flatMap(a => a.getClip().tracks)
                .map(t => [t.name, t.times.length, t.times[t.times.length - 1]]);
        }""",
        path,
    )


def is_blank(picture):
    return np.ptp(picture[60:, :, :].astype(int), axis=(0, 1)).max() < 60


@pytest.mark.parametrize("name", SCENES)
def test_an_impact_is_shown(name, page, tmp_path):
    impact, points = example(name)
    robot = impact.scene.robot
    shown = ik.replay(impact, tmp_path / "page.html", points=points, play=False)
    assert shown.notes == ()
    page.open(tmp_path / "page.html")
    assert page.duration() == pytest.approx(shown.duration, abs=1e-9)

    # As many frames as were made, and joints where forward kinematics has them.
    moving = [n for n in robot.joint_names if tracks_of(page, shown.nodes[n])]
    assert moving
    for track, frames, last in tracks_of(page, shown.nodes[moving[-1]]):
        assert track in (".position", ".quaternion")
        assert frames == len(shown.times)
        assert last == pytest.approx(shown.duration, rel=1e-6)
    from impulsekit.view.motions import coasting

    recording = coasting(impact)
    data = robot.model.createData()
    for frame in (0, len(shown.times) // 2, len(shown.times) - 1):
        page.seek(float(shown.times[frame]))
        q = recording.at(shown.motion_times[[frame]])[0]
        pin.forwardKinematics(robot.model, data, q)
        wanted = [data.oMi[robot.joint_id(joint)].homogeneous for joint in robot.joint_names]
        found = page.worlds([shown.nodes[joint] for joint in robot.joint_names])
        np.testing.assert_allclose(found, wanted, atol=1e-6)

    # Velocities before it up to the blow; the blow and velocities after it from there on.
    instant = float(np.interp(0.0, shown.motion_times, shown.times))
    kinds = {
        path: path.split("/")[-1].split()[1] for group in shown.arrows.values() for path in group
    }
    assert "impulse" in kinds.values()
    assert "after" in kinds.values()
    for t, before in ((0.5 * instant, True), (instant + 0.01, False), (shown.duration, False)):
        page.seek(t)
        for path, kind in kinds.items():
            assert page.shown(path) == (before == (kind == "before")), (t, path)
    assert not is_blank(page.picture())


@pytest.mark.slow
def test_a_motion_has_its_own_frames_and_arrows_only_around_impacts(page, tmp_path):
    impact, points = example("whittaker_chain")
    robot = impact.scene.robot
    t = np.linspace(0.0, 3.0, 31)
    q = np.array([pin.integrate(robot.model, robot.neutral(), 0.1 * x * impact.v_after) for x in t])
    motion = Recording(robot, t, q, impacts=[(1.0, impact)])
    shown = ik.replay(
        motion,
        tmp_path / "page.html",
        points=points[:1],
        traces=points[:1],
        ghosts=[0.0, 2.0],
        fps=30,
        slow_motion=0.25,
        slow_window=0.1,
        hold=0.5,
        loop=False,
    )
    # 2.8 s as they are, and 0.2 s slowed four times.
    assert shown.duration == pytest.approx(3.6)
    assert len(shown.times) == 109
    page.open(tmp_path / "page.html")
    assert page.duration() == pytest.approx(3.6)
    instant = 0.9 + 0.1 / 0.25
    path = next(p for p in shown.arrows["blow"] if "impulse" in p)
    for time, visible in (
        (0.0, False),
        (instant - 0.02, False),
        (instant + 0.02, True),
        (instant + 0.48, True),
        (instant + 0.52, False),
        (3.6, False),
    ):
        page.seek(time)
        assert page.shown(path) is visible, time
    data = robot.model.createData()
    for time in (0.4, 1.3, 3.2):
        page.seek(time)
        moved = {0.4: 0.4, 1.3: 1.0, 3.2: 2.6}[time]
        pin.forwardKinematics(robot.model, data, motion.at(np.array([moved]))[0])
        wanted = data.oMi[robot.joint_id("joint_5")].homogeneous
        np.testing.assert_allclose(page.world(shown.nodes["joint_5"]), wanted, atol=1e-6)
    assert not is_blank(page.picture())


def test_the_clock_shows_the_time_of_the_motion(page, tmp_path):
    robot = ik.Robot.from_urdf(chain_urdf(2))
    q = [robot.neutral(), robot.configuration(joint_2=1.0)]
    ik.replay(Recording(robot, [0.0, 2.0], q), tmp_path / "page.html", play=False)
    page.open(tmp_path / "page.html")
    page.seek(1.5)
    clock = "document.querySelector('.clock').textContent"
    page.page.wait_for_function(f"() => {clock} === 't = 1.50 s'", timeout=20_000)


SHAPES = {
    "box": (coal.Box(0.2, 0.4, 0.6), (0.1, 0.2, 0.3)),
    "sphere": (coal.Sphere(0.2), (0.2, 0.2, 0.2)),
    "ellipsoid": (coal.Ellipsoid(0.1, 0.2, 0.3), (0.1, 0.2, 0.3)),
    "capsule": (coal.Capsule(0.1, 0.4), (0.1, 0.1, 0.3)),
    "cylinder": (coal.Cylinder(0.1, 0.4), (0.1, 0.1, 0.2)),
    "cone": (coal.Cone(0.1, 0.4), (0.1, 0.1, 0.2)),
}


# The vertices of a node in the player's axes, of which y is up.
CORNERS = """path => {
    viewer.scene.updateMatrixWorld(true);
    const points = [];
    nodeAt(path).object.traverse(({ geometry, matrixWorld }) => {
        const vertices = geometry?.attributes.position;
        for (let i = 0; i < (vertices?.count ?? 0); i++)
            points.push(...new MeshCat.THREE.Vector3()
                .fromBufferAttribute(vertices, i).applyMatrix4(matrixWorld).toArray());
    });
    return points;
}"""


def test_shapes_are_drawn_where_and_as_large_as_they_are(page, tmp_path):
    model = pin.Model()
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    model.appendBodyToJoint(root, pin.Inertia.Random(), pin.SE3.Identity())
    robot = ik.Robot.from_model(model)
    for i, (name, (shape, _)) in enumerate(SHAPES.items()):
        place = pin.SE3(np.eye(3), np.array([i, 2.0 * i, 3.0 * i]))
        robot.visual_model.addGeometryObject(pin.GeometryObject(name, root, 0, place, shape))
    ik.replay(Recording(robot, [0.0], [robot.neutral()]), tmp_path / "page.html", play=False)
    page.open(tmp_path / "page.html")
    for i, (name, (_, half)) in enumerate(SHAPES.items()):
        path = f"/impulsekit/bodies/1 root/{i} {name}"
        points = np.array(page.run(CORNERS, path)).reshape(-1, 3)[:, [0, 2, 1]] * [1, -1, 1]
        points -= [i, 2 * i, 3 * i]
        assert points.max(axis=0) == pytest.approx(half, rel=2e-2), name
        assert points.min(axis=0) == pytest.approx([-x for x in half], rel=2e-2), name
        if name == "cone":
            top = points[points[:, 2] > 0.999 * half[2]]
            assert np.abs(top[:, :2]).max() < 1e-6
