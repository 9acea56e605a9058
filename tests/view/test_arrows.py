"""Arrows of what constraints carry: where rows and their axes say, whatever the constraint."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.models import pendulum_urdf
from impulsekit.view.arrows import impact_arrows

TIP = np.array([0.0, 0.0, -1.0])
ELSEWHERE = np.array([0.7, 0.3, 0.2])


def arrows_of(*constraints):
    arm = ik.Robot.from_urdf(pendulum_urdf(2))
    blow = ik.AppliedImpulse("link_2", linear=[1.0, 0.2, 0.3], at=[0.0, 0.0, -0.4])
    q = np.array([0.3, 0.5])
    impact = ik.solve(ik.Scene(arm, [blow], constraints=constraints), q, np.zeros(2))
    place = impact.mechanics.frame_placement("link_2")
    found = [a for a in impact_arrows(impact) if a.name.startswith("constraints")]
    return impact.constraints, place, found


def test_a_rod_pushes_along_its_line():
    rod = ik.DistanceAnchor("link_2", "world", at=TIP, other_at=ELSEWHERE)
    (result,), place, (arrow,) = arrows_of(rod)
    way = place.act(TIP) - ELSEWHERE
    impulse = result.impulse[0] * way / np.linalg.norm(way)
    np.testing.assert_allclose(arrow.origin, place.act(TIP), atol=1e-14)
    np.testing.assert_allclose(arrow.vector, impulse, atol=1e-13)


@pytest.mark.parametrize("axes", ["world", "local"])
def test_an_anchor_pushes_in_its_own_axes(axes):
    weld = ik.FrameAnchor("link_2", directions=("x", "ry"), at=TIP, axes=axes)
    (result,), place, found = arrows_of(weld)
    turn = place.rotation if axes == "local" else np.eye(3)
    force, couple = result.impulse
    by_kind = {arrow.kind: arrow.vector for arrow in found}
    np.testing.assert_allclose(by_kind["impulse"], turn @ [force, 0.0, 0.0], atol=1e-13)
    np.testing.assert_allclose(by_kind["couple"], turn @ [0.0, couple, 0.0], atol=1e-13)
