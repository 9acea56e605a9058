"""What a replay tells the player, without a browser."""

import json
import pathlib
import re
import sys
import time

import coal
import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import ImpulsekitError, InputError, RangeError
from impulsekit.measured import Recording
from impulsekit.models import chain_urdf
from impulsekit.scene import ReportPoint
from impulsekit.view.bodies import body_shapes

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
MESH = """<robot name="broken">
  <link name="a"><inertial><mass value="2"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://gone/a.stl"/></geometry></visual></link>
  <link name="b"><inertial><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><sphere radius="0.3"/></geometry></visual></link>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/>
    <axis xyz="0 0 1"/><limit effort="1" velocity="1"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def chain():
    robot = ik.Robot.from_urdf(chain_urdf(3), root="planar")
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_1", [0, 5, 0], [0, 0, 0.5], name="blow")])
    return ik.solve(scene, robot.neutral(), robot.velocity())


def test_a_missing_mesh_is_named_and_drawn_as_a_simple_body(tmp_path):
    robot = ik.Robot.from_urdf(MESH, root="freeflyer", package_dirs=[tmp_path])
    shown = ik.replay(Recording(robot, [0.0], [robot.neutral()]))
    (note,) = shown.notes
    assert '"a" drawn as a simple body' in note
    assert "package://gone/a.stl" in note
    assert str(tmp_path) in note
    assert note.replace('"', '\\"') in shown.html
    shapes, _ = body_shapes(robot)
    assert {(s.item.name, type(s.item.geometry)) for s in shapes} == {
        ("a", coal.Box),
        ("b_0", coal.Sphere),
    }


def test_a_robot_without_a_urdf_is_drawn_from_its_inertia():
    model = pin.buildSampleModelManipulator()
    robot = ik.Robot.from_model(model)
    shapes, notes = body_shapes(robot)
    assert notes == ()
    assert len(shapes) >= 5
    assert {type(shape.item.geometry) for shape in shapes} <= {coal.Box, coal.Sphere}


def test_the_arrows_of_an_impact(chain):
    shown = ik.replay(chain, points=[ReportPoint("link_1", label="end")], reactions=["joint_2"])
    kinds = {
        name: [p.split("/")[-1].split()[1] for p in paths] for name, paths in shown.arrows.items()
    }
    # At rest before: there is no arrow for that.
    assert kinds == {"blow": ["impulse", "couple"], "end": ["after"], "joint_2": ["reaction"]}
    assert "impulse, the longest arrow 5 N s" in shown.html
    assert "couple impulse, the longest arrow 0.5 N m s" in shown.html
    assert "m/s" in shown.html


def facts_of(shown):
    """What the page's scripts read."""
    return json.loads(re.search(r'id="replay">(.*?)</script>', shown.html)[1])


def test_arrows_of_an_impact_end_at_the_next_one(chain):
    robot = chain.scene.robot
    hits = [(0.2, chain), (0.4, chain)]
    motion = Recording(robot, [0.0, 1.0], [robot.neutral()] * 2, hits)
    first, second = facts_of(ik.replay(motion, hold=5.0))["impacts"]
    assert first["end"] == second["time"] > first["time"]
    assert first["text"] == "blow: 5 N s; blow: 0.5 N m s, couple impulse"


def camera_of(shown):
    """The camera of a page, position and target in the scene's axes."""
    camera = facts_of(shown)["camera"]
    return [np.array([x, -z, y]) for x, y, z in (camera["position"], camera["target"])]


def test_the_camera_is_where_it_is_put(chain):
    for view, axis in (("front", 0), ("left", 1), ("top", 2)):
        position, target = camera_of(ik.replay(chain, camera=view))
        offset = position - target
        assert offset[axis] == pytest.approx(np.linalg.norm(offset), rel=0.01)
    position, target = camera_of(ik.replay(chain, camera=[[3, 2, 1], [0, 0.5, 0]]))
    assert position == pytest.approx([3, 2, 1]) and target == pytest.approx([0, 0.5, 0])
    with pytest.raises(RangeError, match='"front", "back", "left", "right", "top"'):
        ik.replay(chain, camera="below")
    with pytest.raises(InputError, match="a position"):
        ik.replay(chain, camera=[1, 2])


def test_coasting_keeps_a_loop_shut():
    from impulsekit.view.motions import coasting

    scene_file = ik.load_scene(EXAMPLES / "four_bar.toml")
    impact = ik.solve(scene_file.scene, scene_file.q, scene_file.v)
    recording = coasting(impact)
    robot = scene_file.scene.robot
    data = robot.model.createData()
    for q in recording.q:
        pin.framesForwardKinematics(robot.model, data, q)
        ends = [
            data.oMf[robot.frame_id(frame)].act(np.array(at))
            for frame, at in (("coupler", [0.5, 0, 0]), ("rocker", [0, 0.5, 0]))
        ]
        assert np.abs(ends[0] - ends[1]).max() < 1e-4


def test_a_storm_of_impacts_keeps_the_largest_arrows(chain):
    robot = chain.scene.robot
    times = np.linspace(0.0, 1.0, 200)
    motion = Recording(robot, times, [robot.neutral()] * 200, [(x, chain) for x in times])
    shown = ik.replay(motion)
    assert sum(map(len, shown.arrows.values())) == 400
    assert "largest of" in shown.notes[0]


def test_ten_seconds_of_a_humanoid_fit_into_five_megabytes():
    file = ik.load_scene(EXAMPLES / "talos_heel_strike.toml")
    robot = file.scene.robot
    impact = ik.solve(file.scene, file.q, file.v)
    t = np.linspace(0.0, 10.0, 201)
    # Every joint moves, at a pace of its own.
    sway = 0.3 * np.sin(np.outer(t, np.linspace(1.0, 4.0, robot.nv)))
    q = [pin.integrate(robot.model, robot.neutral(), each) for each in sway]
    motion = Recording(robot, t, q, [(float(k), impact) for k in range(1, 10)])
    shown = ik.replay(motion, reactions=True)
    assert len(shown.times) > 600
    assert 1e6 < len(shown.html) < 5e6


def test_without_a_display_the_page_is_named_and_nothing_hangs(chain, monkeypatch, tmp_path):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.warns(UserWarning, match=r"no browser.*page\.html"):
        shown = ik.replay(chain, tmp_path / "page.html", open=True)
    assert shown.page == str(tmp_path / "page.html")


def test_a_browser_is_given_the_page(chain, monkeypatch):
    import webbrowser

    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", lambda url, new: opened.append(url) or True)
    shown = ik.replay(chain, open=True)
    assert opened == [pathlib.Path(shown.page).as_uri()]
    pathlib.Path(shown.page).unlink()


def test_it_is_drawn_into_a_running_window_too(chain):
    sent = []

    class Socket:
        def getsockopt(self, key):
            return -1

        def setsockopt(self, key, value):
            pass

        def send_multipart(self, frames):
            sent.append(frames)

        def recv(self):
            return b"ok"

    class Window:
        zmq_socket, zmq_url = Socket(), "tcp://here"

    class Viewer:
        window = Window()

    shown = ik.replay(chain, viewer=Viewer())
    # An earlier picture goes first, and the camera comes last.
    assert len(sent) == len(shown.commands) + 2
    assert sent[0][:2] == [b"delete", b"/impulsekit"]
    assert sent[-2][0] == b"set_animation"


def test_a_dead_server_is_an_error_and_does_not_hang(chain, monkeypatch):
    import zmq

    from impulsekit.view import page

    monkeypatch.setattr(page, "PATIENCE", 200)

    class Window:
        zmq_socket, zmq_url = zmq.Context.instance().socket(zmq.REQ), "tcp://127.0.0.1:1"

    class Viewer:
        window = Window()

    Window.zmq_socket.setsockopt(zmq.LINGER, 0)
    Window.zmq_socket.connect(Window.zmq_url)
    start = time.perf_counter()
    with pytest.raises(ImpulsekitError, match="does not answer"):
        ik.replay(chain, viewer=Viewer())
    assert time.perf_counter() - start < 5.0
    Window.zmq_socket.close()
