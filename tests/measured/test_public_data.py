"""Files of public recordings, made here in their formats: what is found, read and told."""

import pickle
import zipfile

import numpy as np
import pytest

from benchmarks.recorded import elbow, landings
from benchmarks.recorded import report as recorded
from benchmarks.recorded.__main__ import main
from benchmarks.recorded.tensors import read_tensor
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.errors import FileError, InputError


def zipped_tensor(path, array, opcode=b"torch\nDoubleStorage\n", shape=None):
    """What torch.save has written since version 1.6, put together from its pickled opcodes."""
    rows, columns = array.shape if shape is None else shape

    def number(value):
        return b"J" + int(value).to_bytes(4, "little", signed=True)

    def text(value):
        return b"X" + len(value).to_bytes(4, "little") + value

    storage = (
        b"("
        + text(b"storage")
        + b"c"
        + opcode
        + text(b"0")
        + text(b"cpu")
        + number(array.size)
        + b"tQ"
    )
    whole = (
        b"\x80\x02ctorch._utils\n_rebuild_tensor_v2\n(" + storage + number(0)
        + number(rows) + number(columns) + b"\x86" + number(columns) + number(1) + b"\x86"
        + b"\x89ccollections\nOrderedDict\n)RtR."
    )  # fmt: skip
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("archive/data.pkl", whole)
        file.writestr("archive/data/0", np.asarray(array, "<f8").tobytes())


def test_a_zipped_tensor_is_read_without_torch(tmp_path):
    array = np.random.default_rng(0).normal(size=(4, 15))
    zipped_tensor(tmp_path / "0.pt", array)
    assert np.array_equal(read_tensor(tmp_path / "0.pt"), array)
    zipped_tensor(tmp_path / "1.pt", array, shape=(9, 15))
    with pytest.raises(FileError, match="numbers are missing"):
        read_tensor(tmp_path / "1.pt")
    zipped_tensor(tmp_path / "2.pt", array, opcode=b"os\nsystem\n")
    with pytest.raises(FileError, match=r"os\.system has no place in a tensor"):
        read_tensor(tmp_path / "2.pt")
    (tmp_path / "3.pt").write_bytes((tmp_path / "0.pt").read_bytes()[:300])
    with pytest.raises(FileError, match="no tensor of doubles"):
        read_tensor(tmp_path / "3.pt")


def falling_elbow(scene, count=60, height=0.35):
    """A sample each 1/148 s of an elbow that falls flat and lies, in the columns of the files."""
    found = np.zeros((count, 15))
    for k, t in enumerate(np.arange(count) / elbow.RATE):
        found[k, 0] = 1.0
        found[k, 4:7] = [0.1 * t, 0.0, max(height - 0.5 * 9.81 * t**2, elbow.HALF[2])]
    return found


def test_tosses_of_an_elbow_are_cut_where_they_touch(tmp_path):
    scene = elbow.elbow_scene()
    for k in (10, 2):
        zipped_tensor(tmp_path / f"{k}.pt", falling_elbow(scene))
    tosses = elbow.load_elbow(tmp_path, scene.robot)
    assert [toss.name for toss in tosses] == ["toss 2", "toss 10"]
    assert tosses[0].q[0] == pytest.approx([0, 0, 0.35, 0, 0, 0, 1, 1, 0])
    (window, _) = elbow.windows(tosses, scene)
    # 0.325 m of fall up to a gap of 4 mm: 0.256 s, sample 37.9.
    assert window.t[elbow.BEFORE] == pytest.approx(38 / 148) and len(window.t) == elbow.BEFORE + 10
    zipped_tensor(tmp_path / "3.pt", np.zeros((4, 14)))
    with pytest.raises(InputError, match=r"3\.pt: expected \(T, 15\) numbers of an elbow"):
        elbow.load_elbow(tmp_path, scene.robot)


PARTS = ("yaw", "hip", "hip2", "thigh", "shin", "tarsus", "heel_spring", "toe")
LINKS = ("pelvis", *(f"{part}_{side}" for side in landings.SIDES for part in PARTS))


def biped():
    """A biped with the joints of the data, legs of rods of 0.2 m that bend about y."""
    parts = [link_text(name, 1, 0.01) for name in LINKS]
    for side, y in zip(landings.SIDES, (0.1, -0.1), strict=True):
        chain = (
            ("hip_roll", "pelvis", "yaw", f"0 {y} 0", "1 0 0"),
            ("hip_yaw", "yaw", "hip", "0 0 0", "0 0 1"),
            ("hip_pitch", "hip", "thigh", "0 0 0", "0 1 0"),
            ("knee", "thigh", "hip2", "0 0 -.3", "0 1 0"),
            ("knee_joint", "hip2", "shin", "0 0 0", "0 1 0"),
            ("ankle_joint", "shin", "tarsus", "0 0 -.2", "0 1 0"),
            ("ankle_spring_joint", "tarsus", "heel_spring", "-.1 0 .05", "0 1 0"),
            ("toe", "tarsus", "toe", "0 0 -.2", "0 1 0"),
        )
        for joint, parent, child, origin, axis in chain:
            above = parent if parent == "pelvis" else f"{parent}_{side}"
            ends = (above, f"{child}_{side}")
            parts.append(joint_text(f"{joint}_{side}", "revolute", *ends, axis, at=origin, far=3))
    return robot_text("biped", *parts)


@pytest.fixture(scope="module")
def jump(tmp_path_factory):
    """A recording of the biped that falls at 2 m/s and is stopped within 4 ms, feet first."""
    folder = tmp_path_factory.mktemp("jumps")
    (folder / "cassie_v2.urdf").write_text(biped())
    t = np.arange(100) * 5e-4
    x = np.zeros((100, landings.COLUMNS))
    x[:, 0] = 1.0
    falling = np.interp(t, [0.006, 0.010], [-2.0, 0.0])
    x[:, 6] = 0.712 + np.concatenate([[0.0], np.cumsum(0.5 * (falling[1:] + falling[:-1]) * 5e-4)])
    x[:, 7 + len(landings.JOINTS) + 5] = falling
    for kind, array in zip("txu", (t, x, np.zeros((100, 10))), strict=True):
        np.save(folder / f"{kind}_07.npy", array)
        np.save(folder / f"{kind}_08.npy", array)
    rising = x.copy()
    rising[:, 7 + len(landings.JOINTS) + 5] = 1.0
    np.save(folder / "x_08.npy", rising)
    return folder


def test_touch_down_is_found_and_what_does_not_land_is_named(jump):
    _, found, without = landings.load_landings(jump)
    assert [each.name for each in found] == ["jump 07"] and without == ["jump 08"]
    landing = found[0]
    # The last sample with nine tenths of the speed: 0.4 ms after braking begins.
    assert 0.0495 - landing.t[-1] == pytest.approx(0.006, abs=6e-4)
    assert landing.v[0, 2] == pytest.approx(-2.0, rel=0.1) and landing.t[0] == 0.0
    # The robot falls as one body: rods ask for no motion of the heel springs.
    assert np.abs(landing.v[:, 6:]).max() < 1e-9


def test_errors_of_landings_are_over_the_change(jump):
    robot, (landing,), _ = landings.load_landings(jump)
    kept = landings._error(robot, landing, landing.v[0], 0.011)
    hit = landings._error(robot, landing, landing.v[landing.at(0.011)], 0.011)
    assert kept == pytest.approx(1.0) and hit == 0.0
    assert np.isnan(landings._error(robot, landing, landing.v[0], 0.1))
    free = landings._impact(robot, landing)
    # Stiff legs under the mass centre: an impact without restitution stops the robot.
    locked = landings._impact(robot, landing, locked=landings.JOINTS)
    assert free[0] > locked[0] and locked[0] < 0.2


def test_all_data_in_a_folder_are_found(jump, tmp_path):
    zipped_tensor(tmp_path / "0.pt", np.zeros((4, 15)))
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "a" / "0.pt").write_bytes(pickle.dumps(3))
    for name in ("ellipse_uniform.mat", "other.mat", "cube_tosses_train.npz", "x_03.npy"):
        (tmp_path / "a" / "b" / name).write_bytes(b"")
    kinds = [(kind, place.name) for kind, place in recorded.find_data(tmp_path)]
    assert kinds == [("cube", "a"), ("cube", "cube_tosses_train.npz"), ("elbow", tmp_path.name),
                     ("drops", "ellipse_uniform.mat"), ("landings", "b")]  # fmt: skip
    assert recorded.find_data(jump) == [("landings", jump)]


def test_one_bad_set_of_data_does_not_stop_the_others(tmp_path, capsys):
    (tmp_path / "ellipse_uniform.mat").write_text("nothing")
    (tmp_path / "x_00.npy").write_text("nothing")
    main([str(tmp_path)])
    text = capsys.readouterr().out
    assert "left out: " in text and "no list of planar impacts" in text
    assert "cassie_v2.urdf is missing" in text
