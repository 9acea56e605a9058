"""CSV and Parquet tables as vendors write them; what could be read wrongly is refused."""

import pytest

import impulsekit as ik
from impulsekit.errors import InputError
from impulsekit.measured import RecordingFormat, load_recordings


@pytest.fixture(scope="module")
def ball():
    return ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


HEADER = "t [s];position.x (m);position.y (m);position.z (m);" + ";".join(
    f"quaternion_wxyz[{k}]" for k in range(4)
)
ROWS = ["0;0;0;1,5;1;0;0;0", "0,01;0;0;1,4;1;0;0;0"]


@pytest.mark.parametrize(
    ("text", "heights"),
    [
        ("\n".join([HEADER, *ROWS]), [1.5, 1.4]),
        ("\ufeff# exported\n\n" + "\r\n".join([HEADER, *ROWS]), [1.5, 1.4]),
        ("\n".join([HEADER + ";", *(row + ";" for row in ROWS)]), [1.5, 1.4]),
        ("\n".join([HEADER, *ROWS]).replace(";", "\t"), [1.5, 1.4]),
        ("\n".join([HEADER, *ROWS]).replace(",", ".").replace(";", ","), [1.5, 1.4]),
    ],
)
def test_tables_as_vendors_write_them(ball, tmp_path, text, heights):
    (tmp_path / "a.csv").write_text(text)
    (found,) = load_recordings(tmp_path / "a.csv", ball)
    assert found.q[:, 2].tolist() == heights and found.t.tolist() == [0.0, 0.01]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("t [s]", "t [ms]", r't \[ms\]": state time="ms" in the RecordingFormat'),
        ("(m)", "(in)", "has an unknown unit"),
        ("position.y", "position.x", 'two columns are called "position.x'),
        ("1,5", "1.000,5", 'must hold numbers, got "1.000,5"'),
        ("t [s]", "Export\nt [s]", "names of the columns stand in the first row"),
    ],
)
def test_tables_that_could_be_read_wrongly_are_refused(ball, tmp_path, old, new, message):
    (tmp_path / "a.csv").write_text("\n".join([HEADER, *ROWS]).replace(old, new))
    with pytest.raises(InputError, match=message):
        load_recordings(tmp_path / "a.csv", ball)


def test_a_stated_unit_may_stand_in_the_names(ball, tmp_path):
    text = "\n".join([HEADER, *ROWS]).replace("t [s]", "t [ms]").replace("(m)", "(mm)")
    (tmp_path / "a.csv").write_text(text)
    (found,) = load_recordings(tmp_path / "a.csv", ball, RecordingFormat(time="ms", length="mm"))
    assert found.t[1] == 1e-5 and found.q[0, 2] == 1.5e-3


def test_dates_are_seconds_after_the_first(ball, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    table = pandas.DataFrame({f"quaternion_wxyz[{k}]": [1.0 - min(k, 1)] * 2 for k in range(4)})
    table[[f"position.{k}" for k in "xyz"]] = 0.5
    table["t"] = pandas.to_datetime([1_700_000_000_000_000_000, 1_700_000_000_250_000_000])
    table.to_parquet(tmp_path / "a.parquet")
    (found,) = load_recordings(tmp_path / "a.parquet", ball)
    assert found.t.tolist() == [0.0, 0.25]
    with pytest.raises(InputError, match="t holds dates, which need no unit"):
        load_recordings(tmp_path / "a.parquet", ball, RecordingFormat(time="ns"))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "Format Version,1.23,Take Name,Take 01\n\n,,Rigid Body", "export of Motive"),
        ("a.csv", "Objects\n100\n,,ball\nFrame,Sub Frame,RX", "export of Vicon Nexus"),
        ("a.csv", "Trajectories,,,\n100,,,\n", "export of Vicon Nexus"),
        ("a.tsv", "NO_OF_FRAMES\t2\nNO_OF_CAMERAS\t8", "export of Qualisys Track Manager"),
        ("a.txt", "0.0 1 2 3 0 0 0 1\n0.1 1 2 3 0 0 0 1", "first row holds numbers"),
        ("a.csv", "t,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1", 'column "x"; call it "position.x"'),
        ("a.csv", "timestamp,q\n0,1", 'column "timestamp"; call it "t"'),
        ("a.csv", "t,Quat_W\n0,1", '"Quat_W"; call it "quaternion_xyzw.w"'),
    ],
)
def test_exports_and_names_of_others_are_told_by_what_they_are(ball, tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message):
        load_recordings(tmp_path / name, ball)
