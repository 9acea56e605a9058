"""The benchmark of integrators: its references hold, and time goes where it should."""

import pytest

from impulsekit.bench.integrators import SETTINGS, cases, run, share_of_libraries


def test_dop853_comes_nearer_the_truth_with_its_tolerance():
    for case in cases():
        rows = [run(case, "dop853", setting) for setting in SETTINGS["dop853"][::2]]
        assert rows[-1].error < 1e-11
        assert rows[-1].error <= rows[0].error + 1e-12


@pytest.mark.slow
def test_flight_of_talos_is_spent_in_pinocchio_and_scipy():
    # Some 82 %; another program on the machine may take its part.
    assert share_of_libraries() > 0.75
