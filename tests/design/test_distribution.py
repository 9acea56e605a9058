"""Quantiles over a box: a closed form, the order of contacts, errors that fall, bad input."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.design import distribution, worst_impact
from impulsekit.models import pendulum_urdf
from tests.impact.test_outcomes import FALL, phone


def rod_scene():
    rod = ik.Robot.from_urdf(pendulum_urdf(1))
    stop = ik.Contact("link_1", at=[0, 0, -1], normal=[-1, 0, 0])
    return ik.Scene(rod, contacts=[stop], gap_bound=9)


def pin_force(impact):
    return float(np.linalg.norm(impact.joint_loads["joint_1"].force))


def test_quantiles_of_a_uniform_restitution_are_its_own():
    """The pin carries (1 + e)/6 N s."""
    found = distribution(rod_scene(), [0.0], [-1.0], pin_force, restitution=(0, 0.5), samples=2048)
    for share in (0.0, 0.1, 0.5, 0.95, 1.0):
        assert found.quantile(share) == pytest.approx((1 + 0.5 * share) / 6, abs=3e-4)
    worst = worst_impact(rod_scene(), [0.0], [-1.0], "joint_1", restitution=(0, 0.5), samples=8)
    assert found.values.max() <= worst.impulse
    assert found.refused == 0


def test_errors_fall_faster_than_those_of_random_numbers():
    found = distribution(
        rod_scene(), [0.0], [-1.0], pin_force, restitution=(0, 0.5), pose={"joint_1": (0, 0.1)},
        velocity={"joint_1": (-0.5, 0)}, any_order=False, samples=4096,
    )  # fmt: skip
    rows = found.convergence(0.9)
    assert rows[0, 0] == 64
    assert rows[-1, 0] == 4096
    assert rows[-1, 2] < rows[0, 2] / 8
    assert rows[-1, 1] == found.quantile(0.9)
    assert abs(rows[0, 1] - rows[-1, 1]) < 5 * rows[0, 2]


def test_the_order_of_contacts_alone_spreads_what_follows():
    scene = phone()
    q, fall = scene.robot.neutral(), [0, -FALL, 0]

    def rising(impact):
        assert impact.is_valid()
        return float(impact.v_after[1])

    box = {"friction": (1, 1), "samples": 256}
    found = distribution(scene, q, fall, rising, **box)
    assert found.quantile(1.0) == pytest.approx(0.105 * FALL)
    assert found.quantile(0.0) == pytest.approx(0.0, abs=1e-9)
    again = distribution(scene, q, fall, rising, **box)
    assert again.values.tobytes() == found.values.tobytes()
    law = distribution(scene, q, fall, rising, any_order=False, **box)
    assert np.ptp(law.values) < 1e-12


def test_a_batch_gives_bounds_of_outcomes_by_row():
    scene = phone()
    rows = [[0, -FALL, 0], [0, 1, 0], [0.1, -1, 0]]
    batch = ik.solve_batch(
        scene, scene.robot.neutral(), rows, outputs=("outcome_bounds",), friction=[[1, 1]] * 3
    )
    low, high = batch.outcome_bounds[0]
    assert high == pytest.approx(FALL * np.array([0.21, 0.105, 0.21]), abs=1e-9)
    assert low == pytest.approx(FALL * np.array([-0.21, 0, -0.21]), abs=1e-9)
    assert batch.outcome_bounds[1] == pytest.approx(np.array([rows[1], rows[1]]))
    wide = ik.outcomes(scene, scene.robot.neutral(), rows[2]).bounds
    assert batch.outcome_bounds[2] == pytest.approx(wide, abs=1e-3)


def test_a_plot_of_the_spread_names_its_quantiles():
    pytest.importorskip("matplotlib")
    found = distribution(rod_scene(), [0.0], [-1.0], pin_force, restitution=(0, 0.5), samples=64)
    ax = ik.plots.spread(found, "force in the pin [N s]")
    assert ax.get_xlabel() == "force in the pin [N s]"
    assert len(ax.lines) > 3


@pytest.mark.parametrize(
    ("more", "error", "words"),
    [
        ({}, "InputError", "distribution: give restitution=, friction=, velocity= or pose="),
        ({"restitution": (0.5, 0.2)}, "RangeError", "low <= high"),
        ({"restitution": (0.5,)}, "RangeError", "two numbers"),
        ({"velocity": {"knee": (0, 1)}}, "UnknownNameError", "knee"),
        ({"friction": (0, 1), "samples": 0}, "RangeError", "samples"),
        ({"friction": (0, 1), "seed": -1}, "RangeError", "seed"),
    ],
)
def test_bad_input_is_one_clear_error(more, error, words):
    with pytest.raises(getattr(ik.errors, error), match=words):
        distribution(rod_scene(), [0.0], [-1.0], pin_force, **more)


def test_a_share_is_between_nothing_and_all():
    found = distribution(rod_scene(), [0.0], [-1.0], pin_force, restitution=(0, 0.5), samples=64)
    with pytest.raises(ik.errors.RangeError, match="0 to 1"):
        found.quantile(5)
