"""The exact struck chain against the paper, the laws of momentum and a dense solve."""

import math
from decimal import Decimal
from fractions import Fraction as F

import pytest

from impulsekit.errors import InputError, NotFiniteError, RangeError
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
