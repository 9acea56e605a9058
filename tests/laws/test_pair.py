"""Two equations, to rounding of what they are made of, whatever their condition."""

import numpy as np
import pytest

from impulsekit.laws.coulomb import bounded_friction
from impulsekit.laws.pair import solve_pair


@pytest.mark.parametrize("thin", [1.0, 1e-4, 1e-8])
def test_what_is_left_is_rounding_of_the_terms(thin):
    rng = np.random.default_rng(0)
    for _ in range(200):
        angle, right = rng.uniform(0.0, np.pi), rng.normal(size=2)
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        matrix = np.outer(along, along) + thin * np.outer(across, across)
        x = solve_pair(matrix[0, 0], matrix[0, 1], matrix[1, 1], *right)
        terms = np.abs(matrix) @ np.abs(x) + np.abs(right)
        assert (np.abs(matrix @ x - right) <= 4e-16 * terms.max()).all()


def test_friction_that_holds_leaves_no_slip_where_a_thin_link_hardly_turns():
    t11, t12, t22 = 904.71451032218454, 1024.838004594408, 1161.0395140665357
    n1, n2, load = 144.33944554437392, 163.56951874767978, 3.9078346430769564
    p1, p2 = bounded_friction((t11, t12, t22, n1, n2, 23.0613762090529), 0.0, 0.0, load, 1.5)
    assert np.hypot(p1, p2) < 1.5 * load
    slip = [t11 * p1 + t12 * p2 + n1 * load, t12 * p1 + t22 * p2 + n2 * load]
    assert np.abs(slip).max() < 2e-12
