"""The shipped models: bodies that could be built, frames where their comments say."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from impulsekit import Robot, models
from impulsekit.chain import chain_urdf, pendulum_urdf

MODELS = Path(__file__).parents[1] / "models"
FILES = sorted(MODELS.glob("*.urdf"))
every_model = pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)


def test_the_chains_are_what_the_writers_write():
    chain = (MODELS / "whittaker_chain_10.urdf").read_text(encoding="utf-8")
    assert chain == chain_urdf(10, 1.0, 1.0, name="whittaker_chain_10")
    pendulum = (MODELS / "pendulum_10.urdf").read_text(encoding="utf-8")
    assert pendulum == pendulum_urdf(10, 14.5939, 0.3048, name="pendulum_10")


@every_model
def test_it_is_called_like_its_file_and_says_what_it_is(path):
    assert ET.parse(path).getroot().get("name") == path.stem
    comment = path.read_text(encoding="utf-8").split("<!--")[1].split("-->")[0]
    assert "SI units" in comment
    assert "Source: " in comment


@every_model
def test_inertias_follow_from_the_geometry(path):
    for link in ET.parse(path).getroot().iter("link"):
        if link.find("inertial") is None:
            assert link.get("name") == _root_link(path).get("name")
            continue
        mass = float(link.find("inertial/mass").get("value"))
        stated = link.find("inertial/inertia").attrib
        matrix = np.array(
            [[float(stated["i" + "".join(sorted(a + b))]) for b in "xyz"] for a in "xyz"]
        )
        slender = link.get("name").startswith("link_") or path.stem == "rod"
        for drawn in (link.find("visual"), link.find("collision")):
            assert _vector(drawn, "xyz") == _vector(link.find("inertial"), "xyz")
            turn = pin.rpy.rpyToMatrix(np.array(_vector(drawn, "rpy")))
            own = np.diag(_inertia(mass, drawn.find("geometry")[0], slender=slender))
            np.testing.assert_allclose(matrix, turn @ own @ turn.T, rtol=1e-14, atol=1e-16)
        a, b, c = sorted(np.linalg.eigvalsh(matrix))
        assert mass > 0
        assert a > 0
        assert a + b > c


def _root_link(path):
    """The link that is no joint's child: the only one that may be a mere mount."""
    robot = ET.parse(path).getroot()
    children = {joint.find("child").get("link") for joint in robot.iter("joint")}
    return next(link for link in robot.iter("link") if link.get("name") not in children)


def _vector(element, what):
    origin = element.find("origin")
    text = "0 0 0" if origin is None else origin.get(what, "0 0 0")
    return [float(x) for x in text.split()]


def _inertia(mass, shape, *, slender):
    """Principal moments of a uniform solid of this shape, along its own axes."""
    if shape.tag == "sphere":
        return [2 / 5 * mass * float(shape.get("radius")) ** 2] * 3
    if shape.tag == "box":
        x, y, z = (float(s) for s in shape.get("size").split())
        return [
            mass / 12 * (y * y + z * z),
            mass / 12 * (x * x + z * z),
            mass / 12 * (x * x + y * y),
        ]
    radius, length = float(shape.get("radius")), float(shape.get("length"))
    across = mass / 12 * (length**2 + (0 if slender else 3 * radius**2))
    return [across, across, mass / 2 * radius**2]


@every_model
def test_the_visual_is_the_collision_shape_and_touches_no_file(path):
    for link in ET.parse(path).getroot().iter("link"):
        shapes = [
            [(s.tag, s.attrib) for s in link.iterfind(f"{kind}/geometry/*")]
            for kind in ("visual", "collision")
        ]
        assert shapes[0] == shapes[1]
        assert all(tag in {"box", "cylinder", "sphere"} for tag, _ in shapes[0])


@pytest.mark.parametrize("name", ["panda", "panda_collision", "so101", "solo", "solo8", "solo12"])
def test_published_rotors_go_with_their_robot(name):
    robot = Robot.from_example(name)
    rotors = models.rotor_inertias(name)
    geared = robot.with_armature(rotors)
    assert sorted(geared.model.armature[geared.model.armature > 0]) == sorted(rotors.values())
