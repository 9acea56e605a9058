"""Contacts one after the other in batches, against single solves."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError
from impulsekit.laws.status import Status
from tests.batch.compare import random_states, worst_difference

pytest.importorskip("numba")

FEET = ("FR_FOOT", "FL_FOOT", "HR_FOOT", "HL_FOOT")
LAWS = {name: ik.Law(restitution=name, order="sequential") for name in ("newton", "poisson")}


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


@pytest.mark.slow
@pytest.mark.parametrize("restitution", LAWS)
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_four_feet(solo, restitution, friction):
    values = (0.5, 0.0, 0.8, ik.RestitutionTable([0.0, 2.0], [0.9, 0.2]))
    contacts = [
        ik.Contact(f, restitution=e, friction=friction) for f, e in zip(FEET, values, strict=True)
    ]
    scene = ik.Scene(solo, contacts=contacts, law=LAWS[restitution])
    q, v = random_states(solo, 150)
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("restitution", LAWS)
def test_beside_a_held_foot_and_joint_stops(solo, restitution):
    contacts = [
        ik.Contact("FR_FOOT", restitution=0.6, friction=0.5),
        ik.JointStop("HL_HFE", upper=0.3, restitution=0.4),
        ik.JointStop("HR_KFE", lower=-0.2, restitution=0.9),
    ]
    scene = ik.Scene(
        solo,
        constraints=[ik.PointAnchor("FL_FOOT")],
        contacts=contacts,
        law=LAWS[restitution],
    )
    q, v = random_states(solo, 150, seed=1)
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


def test_superballs_grip(solo):
    contacts = [
        ik.Contact(f, restitution=0.7, friction=0.6, tangential_restitution=0.5) for f in FEET[:2]
    ]
    scene = ik.Scene(solo, contacts=contacts, law=LAWS["newton"])
    q, v = random_states(solo, 100)
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12
    with pytest.raises(InputError, match="tangential restitution"):
        ik.Scene(solo, contacts=contacts, law=LAWS["poisson"])


def test_even_approaches_are_left_to_the_single_path(solo):
    contacts = [ik.Contact("FR_FOOT", restitution=0.5) for _ in range(2)]
    scene = ik.Scene(solo, contacts=contacts, law=LAWS["newton"])
    q, v = random_states(solo, 20)
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


def test_a_sequence_without_end_is_told():
    """Between two walls that give back what they get, a slider goes to and fro for ever."""
    robot = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    walls = [
        ik.Contact("box", normal=[1, 0, 0], restitution=1.0),
        ik.Contact("box", normal=[-1, 0, 0], restitution=1.0),
    ]
    scene = ik.Scene(robot, contacts=walls, law=LAWS["newton"])
    batch = ik.solve_batch(scene, robot.neutral(), np.array([[1.0, 0, 0, 0, 0, 0]]))
    assert batch.status[0] == Status.NOT_CONVERGED
