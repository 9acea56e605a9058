"""The exact struck chain against the paper, the laws of momentum and a dense solve."""

import ast
import math
from decimal import Decimal
from fractions import Fraction as F
from pathlib import Path

import pytest
from hypothesis import strategies as st

from impulsekit.errors import InputError, NotFiniteError, RangeError
from impulsekit.reference import whittaker
from impulsekit.reference.whittaker import struck_chain, struck_pendulum

# Chang & Huston 1995, Table 1, in its own rounding, which grows finer with the point.
TABLE_1 = [
    "17.321",
    "-4.641",
    "1.244",
    "-0.333",
    "0.089",
    "-0.024",
    "0.006",
    "-0.002",
    "0.0005",
    "-0.0001",
    "0.00007",
]

positive = st.fractions(min_value=F(1, 1000), max_value=1000, max_denominator=1000)
blows = st.fractions(min_value=-100, max_value=100, max_denominator=1000)


def test_table_1_in_its_own_rounding():
    u = struck_chain(10, impulse=5).point_velocities
    rounded = [
        f"{float(value):.{len(text.split('.')[1])}f}"
        for value, text in zip(u, TABLE_1, strict=True)
    ]
    assert rounded == TABLE_1


def test_ten_links_are_fractions_over_75658():
    u = struck_chain(10).point_velocities
    assert u[0] == F(262087, 75658)
    assert all((value * 75658).denominator == 1 for value in u)


@pytest.mark.parametrize("strike", [struck_chain, struck_pendulum])
def test_long_chains_tend_to_the_limits(strike):
    u = strike(60, mass=2, impulse=3).point_velocities
    assert float(u[0]) == pytest.approx(2 * math.sqrt(3) * 3 / 2, rel=1e-15)
    assert float(u[11] / u[10]) == pytest.approx(-(2 - math.sqrt(3)), rel=1e-15)


@pytest.mark.parametrize("pinned", [False, True])
@pytest.mark.parametrize("n", [1, 2, 3, 5, 8])
def test_against_a_dense_solve_of_the_impact_equations(n, pinned):
    """a_lp Δy_p = I_l (Chang & Huston 1995, eq. 32), y: far end's velocity and link rates."""
    m, length, p = F(3, 2), F(2, 3), F(7, 5)
    speeds = range(0 if not pinned else 1, n + 1)

    def partial_velocity(y, x):
        """Of the point x links away from the far end, per unit of generalized speed y."""
        return F(1) if y == 0 else length * min(max(x - (y - 1), F(0)), F(1))

    a = [
        [
            sum(
                m * partial_velocity(i, k + F(1, 2)) * partial_velocity(j, k + F(1, 2))
                + m * length**2 / 12 * (i == j == k + 1)
                for k in range(n)
            )
            for j in speeds
        ]
        for i in speeds
    ]
    dy = _solve(a, [p * partial_velocity(i, F(n)) for i in speeds])
    u = [
        sum(partial_velocity(y, F(x)) * d for y, d in zip(speeds, dy, strict=True))
        for x in range(n + 1)
    ]
    blow = (struck_pendulum if pinned else struck_chain)(n, m, length, p)
    assert blow.point_velocities == tuple(reversed(u))
    assert blow.link_rates == tuple(reversed(dy if pinned else dy[1:]))


def _solve(a, b):
    """Gauss without pivoting: the matrix is positive definite and the numbers exact."""
    rows = [[*row, right] for row, right in zip(a, b, strict=True)]
    for i, pivot in enumerate(rows):
        for row in rows[i + 1 :]:
            factor = row[i] / pivot[i]
            row[:] = [x - factor * y for x, y in zip(row, pivot, strict=True)]
    x = [F(0)] * len(rows)
    for i in reversed(range(len(rows))):
        known = sum(rows[i][j] * x[j] for j in range(i + 1, len(rows)))
        x[i] = (rows[i][-1] - known) / rows[i][i]
    return x


@pytest.mark.parametrize("strike", [struck_chain, struck_pendulum])
@pytest.mark.parametrize(
    ("arguments", "error", "word"),
    [
        ({"links": 0}, RangeError, "links"),
        ({"links": 2.0}, InputError, "links"),
        ({"mass": 0}, RangeError, "mass"),
        ({"mass": math.nan}, NotFiniteError, "mass"),
        ({"mass": "heavy"}, InputError, "mass"),
        ({"length": 0.0}, RangeError, "length"),
        ({"length": -math.inf}, NotFiniteError, "length"),
        ({"impulse": math.inf}, NotFiniteError, "impulse"),
        ({"impulse": Decimal("Infinity")}, NotFiniteError, "impulse"),
    ],
)
def test_bad_input_is_one_clear_error(strike, arguments, error, word):
    with pytest.raises(error, match=word) as caught:
        strike(**{"links": 3, **arguments})
    assert type(caught.value) is error


def test_it_stands_on_the_standard_library_alone():
    tree = ast.parse(Path(whittaker.__file__).read_text(encoding="utf-8"))
    imported = {
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for alias in node.names
    }
    imported |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    foreign = {name for name in imported if name.split(".")[0] in {"numpy", "pinocchio"}}
    ours = {name for name in imported if name.startswith("impulsekit")}
    assert not foreign
    assert ours == {"impulsekit.errors"}
