"""The URDFs of chains: what they say, and that Pinocchio makes of them what Whittaker has."""

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest

from impulsekit.chain import chain_urdf, pendulum_urdf

writers = pytest.mark.parametrize("write", [chain_urdf, pendulum_urdf])


@writers
def test_every_number_round_trips(write):
    mass, length, radius = 1 / 3, 0.1 + 0.2, 1e-3 / 7
    root = ET.fromstring(write(4, mass, length, radius=radius))
    links = [link for link in root.iter("link") if link.find("inertial") is not None]
    assert len(links) == 4
    for link in links:
        inertia = {k: float(x) for k, x in link.find("inertial/inertia").attrib.items()}
        axial = "ixx" if write is chain_urdf else "izz"
        assert inertia.pop(axial) == mass * radius * radius / 2
        assert sorted(inertia.values()) == [0, 0, 0, *[mass * length * length / 12] * 2]
        assert float(link.find("inertial/mass").get("value")) == mass
        for cylinder in link.iter("cylinder"):
            assert (float(cylinder.get("length")), float(cylinder.get("radius"))) == (
                length,
                radius,
            )
    ends = [j.find("origin").get("xyz").split() for j in root.iter("joint")][-3:]
    tip = [length, 0, 0] if write is chain_urdf else [0, 0, -length]
    assert [[float(x) for x in end] for end in ends] == [tip] * 3


@writers
def test_the_drawn_rod_lies_where_the_mass_is(write):
    text = write(2, length=0.7)
    model = pin.buildModelFromXML(text)
    for kind in (pin.GeometryType.VISUAL, pin.GeometryType.COLLISION):
        geometry = pin.buildGeomFromUrdfString(model, text, kind)
        data, placed = model.createData(), geometry.createData()
        pin.updateGeometryPlacements(model, data, geometry, placed, pin.neutral(model))
        tip = np.array([1.0, 0, 0] if write is chain_urdf else [0, 0, -1.0])
        for k, place in enumerate(placed.oMg):
            np.testing.assert_allclose(place.translation, (k + 0.5) * 0.7 * tip, atol=1e-15)
            np.testing.assert_allclose(np.abs(place.rotation[:, 2]), np.abs(tip), atol=1e-15)
