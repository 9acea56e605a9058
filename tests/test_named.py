"""Results are found by name, by place and in order; unknown names are told with the nearest."""

import json
import pickle

import pytest

import impulsekit as ik
from impulsekit.errors import ImpulsekitError, UnknownNameError


def landed_quadruped():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    feet = [ik.Contact(f"{leg}_FOOT", name=f"{leg} foot", friction=0.5) for leg in ("FL", "HR")]
    lock = ik.JointLock("FL_KFE", name="knee")
    scene = ik.Scene(robot, constraints=[lock], contacts=feet)
    return ik.solve(scene, robot.neutral(), robot.velocity(root_joint=[0, 0, -1, 0, 0, 0]))


def test_contacts_and_constraints_are_found_by_name_and_by_place():
    impact = landed_quadruped()
    assert impact.contacts["HR foot"] is impact.contacts[1]
    assert impact.contacts.names == ("FL foot", "HR foot")
    assert impact.constraints["knee"] is impact.constraints[0]
    assert [result.name for result in impact.contacts] == ["FL foot", "HR foot"]
    assert impact.contacts[-1:].names == ("HR foot",)
    assert len(impact.contacts) == 2 and isinstance(impact.contacts, tuple)
    assert "FL foot" in impact.contacts and "FR foot" not in impact.contacts
    assert impact.contacts.get("FR foot") is None


@pytest.mark.parametrize(
    ("results", "name", "nearest"),
    [
        ("contacts", "FL fot", "FL foot"),
        ("constraints", "kne", "knee"),
        ("bodies", "FL_FOOTT", "FL_FOOT"),
        ("reactions", "FL_KFEE", "FL_KFE"),
        ("impulse_shares", "FL fooot", "FL foot"),
    ],
)
def test_an_unknown_name_is_told_with_the_nearest(results, name, nearest):
    found = getattr(landed_quadruped(), results)
    with pytest.raises(UnknownNameError, match=f'"{name}"; did you mean "{nearest}"') as caught:
        found[name]
    assert isinstance(caught.value, KeyError) and isinstance(caught.value, ImpulsekitError)
    assert caught.value.nearest[0] == nearest
    assert found.get(name) is None
    assert name not in found


def test_results_by_name_cannot_be_changed_and_are_pickled():
    impact = landed_quadruped()
    with pytest.raises(TypeError):
        impact.reactions["FL_KFE"] = None
    with pytest.raises(TypeError):
        impact.contacts["FL foot"] = None
    again = pickle.loads(pickle.dumps(impact.contacts))
    assert again["HR foot"].impulse == pytest.approx(impact.contacts["HR foot"].impulse, abs=0)
    assert pickle.loads(pickle.dumps(impact.bodies)).keys() == impact.bodies.keys()
    json.dumps(impact.to_dict(), allow_nan=False)
