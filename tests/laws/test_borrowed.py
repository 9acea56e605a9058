"""Arrays whose references compiled code does not count."""

import gc
import sys
from typing import NamedTuple

import numpy as np

from impulsekit.laws.borrowed import borrowed
from impulsekit.laws.compiled import compiled, entry


class Pair(NamedTuple):
    rows: np.ndarray
    inner: tuple[np.ndarray, float]


@compiled
def total(row: np.ndarray) -> float:
    found = 0.0
    for value in row:
        found += value
    return found


@entry(lambda: (Pair(np.zeros((1, 1)), (np.zeros(1), 0.0)), np.zeros(1)), seconds=1.0)
def weighed(pair: Pair, out: np.ndarray) -> float:
    own = borrowed(pair)
    made = np.ones(len(own.rows))
    for i in range(len(own.rows)):
        made[i] = total(own.rows[i]) * own.inner[1]
        own.inner[0][i] += made[i]
    borrowed(out)[:] = made
    return total(made)


def test_borrowed_arrays_are_the_same_arrays():
    rng = np.random.default_rng(3)
    rows, sums, out = rng.normal(size=(4, 3)), np.zeros(4), np.zeros(4)
    plain = weighed.py_func(Pair(rows, (sums, 2.0)), out)
    np.testing.assert_allclose(sums, 2.0 * rows.sum(axis=1))
    code = weighed.compile()
    held = [sys.getrefcount(array) for array in (rows, sums, out)]
    for _ in range(3):
        assert abs(code(Pair(rows, (sums, 2.0)), out) - plain) < 1e-14
    gc.collect()
    # Nobody holds them longer than before.
    assert [sys.getrefcount(array) for array in (rows, sums, out)] == held
    np.testing.assert_allclose(sums, 8.0 * rows.sum(axis=1))
    np.testing.assert_allclose(out, 2.0 * rows.sum(axis=1))
