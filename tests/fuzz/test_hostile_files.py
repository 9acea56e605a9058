"""Files that set out to harm: what fuzzing found, and what is known of XML, TOML and paths."""

from __future__ import annotations

import re
import sys

import pytest

import impulsekit as ik
from impulsekit import errors

CALLED = "socket:"
SECRET = "canary-5d41402abc4b"
LINK = "<link name='a'>{}</link>"


@pytest.fixture
def outside(tmp_path):
    (tmp_path / "secret.txt").write_text(SECRET)
    (tmp_path / "in").mkdir()
    return tmp_path / "in"


@pytest.fixture
def opened():
    """The files that Python opens, and the addresses it calls, while a test runs."""
    paths = []
    listening = [True]

    def listen(event, arguments):
        if listening[0] and event == "open":
            paths.append(str(arguments[0]))
        elif listening[0] and event == "socket.connect":
            paths.append(f"{CALLED}{arguments[1]}")

    sys.addaudithook(listen)
    yield paths
    listening[0] = False


@pytest.mark.parametrize(
    "text",
    [
        "<!DOCTYPE r [<!ENTITY x SYSTEM 'file:../secret.txt'>]>",
        "<!DOCTYPE r SYSTEM 'http://127.0.0.1:9/x.dtd'>",
        "<!DOCTYPE r [<!ENTITY a 'aa'><!ENTITY x '&a;&a;&a;'>]>",
        "",
    ],
)
def test_no_entity_is_expanded_and_nothing_fetched(outside, opened, text):
    (outside / "a.urdf").write_text(f"{text}<robot name='&x;'><link name='a'/></robot>")
    with pytest.raises(errors.UrdfError) as caught:
        ik.Robot.from_urdf(outside / "a.urdf")
    assert SECRET not in str(caught.value)
    assert not [path for path in opened if "secret.txt" in path or path.startswith(CALLED)]


def test_an_include_stays_closed(outside, opened):
    include = (
        "<xi:include xmlns:xi='http://www.w3.org/2001/XInclude' href='../secret.txt' parse='text'/>"
    )
    (outside / "a.urdf").write_text(f"<robot name='r'>{include}{LINK.format(include)}</robot>")
    robot = ik.Robot.from_urdf(outside / "a.urdf")
    _ = robot.visual_model
    assert not [path for path in opened if "secret.txt" in path]


@pytest.mark.parametrize("name", ["/etc/passwd", "../secret.txt"])
def test_what_a_scene_names_as_its_robot_is_never_shown(outside, name):
    (outside / "a.toml").write_text(f'[robot]\nurdf = "{name}"\n')
    with pytest.raises(errors.SceneFileError) as caught:
        ik.load_scene(outside / "a.toml")
    assert SECRET not in str(caught.value)
    assert "root:" not in str(caught.value)
    assert "it is not an XML file" in str(caught.value)


CHAIN = '[robot]\nexample = "panda"\n'


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[[contacts]]\nkind = {}\n", r"contacts\[0\]\.kind: unknown kind"),
        ("[[contacts]]\nkind = [1]\n", r"contacts\[0\]\.kind: unknown kind"),
        ('[[impulses]]\njoint = "panda_joint1"\nimpulse = 1' + "0" * 400, "must be a number"),
        ("[state]\nq = [1" + "0" * 400 + "]\n", "must be"),
        ("[" + "a." * 3000 + "a]\n", "nested too deep|no such key"),
        ("x = " + "[" * 3000, "nested too deep|not well-formed"),
        ('[law]\nslip = "' + "x" * 100_000 + '"\n', r"xxx\.\.\."),
    ],
)
def test_what_fuzzing_found_in_scene_files(tmp_path, table, words):
    (tmp_path / "a.toml").write_text(CHAIN + table)
    with pytest.raises(errors.SceneFileError, match=re.compile(words)) as caught:
        ik.load_scene(tmp_path / "a.toml")
    assert len(str(caught.value)) < 1000 + len(str(tmp_path))


def test_a_link_as_deep_as_it_may_be_is_drawn_and_checked():
    nested = LINK.format("<x>" * 190 + "</x>" * 190)
    robot = ik.Robot.from_urdf(f"<robot name='r'>{nested}</robot>")
    assert len(robot.visual_model.geometryObjects) == 0
    with pytest.raises(errors.UrdfError, match="200 deep"):
        ik.Robot.from_urdf(f"<robot name='r'>{LINK.format('<x>' * 300 + '</x>' * 300)}</robot>")
