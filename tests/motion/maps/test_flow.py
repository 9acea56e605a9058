"""The motion between impacts as a map, while contacts rest."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.motion.maps.flow import Flow

from ..models import GRAVITY, MODELS


@pytest.mark.parametrize("points", [2, 3, 4])
@pytest.mark.parametrize("spin", [0.3, 0.01, 0.001])
def test_a_box_that_spins_on_its_corners_slides_on_all_of_them(points, spin):
    """However slowly: what slips isn't held, which its centripetal accelerations forbid."""
    corners = [(0.15, 0.1), (-0.15, -0.1), (0.15, -0.1), (-0.15, 0.1)]
    box = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
    mu, contacts = 2.0, []
    for x, y in corners[:points]:
        contacts.append(ik.Contact("box", at=[x, y, -0.05], friction=mu, name=f"{x} {y}"))
    flow = Flow(ik.Scene(box, contacts=contacts), [contact.name for contact in contacts])
    q = box.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1])
    rate = flow.acceleration(0.0, q, box.velocity(root_joint=[0, 0, 0, 0, 0, spin]))
    # All corners are as far from the centre, and carry the weight together.
    arm, inertia, mass = np.hypot(0.15, 0.1), 0.0325, 3.0
    np.testing.assert_allclose(rate[5], -mu * mass * GRAVITY * arm / inertia, rtol=1e-9)
    np.testing.assert_allclose(rate[:5], 0.0, atol=1e-9)
