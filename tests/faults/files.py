"""Faults in scene files, and in the studies they hold."""

# One fault a line, however long; wrong types are what it is about.
# ruff: noqa: E501
# mypy: disable-error-code="arg-type, list-item"

from __future__ import annotations

import pathlib

import pinocchio as pin

from impulsekit.batch.study.load import load_study
from impulsekit.batch.study.run import run_study
from impulsekit.batch.study.store import open_study
from impulsekit.batch.study.study import Variation
from impulsekit.robot import Robot
from impulsekit.scene import Actuator, Scene
from impulsekit.scenefile import dump_scene, load_scene, save_scene

from .fault import Fault
from .things import ARM, arm, struck

ROBOT = '[robot]\nurdf = "arm.urdf"\n'
BLOW = '[[impulses]]\nframe = "hand"\nlinear = [1, 0, 0]\nname = "blow"\n'
BATCH = "[batch]\nsamples = 10\n"
SWAY = '[[batch.vary]]\nwhat = "velocity"\nlow = -1\nhigh = 1\n'


def _write(name: str, text: str | bytes) -> str:
    pathlib.Path("arm.urdf").write_text(ARM)
    pathlib.Path(name).write_bytes(text.encode() if isinstance(text, str) else text)
    return name


def _scene(what: str, text: str | bytes, name: str = "scene.toml") -> Fault:
    return Fault(what, lambda: load_scene(_write(name, text)))


def _table(what: str, table: str) -> Fault:
    return _scene(what, ROBOT + table)


def _study(what: str, text: str) -> Fault:
    return Fault(what, lambda: load_study(_write("study.toml", ROBOT + BLOW + text)))


def _vary(what: str, entry: str) -> Fault:
    return _study(what, f"{BATCH}[[batch.vary]]\n{entry}")


def _folder() -> None:
    pathlib.Path("scenes").mkdir()
    load_scene("scenes")


def _model() -> None:
    dump_scene(Scene(Robot.from_model(pin.buildSampleModelManipulator())))


def _changed_robot() -> None:
    path = pathlib.Path("changing.urdf")
    path.write_text(ARM)
    scene = Scene(Robot.from_urdf("changing.urdf"))
    path.write_text(ARM.replace('name="arm"', 'name="leg"'))
    save_scene("changed.toml", scene)


def _own_root() -> None:
    dump_scene(Scene(Robot.from_urdf(ARM, pin.JointModelSpherical())))


def _another_store() -> None:
    run_study(load_study(_write("study.toml", ROBOT + BLOW + BATCH + SWAY)), "rows")
    other = BATCH.replace("10", "12") + SWAY
    run_study(load_study(_write("study.toml", ROBOT + BLOW + other)), "rows")


def _store_in_use() -> None:
    pathlib.Path("letters").mkdir()
    pathlib.Path("letters", "dear.txt").write_text("")
    run_study(load_study(_write("study.toml", ROBOT + BLOW + BATCH + SWAY)), "letters")


_FILES = (
    Fault("loads a scene file that does not exist", lambda: load_scene("no_scene.toml")),
    Fault("loads a folder as a scene", _folder),
    Fault("loads None as a scene", lambda: load_scene(None)),
    Fault("loads a number as the file of a robot", lambda: Robot.from_file(3)),
    Fault("loads a device as a scene", lambda: load_scene("/dev/zero")),
    _scene("leaves a quote open", ROBOT.replace('urdf"', "urdf"), "quote.toml"),
    _scene("writes a scene in Latin-1", '[robot]\nurdf = "Gerät.urdf"\n'.encode("latin-1"), "latin.toml"),
    _scene("gives a key twice", ROBOT + 'urdf = "arm.urdf"\n', "twice.toml"),
    _scene("gives an empty file", "", "nothing.toml"),
    _scene("nests lists five hundred deep", ROBOT + "x = " + "[" * 500 + "]" * 500, "deep.toml"),
    _scene("gives [robot] and [robots]", ROBOT + '[robots.ball]\nurdf = "arm.urdf"\n'),
    _scene("gives a robot neither urdf nor example", '[robot]\nroot = "fixed"\n'),
    _scene("gives a robot urdf and example", ROBOT + 'example = "panda"\n'),
    _scene("names a URDF that does not exist", '[robot]\nurdf = "leg.urdf"\n'),
    _scene("misspells an example", '[robot]\nexample = "talso"\n'),
    _scene("misspells a root in a file", ROBOT + 'root = "floating"\n'),
    _scene("misspells a key of the robot", ROBOT + 'rot = "fixed"\n'),
    _scene("gives mimic in words", ROBOT + 'mimic = "yes"\n'),
    _scene("gives one package folder without a list", ROBOT + 'package_dirs = "meshes"\n'),
    _scene("names a robot with a slash", '[robots."a/b"]\nurdf = "arm.urdf"\n'),
    _scene("places a robot twice over", '[robots.a]\nurdf = "arm.urdf"\nplacement = {xyz = [0, 0, 1], matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}\n'),
    _scene("puts gravity below a table", ROBOT + "gravity = [0, 0, -9.81]\n"),
    _scene("gives gravity one number in a file", "gravity = -9.81\n" + ROBOT),
    _table("misspells a section", '[[impulse]]\nframe = "hand"\n'),
    _table("writes [impulses] with single brackets", '[impulses]\nframe = "hand"\n'),
    _table("misspells a key of an impulse", '[[impulses]]\nframe = "hand"\nlinaer = [1, 0, 0]\n'),
    _table("gives a unit with a number", '[[impulses]]\nframe = "hand"\nlinear = ["5 N s", 0, 0]\n'),
    _table("strikes an unknown frame in a file", '[[impulses]]\nframe = "hnad"\n'),
    _table("leaves out the frame of an impulse", "[[impulses]]\nlinear = [1, 0, 0]\n"),
    _table("gives a name that clears the screen", '[[impulses]]\nframe = "hand"\nname = "\\u001b[2J"\n'),
    _table("gives an infinite impulse in a file", '[[impulses]]\nframe = "hand"\nlinear = [inf, 0, 0]\n'),
    _table("leaves out the kind of a constraint", '[[constraints]]\njoint = "elbow"\n'),
    _table("misspells the kind of a constraint", '[[constraints]]\nkind = "joint_loc"\njoint = "elbow"\n'),
    _table("gives the kind of a contact as a number", "[[contacts]]\nkind = 3\n"),
    _table("gives a contact's restitution above 1 in a file", '[[contacts]]\nkind = "contact"\nframe = "hand"\nrestitution = 1.5\n'),
    _table("gives a law twice", "[law]\n[[law]]\n"),
    _table("misspells a law in a file", '[law]\nrestitution = "newon"\n'),
    _table("misspells a key of [state]", "[state.p]\nelbow = 1\n"),
    _table("misspells a joint in [state.q]", "[state.q]\nelbw = 1\n"),
    _table("gives a state in words", '[state.q]\nelbow = "bent"\n'),
    _table("gives a state q too long", "[state]\nq = [0, 0, 0]\n"),
    _table("gives a state as text", '[state]\nq = "home"\n'),
    _table("gives a stiffness in words", '[[forces]]\nkind = "joint_spring"\njoint = "elbow"\nstiffness = "stiff"\n'),
    _table("misspells a setting of [motion]", "[motion]\ntime = 2\n"),
    _table("gives a negative duration in a file", "[motion]\nduration = -2\n"),
    _table("reports an unknown frame", '[[report.points]]\nframe = "hnad"\n'),
    _table("misspells [[report.points]]", '[[report.point]]\nframe = "hand"\n'),
    _table("designs for an unknown joint", '[[design.points]]\nframe = "hand"\njoint = "elbw"\n'),
    _table("makes three faults at once", '[[impulses]]\nframe = "hnad"\n[law]\nslip = "start"\n[motion]\nsamples = 0\n'),
    Fault("writes a robot that came as a pin.Model", _model),
    Fault("writes a robot on a root of its own", _own_root),
    Fault("writes a robot whose file has changed", _changed_robot),
    Fault("writes a function", lambda: dump_scene(Scene(arm(), forces=[Actuator("elbow", lambda t, q, v: 1.0)]))),
    Fault("writes a scene with a q too short", lambda: dump_scene(struck(), [0.0])),
)  # fmt: skip

_STUDIES = (
    Fault("runs a study of a scene without [batch]", lambda: load_study(_write("plain.toml", ROBOT + BLOW))),
    _study("leaves out how many samples", "[batch]\nseed = 1\n"),
    _study("wants 0 rows", "[batch]\nsamples = 0\n"),
    _study("wants half a row", "[batch]\nsamples = 0.5\n"),
    _study("wants an unknown output of a study", BATCH + 'outputs = ["v_afer"]\n'),
    _study("misspells a key of [batch]", BATCH + "chunks = 10\n"),
    _study("gives [batch] a list", "[[batch]]\nsamples = 10\n"),
    _vary("varies something unknown", 'what = "colour"\nlow = 0\nhigh = 1\n'),
    _vary("varies without bounds", 'what = "velocity"\n'),
    _vary("varies between bounds upside down", 'what = "velocity"\nlow = 1\nhigh = -1\n'),
    _vary("draws from an unknown distribution", 'what = "velocity"\ndistribution = "gauss"\n'),
    _vary("draws with a negative deviation", 'what = "velocity"\ndistribution = "normal"\ndeviation = -1\n'),
    _vary("draws with no deviation", 'what = "velocity"\ndistribution = "normal"\n'),
    _vary("varies a restitution up to 2", 'what = "restitution"\nlow = 0\nhigh = 2\n'),
    _vary("varies a friction that is not there", 'what = "friction"\nlow = 0\nhigh = 1\n'),
    _vary("varies an unknown impulse", 'what = "impulse"\nof = "blw"\nlow = 0\nhigh = 1\n'),
    _vary("varies an unknown joint", 'what = "velocity"\nof = "elbw"\nlow = 0\nhigh = 1\n'),
    Fault("varies by words", lambda: Variation("velocity", low="little", high=1.0)),
    Fault("goes on with another study in a store", _another_store),
    Fault("stores a study in a folder of letters", _store_in_use),
    Fault("opens a list as a store", lambda: open_study(["rows"])),
    Fault("opens a store that does not exist", lambda: open_study("no_rows")),
)  # fmt: skip

FAULTS = (*_FILES, *_STUDIES)
