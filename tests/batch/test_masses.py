"""Masses that vary, against robots that were made with these masses."""

import numpy as np
import pytest

import impulsekit as ik
from tests.batch.compare import random_states

LINKS = ("base_link", "FR_LOWER_LEG", "FR_FOOT", "HL_UPPER_LEG")


def made_heavier(text, name, factor):
    """The URDF with mass and inertia of one link so many times as large."""
    from xml.etree import ElementTree

    tree = ElementTree.fromstring(text)
    (link,) = (one for one in tree.findall("link") if one.get("name") == name)
    inertial = link.find("inertial")
    inertial.find("mass").set("value", repr(factor * float(inertial.find("mass").get("value"))))
    tensor = inertial.find("inertia")
    for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        tensor.set(key, repr(factor * float(tensor.get(key))))
    return ElementTree.tostring(tree, encoding="unicode")


@pytest.mark.parametrize("restitution", [0.3, lambda speed: 0.3], ids=["kernel", "row by row"])
def test_against_urdfs_with_these_masses(restitution):
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    links = [link.name for link in solo.links if link.mass > 0]
    chosen = [name for name in LINKS if name in links]
    assert len(chosen) >= 3
    contact = ik.Contact("FR_FOOT", friction=0.5, restitution=restitution)
    blow = ik.AppliedImpulse("base_link", [0.3, -0.2, -1], [0.1, 0, 0.2])
    rng = np.random.default_rng(0)
    q, v = random_states(solo, 12)
    factors = {name: rng.uniform(0.3, 3.0, 12) for name in chosen}
    scene = ik.Scene(solo, [blow], contacts=[contact])
    batch = ik.solve_batch(scene, q, v, masses=factors, outputs=("v_after", "energy_change"))
    for i in range(12):
        text = solo.parts[0].urdf
        for name, values in factors.items():
            text = made_heavier(text, name, float(values[i]))
        heavier = ik.Robot.from_urdf(text, root="freeflyer")
        impact = ik.solve(ik.Scene(heavier, [blow], contacts=[contact]), q[i], v[i])
        size = np.abs(impact.v_after).max()
        assert np.abs(batch.v_after[i] - impact.v_after).max() < 1e-12 * size
        assert batch.energy_change[i] == pytest.approx(impact.energy.change, rel=1e-10)


def test_rows_out_of_range_and_links_that_cannot_be_scaled():
    panda = ik.Robot.from_example("panda")
    scene = ik.Scene(panda, [ik.AppliedImpulse("panda_hand", [0, 0, 1])])
    q, _ = random_states(panda, 5)
    batch = ik.solve_batch(scene, q, masses={"panda_hand": [1, 2, 0, np.nan, -1]})
    assert batch.valid.tolist() == [True, True, False, False, False]
    with pytest.raises(ik.errors.UnknownNameError, match="panda_hand"):
        ik.solve_batch(scene, q, masses={"panda_hnad": 2.0})
    with pytest.raises(ik.errors.InputError, match="fixed to the world"):
        ik.solve_batch(scene, q, masses={"panda_link0": 2.0})
    with pytest.raises(ik.errors.RangeError, match="masses"):
        ik.solve_batch(scene, q, masses={"panda_hand": -2.0})
    with pytest.raises(ik.errors.ShapeError):
        ik.solve_batch(scene, q, masses={"panda_hand": np.ones(4)})
