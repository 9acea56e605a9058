"""Arrays whose references compiled code does not count."""

import gc
import sys
from typing import NamedTuple

import numpy as np

from impulsekit.laws.borrowed import borrowed, borrowing
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


@compiled
def doubled(row: np.ndarray) -> float:
    made = np.empty(len(row))
    for k in range(len(row)):
        made[k] = 2.0 * row[k]
    return total(made)


@borrowing
def passed_on(pair: Pair) -> float:
    return doubled(pair.rows[0]) + doubled(pair.inner[0])


@entry(lambda: (np.zeros(1),), seconds=1.0)
def made_and_passed(row: np.ndarray) -> float:
    made = np.ones((2, len(row)))
    return passed_on(Pair(made, (row, 1.0))) + total(made[1])


def test_what_borrows_may_call_what_makes_arrays():
    from numba.core.runtime import _nrt_python, rtsys

    code, row = made_and_passed.compile(), np.arange(3.0)
    _nrt_python.memsys_enable_stats()
    before, held = rtsys.get_allocation_stats(), sys.getrefcount(row)
    assert [code(row) for _ in range(5)] == [15.0] * 5
    after = rtsys.get_allocation_stats()
    _nrt_python.memsys_disable_stats()
    # All that was made is gone, and nothing else is.
    assert after.alloc - before.alloc == after.free - before.free > 0
    assert sys.getrefcount(row) == held
