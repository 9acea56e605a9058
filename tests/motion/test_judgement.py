"""An answer is judged once: solve, batches, motions and the command say the same of it."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main
from impulsekit.errors import InputError

from .models import MODELS

ROUGH_FLOOR = MODELS.parent / "examples" / "rough_floor.toml"


@pytest.fixture(scope="module")
def rough_floor():
    """The paradox of Kane & Levinson (1985), and how deep its floor lies [m]."""
    given = ik.load_scene(ROUGH_FLOOR)
    q = given.q
    return given, -np.cos(q[0]) - np.cos(q[0] + q[1])


def over(rough_floor, height):
    """The scene with its floor so far below the end of the pendulum [m], and no gravity."""
    given, lowest = rough_floor
    floor = replace(given.scene.contacts[0], origin=(0.0, 0.0, lowest - height))
    return replace(given.scene, contacts=(floor,), gravity=(0.0, 0.0, 0.0))


def test_a_motion_does_not_go_on_with_energy_from_nowhere(rough_floor):
    q, v = rough_floor[0].q, rough_floor[0].v
    motion = ik.simulate(over(rough_floor, 0.0), q, v, duration=0.1)
    assert motion.status is ik.MotionStatus.IMPACT_NOT_VALID
    ((time, impact),) = motion.impacts
    assert time == motion.duration == motion.t[-1] == 0.0
    assert impact.status is ik.Status.ENERGY_GAIN
    assert impact.energy.after > 2.0 * impact.energy.before
    # The velocity before it is kept, not the one it would have given.
    np.testing.assert_array_equal(motion.v[-1], v)
    assert "ENERGY_GAIN" in motion.detail
    assert "residual" in motion.detail
    assert "stronge" in motion.detail


def test_flight_before_an_impact_that_is_not_valid_is_kept(rough_floor):
    q, v = rough_floor[0].q, rough_floor[0].v
    scene = over(rough_floor, 0.005)
    motion = ik.simulate(scene, q, v, duration=1.0)
    assert motion.status is ik.MotionStatus.IMPACT_NOT_VALID
    ((time, impact),) = motion.impacts
    assert 0.0 < time == motion.duration < 1.0
    assert impact.status is ik.Status.ENERGY_GAIN
    np.testing.assert_array_equal(motion.v[-1], impact.v_before)
    # Until then energy is what it was.
    np.testing.assert_allclose(motion.energy().kinetic, impact.energy.before, rtol=1e-9)


def test_the_command_fails_on_a_motion_where_it_fails_on_its_impact(rough_floor, tmp_path):
    path = tmp_path / "rough_floor.toml"
    given = rough_floor[0]
    ik.save_scene(path, over(rough_floor, 0.0), given.q, given.v)
    # What the report of an impact explains, stderr names.
    told = {"solve": "energy_gain", "simulate": ik.Status.ENERGY_GAIN.value}
    for command, words in told.items():
        result = CliRunner().invoke(main, [command, str(path)])
        assert result.exit_code == 1
        assert words in result.stderr


def test_no_saltation_passes_through_an_impact_that_is_not_valid(rough_floor):
    q, v = rough_floor[0].q, rough_floor[0].v
    impact = ik.solve(over(rough_floor, 0.0), q, v)
    with pytest.raises(InputError, match=r"not valid.*ENERGY_GAIN"):
        ik.saltation(impact, "floor", acceleration_before=[0, 0], acceleration_after=[0, 0])
