"""The benchmark of integrators: its references hold."""

from impulsekit.bench.integrators import SETTINGS, cases, run


def test_dop853_comes_nearer_the_truth_with_its_tolerance():
    for case in cases():
        rows = [run(case, "dop853", setting) for setting in SETTINGS["dop853"][::2]]
        assert rows[-1].error < 1e-11
        assert rows[-1].error <= rows[0].error + 1e-12
