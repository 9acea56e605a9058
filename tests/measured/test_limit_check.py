"""Joint angles in degrees and slides in millimetres are refused, not followed in silence."""

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.errors import InputError
from impulsekit.measured import Recording, RecordingFormat

PANDA = ik.Robot.from_example("panda")
T = np.arange(50) / 100


def swinging(share=0.4):
    """(T, nq) about the middle of the limits."""
    low, high = PANDA.model.lowerPositionLimit, PANDA.model.upperPositionLimit
    return 0.5 * (low + high) + share * (high - low) * np.sin(5 * T[:, None])


def columns(q, slides=1.0, turns=1.0):
    names = [str(name) for name in PANDA.model.names[1:]]
    units = [slides if "finger" in name else turns for name in names]
    return {
        "t": T,
        **{f"q.{n}": u * q[:, k] for k, (n, u) in enumerate(zip(names, units, strict=True))},
    }


def test_joints_within_their_limits_are_not_noted():
    assert Recording.from_columns(PANDA, columns(swinging())).notes == ()


@pytest.mark.parametrize(
    ("units", "stated"),
    [({"turns": 180 / np.pi}, {"angle": "deg"}), ({"slides": 1e3}, {"length": "mm"})],
)
def test_another_unit_is_told_and_can_be_stated(units, stated):
    given, (name, unit) = columns(swinging(), **units), *stated.items()
    with pytest.raises(InputError, match=f'joint "panda_.*its limits are.*state {name}="{unit}"'):
        Recording.from_columns(PANDA, given)
    read = Recording.from_columns(PANDA, given, RecordingFormat(**stated))
    assert read.q == pytest.approx(swinging(), abs=1e-12)
    assert read.notes == ()


def test_what_lies_outside_in_any_unit_is_noted():
    q = swinging()
    q[:, 3] += 0.5
    (note,) = Recording.from_columns(PANDA, columns(q)).notes
    assert "panda_joint4 is outside its limits" in note
    q[:, 3] += 2e4
    (note,) = Recording.from_columns(PANDA, columns(q)).notes
    assert "panda_joint4" in note
    assert "far outside its limits" in note


def test_an_angle_without_limits_that_turns_often_may_be_in_degrees():
    axle = joint_text("axle", "continuous", "base", "wheel")
    wheel = ik.Robot.from_urdf(robot_text("w", link_text("base"), link_text("wheel", 1), axle))
    (note,) = Recording.from_columns(wheel, {"t": T, "q.axle": 170 * np.sin(5 * T)}).notes
    assert 'axle goes as far as 27 turns; if these are degrees, state angle="deg"' in note
    assert Recording.from_columns(wheel, {"t": T, "q.axle": 3 * np.sin(5 * T)}).notes == ()
