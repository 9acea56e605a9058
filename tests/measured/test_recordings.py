"""Recordings out of arrays and files: every form gives the same; what is wrong is said."""

import csv

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import (
    FileError,
    InputError,
    NotFiniteError,
    RangeError,
    ShapeError,
    StateError,
    UnknownNameError,
)
from impulsekit.measured import Recording, RecordingFormat, load_recordings
from tests.measured.bodies import flying_body

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


@pytest.fixture(scope="module")
def truth():
    t, poses = flying_body(np.random.default_rng(0))
    return t, poses


def columns_of(truth, order="xyzw"):
    t, poses = truth
    turns = poses[:, 3:] if order == "xyzw" else poses[:, [6, 3, 4, 5]]
    return {"t": t, "position": poses[:, :3], f"quaternion_{order}": turns}


def same(recording, truth):
    t, poses = truth
    assert np.allclose(recording.t, t, atol=1e-9)
    apart = [pin.difference(BALL.model, a, b) for a, b in zip(recording.q, poses, strict=True)]
    assert np.abs(apart).max() < 1e-6


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_columns_in_either_order_of_the_quaternion(truth, order):
    same(Recording.from_columns(BALL, columns_of(truth, order)), truth)
    plain = columns_of(truth, order)
    plain["quaternion"] = plain.pop(f"quaternion_{order}")
    same(Recording.from_columns(BALL, plain, RecordingFormat(quaternion=order)), truth)
    with pytest.raises(InputError, match="order of the quaternion is not stated"):
        Recording.from_columns(BALL, plain)


@pytest.mark.parametrize("ending", ["npz", "csv", "parquet"])
def test_files_of_any_kind_hold_the_same(truth, ending, tmp_path):
    columns = columns_of(truth, "wxyz")
    flat = {"t": columns["t"]}
    for name in ("position", "quaternion_wxyz"):
        flat |= {f"{name}[{i}]": columns[name][:, i] for i in range(columns[name].shape[1])}
    path = tmp_path / f"toss.{ending}"
    if ending == "npz":
        np.savez(path, **columns)
    elif ending == "csv":
        with path.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(flat)
            writer.writerows(zip(*(column.tolist() for column in flat.values()), strict=True))
    else:
        pandas = pytest.importorskip("pandas")
        pandas.DataFrame(flat).to_parquet(path)
    (recording,) = load_recordings(path, BALL)
    same(recording, truth)


def write_bag(path, kind, topic, messages):
    """A ROS 2 bag of one topic; of each message its time [ns] and fields, the header apart."""
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    with Writer(path, version=8) as bag:
        connection = bag.add_connection(topic, kind, typestore=store)
        for nanoseconds, fields in messages:
            stamp = types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9))
            header = types["std_msgs/msg/Header"](stamp, "world")
            message = types[kind](header, *fields(types))
            bag.write(connection, nanoseconds + 10**6, store.serialize_cdr(message, kind))


def pose_fields(pose):
    return lambda types: [
        types["geometry_msgs/msg/Pose"](
            types["geometry_msgs/msg/Point"](*pose[:3]),
            types["geometry_msgs/msg/Quaternion"](*pose[3:]),
        )
    ]


def joint_fields(**positions):
    given = np.array(list(positions.values()))
    return lambda types: [list(positions), given, np.empty(0), np.empty(0)]


def test_a_ros_2_bag_holds_the_same(truth, tmp_path):
    times = [5_000_000_000 + round(1e9 * time) for time in truth[0]]
    messages = list(zip(times, map(pose_fields, truth[1]), strict=True))
    write_bag(tmp_path / "bag", "geometry_msgs/msg/PoseStamped", "/cube/pose", messages)
    (recording,) = load_recordings(tmp_path / "bag", BALL)
    same(recording, truth)
    with pytest.raises(UnknownNameError, match="unknown topic"):
        load_recordings(tmp_path / "bag", BALL, RecordingFormat(topics={"/cube/pos": ""}))


def test_joint_states_of_a_bag_have_all_joints_every_time(tmp_path):
    robot = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    kind, topic = "sensor_msgs/msg/JointState", "/joint_states"
    both = [(10**9 * k, joint_fields(joint_2=0.1 * k, joint_1=0.2 * k)) for k in (1, 2, 3)]
    write_bag(tmp_path / "bag", kind, topic, both)
    (recording,) = load_recordings(tmp_path / "bag", robot)
    np.testing.assert_allclose(recording.q, [[0.2, 0.1], [0.4, 0.2], [0.6, 0.3]])
    write_bag(tmp_path / "less", kind, topic, [*both, (4 * 10**9, joint_fields(joint_2=0.4))])
    with pytest.raises(InputError, match=r'at 4\.0{9} s have no position of joint "?joint_1'):
        load_recordings(tmp_path / "less", robot)
    write_bag(tmp_path / "other", kind, topic, [(10**9, joint_fields(knee=0.1))])
    with pytest.raises(InputError, match=r"none of its joints \(knee\) .* \(joint_1, joint_2\)"):
        load_recordings(tmp_path / "other", robot)


def test_several_recordings_in_one_file(tmp_path):
    tosses = load_recordings("examples/cube_tosses.npz", BALL)
    assert len(tosses) == 12 and tosses[1].name == "toss 11"
    assert tosses[0].v is not None and tosses[0].t[1] == pytest.approx(1 / 148)
    path = tmp_path / "tosses.csv"
    path.write_text("recording,t,q[0],q[1],q[2],q[3],q[4],q[5],q[6]\n"
                    "a,0,0,0,1,0,0,0,1\na,1,0,0,2,0,0,0,1\nb,0,0,0,3,0,0,0,1\n")  # fmt: skip
    first, second = load_recordings(path, BALL)
    assert (first.name, second.name) == ("a", "b") and first.q[1, 2] == 2.0


def test_units_that_are_stated(truth):
    columns = columns_of(truth)
    columns["t"], columns["position"] = 1e3 * columns["t"], 1e3 * columns["position"]
    same(Recording.from_columns(BALL, columns, RecordingFormat(time="ms", length="mm")), truth)


def test_joints_by_name():
    panda = ik.Robot.from_example("panda")
    names = list(panda.model.names)[1:]
    columns = {"t": [0.0, 1.0], **{f"q.{name}": [0.0, 90.0] for name in names[:7]},
               **{f"q.{name}": [0.0, 0.0] for name in names[7:]}}  # fmt: skip
    recording = Recording.from_columns(panda, columns, RecordingFormat(angle="deg"))
    assert recording.q[1, :7] == pytest.approx(np.full(7, np.pi / 2))
    del columns[f"q.{names[3]}"]
    with pytest.raises(InputError, match="no position of joint"):
        Recording.from_columns(panda, columns)
    with pytest.raises(UnknownNameError, match="did you mean"):
        Recording.from_columns(panda, {**columns, "q.panda_joint44": [0.0, 0.0]})


def test_gaps_and_times_that_run_back_are_an_error_or_a_named_repair(truth):
    columns = columns_of(truth)
    columns["position"] = columns["position"].copy()
    columns["position"][7] = np.nan
    with pytest.raises(NotFiniteError, match=r'1 of 30 samples.*sample 7.*repair="gaps"'):
        Recording.from_columns(BALL, columns)
    found = Recording.from_columns(BALL, columns, repair=["gaps"])
    assert len(found.t) == 29 and "1 of 30 samples" in found.notes[0]
    columns = columns_of(truth)
    columns["t"] = columns["t"].copy()
    columns["t"][[4, 5]] = columns["t"][[5, 4]]
    with pytest.raises(RangeError, match=r'sample 5.*repair="time"'):
        Recording.from_columns(BALL, columns)
    assert (np.diff(Recording.from_columns(BALL, columns, repair=["time"]).t) > 0).all()
    assert (np.diff(Recording.from_columns(BALL, columns, repair="time").t) > 0).all()
    with pytest.raises(UnknownNameError):
        Recording.from_columns(BALL, columns, repair=["everything"])


def test_quaternions_off_unit(truth):
    columns = columns_of(truth)
    columns["quaternion_xyzw"] = 1.05 * columns["quaternion_xyzw"]
    with pytest.raises(StateError, match=r'length 1.05 .*repair="norm"'):
        Recording.from_columns(BALL, columns)
    same(Recording.from_columns(BALL, columns, repair=["norm"]), truth)
    with pytest.raises(StateError, match="no rotation"):
        columns["quaternion_xyzw"] = 2.0 * columns["quaternion_xyzw"]
        Recording.from_columns(BALL, columns, repair=["norm"])


def with_velocities(truth):
    t, poses = truth
    columns = columns_of(truth)
    turns = [pin.XYZQUATToSE3(pose).rotation for pose in poses]
    body = pin.log3(turns[0].T @ turns[1]) / (t[1] - t[0])
    columns["velocity"] = np.gradient(poses[:, :3], t, axis=0)
    columns["omega_body"] = np.tile(body, (len(t), 1))
    return columns, np.array([turn @ body for turn in turns])


def test_velocities_are_held_against_the_rate_of_the_positions(truth):
    columns, in_world = with_velocities(truth)
    recording = Recording.from_columns(BALL, columns)
    assert recording.v is not None and not recording.notes
    wrong = {**columns, "omega_body": in_world}
    with pytest.raises(InputError, match="call the column omega_world"):
        Recording.from_columns(BALL, wrong)
    wrong = {**columns, "omega_body": np.degrees(columns["omega_body"])}
    with pytest.raises(InputError, match="deg/s"):
        Recording.from_columns(BALL, wrong)
    wrong = {**columns, "velocity": 1e3 * columns["velocity"]}
    with pytest.raises(InputError, match="mm/s"):
        Recording.from_columns(BALL, wrong)
    wrong = {**columns, "quaternion_wxyz": columns["quaternion_xyzw"]}
    del wrong["quaternion_xyzw"]
    with pytest.raises(InputError, match="order of the quaternion"):
        Recording.from_columns(BALL, wrong)


def test_velocities_by_smoothing_do_not_smear_over_a_break():
    t = np.arange(40) / 100
    q = np.zeros((40, 7))
    q[:, 0], q[:, 6] = np.where(t < 0.2, t, 0.4 - t), 1.0
    recording = Recording(BALL, t, q)
    smooth = recording.velocities(breaks=[0.2 - 1e-9])
    assert np.abs(smooth[:20, 0] - 1).max() < 1e-9 and np.abs(smooth[20:, 0] + 1).max() < 1e-9
    assert np.abs(recording.velocities()[20, 0]) < 0.5
    with pytest.raises(InputError, match="no other between two breaks"):
        recording.velocities(breaks=[0.195, 0.205])


def test_files_that_are_no_recording(tmp_path):
    for name, content, error, match in (
        ("a.csv", b"", InputError, "no row"),
        ("b.csv", b"t,q[0]\n0\n", InputError, "row 2 has 1 cells"),
        ("c.csv", b"t,position[0]\n0,up\n", InputError, "must hold numbers"),
        ("d.npz", b"no zip", FileError, "no npz file"),
        ("e.mat", b"1", InputError, "unknown ending"),
        ("f.csv", b"t,position[0],position[2]\n0,1,2\n", InputError, "are missing"),
        ("g.csv", b"t,speed\n0,1\n", UnknownNameError, "unknown column"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(error, match=match):
            load_recordings(tmp_path / name, BALL)
    with pytest.raises(FileError, match="no such file"):
        load_recordings(tmp_path / "none.csv", BALL)
    np.savez(tmp_path / "h.npz", t=[0.0, 1.0], q=np.zeros((3, 7)))
    with pytest.raises(ShapeError, match="one row per sample"):
        load_recordings(tmp_path / "h.npz", BALL)
    np.savez(tmp_path / "i.npz", t=[0.0, 1.0], q=np.zeros((2, 7)), offset=[0, 3])
    with pytest.raises(InputError, match="offset must rise"):
        load_recordings(tmp_path / "i.npz", BALL)


def test_a_tracker_that_lost_the_body_is_noted(truth):
    columns = columns_of(truth)
    held = {name: array.copy() for name, array in columns.items()}
    for name in ("position", "quaternion_xyzw"):
        held[name][10:14] = held[name][9]
    (note,) = Recording.from_columns(BALL, held).notes
    assert note.startswith("4 of 30 samples repeat the pose before them exactly, sample 10 the fi")
    # At rest at the end, as out of a simulator.
    for name in ("position", "quaternion_xyzw"):
        columns[name][20:] = columns[name][20]
    assert Recording.from_columns(BALL, columns).notes == ()


@pytest.mark.parametrize("moved", [(2, 3), (10, 15), (3, 20)])
def test_times_of_late_stretches_are_sorted_and_a_clock_that_begins_again_is_told(moved):
    t = 0.01 * np.arange(30)
    q = np.zeros((30, 7))
    q[:, 2], q[:, 6] = 1.0 - t, 1.0
    start, end = moved
    late = np.r_[np.arange(start), np.arange(end, 28), np.arange(start, end), [28, 29]]
    found = Recording.from_columns(BALL, {"t": t[late], "q": q[late]}, repair="time")
    assert found.t.tolist() == t.tolist() and found.q.tolist() == q.tolist()
    for shift in (0.15, 0.153):
        again = np.where(np.arange(30) < 15, t, t - shift)
        with pytest.raises(RangeError, match=r"begin again .* at sample 15.*two recordings"):
            Recording.from_columns(BALL, {"t": again, "q": q}, repair="time")


def test_an_odometry_is_read_for_its_poses_and_its_twists_are_said_to_be_left(truth, tmp_path):
    def fields(pose):
        def of(types):
            (own,) = pose_fields(pose)(types)
            zero = types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
            twist = types["geometry_msgs/msg/Twist"](zero, zero)
            return [
                "cube",
                types["geometry_msgs/msg/PoseWithCovariance"](own, np.zeros(36)),
                types["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36)),
            ]

        return of

    times = [5_000_000_000 + round(1e9 * time) for time in truth[0]]
    messages = list(zip(times, map(fields, truth[1]), strict=True))
    write_bag(tmp_path / "bag", "nav_msgs/msg/Odometry", "/odom", messages)
    (recording,) = load_recordings(tmp_path / "bag", BALL)
    same(recording, truth)
    assert recording.v is None and "twists of /odom are not read" in recording.notes[0]
