"""Landings are ranked by their predicted impulses as by peak forces of springs and dampers."""

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("torch")

from benchmarks.landing_rank import correlations, rank_correlation


def test_rank_correlation_is_that_of_order_alone():
    a = np.array([3.0, 1.0, 2.0, 5.0])
    assert rank_correlation(a, np.exp(a)) == pytest.approx(1.0, abs=1e-12)
    assert rank_correlation(a, -a) == pytest.approx(-1.0, abs=1e-12)


def test_the_hardest_knee_is_ranked_as_in_a_compliant_simulation():
    hardest, every = correlations(np.radians(2.0), 60)
    assert hardest > 0.95
    assert every > 0.85
