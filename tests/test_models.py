"""The shipped models: bodies that could be built, frames where their comments say."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from impulsekit.chain import chain_urdf, pendulum_urdf

MODELS = Path(__file__).parents[1] / "models"
FILES = sorted(MODELS.glob("*.urdf"))
ROOTS = {
    "fixed": lambda path: pin.buildModelFromUrdf(str(path)),
    "planar": lambda path: pin.buildModelFromUrdf(str(path), pin.JointModelPlanar()),
    "freeflyer": lambda path: pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer()),
}
every_model = pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)


def test_all_are_here():
    assert {path.stem for path in FILES} >= {
        "ball",
        "billiard_ball",
        "box",
        "cradle_ball",
        "door",
        "double_pendulum",
        "four_bar",
        "gripper",
        "hammer",
        "nail",
        "pendulum_10",
        "rhombus",
        "rod",
        "whittaker_chain_10",
    }


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


def test_the_chain_is_whittakers():
    model = ROOTS["planar"](MODELS / "whittaker_chain_10.urdf")
    assert (model.nq, model.nv) == (13, 12)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    tip = data.oMf[model.getFrameId("link_10")].act(np.array([1.0, 0, 0]))
    np.testing.assert_array_equal(tip, [10, 0, 0])
    assert pin.computeTotalMass(model) == 10


@pytest.mark.parametrize("opening", [0.0, 0.013, 0.04])
def test_the_fingers_open_alike_and_touch_when_closed(opening):
    path = MODELS / "gripper.urdf"
    model = ROOTS["fixed"](path)
    assert list(model.names)[1:] == ["left_slide", "right_slide"]
    geometry = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.COLLISION)
    geometry.addAllCollisionPairs()
    placed, data = geometry.createData(), model.createData()
    pin.updateGeometryPlacements(model, data, geometry, placed, np.full(2, opening))
    names = [
        {geometry.geometryObjects[i].name for i in (pair.first, pair.second)}
        for pair in geometry.collisionPairs
    ]
    fingers = names.index({"left_finger_0", "right_finger_0"})
    gap = pin.computeDistance(geometry, placed, fingers).min_distance
    assert gap == pytest.approx(2 * opening, abs=1e-9)
    pad = np.array([0, 0, 0.06])
    pin.framesForwardKinematics(model, data, np.full(2, opening))
    left = data.oMf[model.getFrameId("left_finger")].act(pad)
    right = data.oMf[model.getFrameId("right_finger")].act(pad)
    np.testing.assert_allclose(left, right * [1, -1, 1], atol=1e-16)


def test_the_four_bar_is_assembled_at_zero_with_crank_and_rocker_upright():
    model = ROOTS["fixed"](MODELS / "four_bar.urdf")
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.zeros(3))
    placement = {name: data.oMf[model.getFrameId(name)] for name in ("crank", "coupler", "rocker")}
    far_pin = placement["coupler"].act(np.array([0.5, 0, 0]))
    np.testing.assert_allclose(far_pin, [0.4, 0.5, 0], atol=1e-15)
    np.testing.assert_allclose(placement["rocker"].act(np.array([0, 0.5, 0])), far_pin, atol=1e-15)
    np.testing.assert_array_equal(placement["coupler"].translation, [0, 0.2, 0])


def test_the_rhombus_closes_at_right_angles():
    model = ROOTS["fixed"](MODELS / "rhombus.urdf")
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.full(3, -np.pi / 2))
    end = data.oMf[model.getFrameId("link_4")].act(np.array([0.5, 0, 0]))
    np.testing.assert_allclose(end, 0, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "density"),
    [("billiard_ball", 1740), ("cradle_ball", 7850), ("nail", 7840), ("door", 278)],
)
def test_masses_are_those_of_their_material(name, density):
    link = next(x for x in ET.parse(MODELS / f"{name}.urdf").iter("link") if len(x))
    shape = link.find("collision/geometry")[0]
    size = {key: [float(x) for x in text.split()] for key, text in shape.attrib.items()}
    if shape.tag == "box":
        volume = np.prod(size["size"])
    elif shape.tag == "sphere":
        volume = 4 / 3 * np.pi * size["radius"][0] ** 3
    else:
        volume = np.pi * size["radius"][0] ** 2 * size["length"][0]
    assert float(link.find("inertial/mass").get("value")) == pytest.approx(
        density * volume, rel=5e-3
    )
