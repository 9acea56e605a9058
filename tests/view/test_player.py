"""The page's bar, legend and keys, used as a reader would: by mouse and keyboard."""

import re

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

BALL = """<robot name="ball"><link name="ball"><inertial><mass value="1"/>
  <inertia ixx="0.004" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><sphere radius="0.1"/></geometry>
  <material name="red"><color rgba="0.9 0.2 0.1 1"/></material></visual></link></robot>"""


@pytest.fixture(scope="module")
def motion():
    """A ball that is dropped on a floor beside an arm that swings."""
    ball = ik.Robot.from_urdf(BALL, root="freeflyer")
    robot = ik.combine(arm=ik.Robot.from_urdf(ik.models.pendulum_urdf(2)), ball=ball)
    scene = ik.Scene(
        robot,
        contacts=[ik.Contact("ball/ball", at=[0, 0, -0.1], restitution=0.7, name="floor")],
    )
    q = robot.neutral()
    placed = [0.5, 0.5, 0.4, 0, 0, 0, 1]
    first = robot.model.joints[robot.joint_id("ball/root_joint")].idx_q
    q[first : first + 7] = placed
    return ik.simulate(scene, q, robot.velocity(), duration=1.0)


@pytest.fixture
def opened(motion, page, tmp_path):
    """The motion's page, and its replay."""
    shown = ik.replay(
        motion,
        tmp_path / "page.html",
        traces=["ball/ball"],
        reactions=True,
        play=False,
        hold=0.3,
    )
    page.page.set_viewport_size({"width": 800, "height": 500})
    page.open(tmp_path / "page.html")
    yield page, shown
    page.page.set_viewport_size({"width": 800, "height": 500})


def time_of(page):
    return page.run("() => viewer.animator.time")


def is_playing(page):
    return page.run("() => viewer.animator.playing")


def assert_as_forward_kinematics(page, shown, motion):
    """The bodies stand where forward kinematics puts them at the frame that is shown."""
    frame = int(np.argmin(np.abs(shown.times - time_of(page))))
    assert time_of(page) == pytest.approx(shown.times[frame], rel=1e-6, abs=1e-6)
    robot = motion.scene.robot
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, motion.at(float(shown.motion_times[frame]))[0])
    wanted = [data.oMi[robot.joint_id(joint)].homogeneous for joint in robot.joint_names]
    found = page.worlds([shown.nodes[joint] for joint in robot.joint_names])
    np.testing.assert_allclose(found, wanted, atol=1e-6)


def test_play_and_pause(opened):
    page, _ = opened
    page.page.get_by_role("button", name="Play", exact=True).click()
    page.page.wait_for_function("() => viewer.animator.time > 0.05", timeout=20_000)
    page.page.get_by_role("button", name="Pause", exact=True).click()
    assert not is_playing(page)
    stopped = time_of(page)
    page.page.keyboard.press("Space")
    page.page.wait_for_function("t => viewer.animator.time > t + 0.05", arg=stopped, timeout=20_000)
    page.page.keyboard.press("Space")
    assert not is_playing(page)


def test_dragging_the_time_shows_exact_poses(opened, motion):
    page, shown = opened
    slider = page.page.get_by_role("slider", name="Time")
    box = slider.bounding_box()
    middle = box["y"] + 0.5 * box["height"]
    seen = []
    for share in (0.23, 0.5, 0.81):
        page.page.mouse.move(box["x"] + 0.1 * box["width"], middle)
        page.page.mouse.down()
        page.page.mouse.move(box["x"] + share * box["width"], middle, steps=4)
        page.page.mouse.up()
        assert time_of(page) == pytest.approx(share * shown.duration, abs=0.03 * shown.duration)
        assert_as_forward_kinematics(page, shown, motion)
        seen.append(time_of(page))
    assert seen == sorted(seen)


def test_stepping_from_impact_to_impact(opened, motion):
    page, shown = opened
    instants = np.interp([t for t, _ in motion.impacts], shown.motion_times, shown.times)
    assert len(instants) >= 2
    assert page.run("() => document.querySelectorAll('#marks i').length") == len(instants)
    following = page.page.get_by_role("button", name="Next impact")
    for number, instant in enumerate(instants[:2]):
        following.click()
        assert time_of(page) == pytest.approx(instant, abs=1e-6)
        assert_as_forward_kinematics(page, shown, motion)
        # What the impact did is seen in the very frame.
        blow = next(path for path in shown.arrows["floor"] if f"/{number}/" in path)
        assert page.shown(blow)
        page.page.wait_for_function(
            "text => document.getElementById('pace').textContent.startsWith(text)",
            arg=f"impact {number + 1} of",
            timeout=20_000,
        )
    page.page.get_by_role("button", name="Previous impact").click()
    assert time_of(page) == pytest.approx(instants[0], abs=1e-6)


def test_keys_step_seek_and_change_the_speed(opened, motion):
    page, shown = opened
    press = page.page.keyboard.press
    press("ArrowRight")
    assert time_of(page) == pytest.approx(shown.times[1], rel=1e-6)
    press("Shift+ArrowRight")
    assert time_of(page) == pytest.approx(shown.times[11], rel=1e-6)
    press("ArrowLeft")
    assert time_of(page) == pytest.approx(shown.times[10], rel=1e-6)
    assert_as_forward_kinematics(page, shown, motion)
    press("End")
    assert time_of(page) == pytest.approx(shown.duration, rel=1e-6)
    press("Home")
    assert time_of(page) == 0.0
    press("n")
    first = time_of(page)
    press("ArrowDown")
    assert time_of(page) > first
    press("ArrowUp")
    assert time_of(page) == first
    press("-")
    assert page.run("() => viewer.animator.mixer.timeScale") == 0.5
    page.page.get_by_role("combobox", name="Speed").select_option("2")
    assert page.run("() => viewer.animator.mixer.timeScale") == 2.0


def test_arrows_can_be_hidden_together_and_by_kind(opened):
    page, shown = opened
    page.page.get_by_role("button", name="Next impact").click()
    blow = next(path for path in shown.arrows["floor"] if "/0/" in path)
    with_arrows = page.picture().astype(int)
    page.page.get_by_role("button", name="Arrows").click()
    assert not page.shown(blow)
    page.run("() => viewer.render()")
    without = page.picture().astype(int)
    assert (np.abs(without - with_arrows).max(axis=2) > 40).sum() > 100
    page.page.keyboard.press("a")
    assert page.shown(blow)
    kind = page.page.locator("#legend button.row", has_text=re.compile("^impulse"))
    kind.click()
    assert not page.shown(f"{blow}/solid")
    others = [path for paths in shown.arrows.values() for path in paths if "/0/" in path]
    after = next(path for path in others if " after " in path)
    assert page.shown(f"{after}/solid")
    kind.click()
    assert page.shown(f"{blow}/solid")


def on_screen(page, path):
    """Where a node's origin is in the window [px]."""
    return page.run(
        """path => {
            const node = viewer.scene_tree.find(path.split("/").filter(x => x)).object;
            const place = new MeshCat.THREE.Vector3().setFromMatrixPosition(node.matrixWorld);
            place.project(viewer.camera);
            const box = viewer.renderer.domElement.getBoundingClientRect();
            return [box.left + 0.5 * (1 + place.x) * box.width,
                    box.top + 0.5 * (1 - place.y) * box.height];
        }""",
        path,
    )


def test_a_body_says_its_name_under_the_mouse(opened):
    page, shown = opened
    page.run("() => viewer.render()")
    page.page.mouse.move(*on_screen(page, shown.nodes["ball/root_joint"]))
    page.page.wait_for_function(
        "() => document.getElementById('name').textContent === 'ball/ball, joint ball/root_joint'",
        timeout=20_000,
    )
    assert page.page.locator("#name").is_visible()
    page.page.mouse.move(5, 5)
    page.page.wait_for_function("() => document.getElementById('name').hidden", timeout=20_000)
