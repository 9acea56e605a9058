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


def test_the_line_names_the_impact_of_this_instant_alone(opened, motion):
    page, _ = opened
    texts = []
    for number in (0, 1):
        page.seek(page.run("i => Math.fround(replay.impacts[i].time)", number))
        texts.append(page.run("() => player.text"))
    assert texts == page.run("() => replay.impacts.slice(0, 2).map(hit => hit.text)")
    count = len(motion.impacts)
    assert page.run("() => player.impactHere()") == f"impact 2 of {count}"


def test_follow_comes_near(opened):
    page, _ = opened
    far = "() => viewer.camera.position.distanceTo(viewer.controls.target)"
    page.page.get_by_role("button", name="Follow").click()
    page.run("() => { stage.followed = stage.followed.slice(-1); }")
    before = page.run(far)
    page.run("() => stage.follow(true)")
    assert page.run(far) < before


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
    assert not page.shown(f"{blow}/<object>")
    others = [path for paths in shown.arrows.values() for path in paths if "/0/" in path]
    after = next(path for path in others if " after " in path)
    assert page.shown(f"{after}/<object>")
    kind.click()
    assert page.shown(f"{blow}/<object>")


def test_arrows_fade_and_leave_room_for_those_of_the_next_impact(opened):
    page, shown = opened
    first, second = (
        next(path for path in shown.arrows["floor"] if f"/{number}/" in path) for number in (0, 1)
    )
    opacity = """path => {
        const seen = [];
        nodeAt(path).object.traverse(({ material }) => {
            if (material) seen.push(material.opacity);
        });
        return Math.max(...seen);
    }"""
    start, end = page.run("() => [replay.impacts[0].time, replay.impacts[0].end]")
    seen = []
    for share in (0.01, 0.7, 0.9):
        page.seek(start + share * (end - start))
        assert page.shown(first)
        seen.append(page.run(opacity, first))
    assert seen == pytest.approx([1.0, 0.75, 0.25], abs=0.02)
    page.seek(page.run("() => replay.impacts[1].time"))
    assert not page.shown(first)
    assert page.shown(second)


def test_follow_keeps_the_mass_centre_in_the_middle(opened):
    page, shown = opened
    off_centre = """() => {
        viewer.render();
        const point = stage.centre().project(viewer.camera);
        return Math.max(Math.abs(point.x), Math.abs(point.y));
    }"""
    page.seek(0.0)
    assert page.run(off_centre) > 0.05
    page.page.get_by_role("button", name="Follow").click()
    for share in (0.0, 0.4, 1.0):
        page.seek(share * shown.duration)
        assert page.run(off_centre) < 1e-6


def on_screen(page, path, share=0.0):
    """Where a point of a node is in the window [px]: at this share of its greatest z."""
    return page.run(
        """([path, share]) => {
            const node = viewer.scene_tree.find(path.split("/").filter(x => x)).object;
            let top = 0;
            if (share) node.traverse(({ geometry }) => {
                if (!geometry) return;
                // Arrows are profiles about the y axis of their geometry.
                geometry.computeBoundingBox();
                top = geometry.boundingBox.max.y;
            });
            const place = new MeshCat.THREE.Vector3(0, 0, share * top);
            place.applyMatrix4(node.matrixWorld);
            place.project(viewer.camera);
            const box = viewer.renderer.domElement.getBoundingClientRect();
            return [box.left + 0.5 * (1 + place.x) * box.width,
                    box.top + 0.5 * (1 - place.y) * box.height];
        }""",
        [path, share],
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


def test_an_arrow_says_its_value_under_the_mouse_and_in_the_bar(opened, motion):
    page, shown = opened
    page.page.get_by_role("button", name="Next impact").click()
    (_, impact), *_ = motion.impacts
    said = f"floor: {np.linalg.norm(impact.contacts['floor'].impulse):.3g} N s, sliding"
    page.page.wait_for_function(
        "said => document.getElementById('impact').textContent === said", arg=said, timeout=20_000
    )
    blow = next(path for path in shown.arrows["floor"] if "/0/" in path)
    page.run("() => viewer.render()")
    # Its head: at its foot there is the mark of the contact.
    page.page.mouse.move(*on_screen(page, blow, 0.96))
    page.page.wait_for_function(
        "said => document.getElementById('name').textContent === said", arg=said, timeout=20_000
    )
    page.page.keyboard.press("Home")
    page.page.wait_for_function(
        "() => document.getElementById('impact').textContent === ''", timeout=20_000
    )


def test_contact_forces_between_impacts(page, tmp_path):
    box = ik.Robot.from_urdf(BALL.replace('sphere radius="0.1"', 'box size="0.2 0.2 0.2"'),
                             root="freeflyer")  # fmt: skip
    corners = [[x, y, -0.1] for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    scene = ik.Scene(box, contacts=[ik.Contact("ball", at=at, friction=0.5) for at in corners])
    start = box.configuration(root_joint=[0, 0, 0.15, 0, 0, 0, 1])
    motion = ik.simulate(scene, start, box.velocity(), duration=0.5)
    shown = ik.replay(motion, tmp_path / "page.html", play=False, hold=0.05)
    assert "contact force, the longest arrow" in shown.html
    page.open(tmp_path / "page.html")
    page.page.keyboard.press("End")
    quarter = float(np.linalg.norm(motion.contacts["contacts[0]"].force(0.5)))
    assert quarter == pytest.approx(9.81 / 4, rel=1e-6)
    page.page.wait_for_function(
        "said => document.getElementById('impact').textContent.startsWith(said)",
        arg=f"contacts[0]: {quarter:.3g} N; contacts[1]: ",
        timeout=20_000,
    )
    arrow = "/impulsekit/forces/0 contacts[0]"
    page.run("() => viewer.render()")
    turned = page.world(arrow)
    # It stands on its corner, points up, and is of full length where the force is largest.
    np.testing.assert_allclose(turned[:3, 3], [-0.1, -0.1, 0.0], atol=1e-3)
    np.testing.assert_allclose(turned[:3, 2], [0, 0, 1], atol=0.02)
    page.page.keyboard.press("Home")
    assert np.linalg.norm(page.world(arrow)[:3, 2]) < 1e-3
