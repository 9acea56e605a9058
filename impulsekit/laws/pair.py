"""Two equations with a symmetric matrix."""

from __future__ import annotations

from .borrowed import borrowing

__all__ = ["Pair", "solve_pair"]

Pair = tuple[float, float]


@borrowing
def solve_pair(a: float, b: float, c: float, r1: float, r2: float) -> Pair:
    """(x₁, x₂) of [[a, b], [b, c]] x = r, regular and positive definite.

    By elimination from the larger diagonal element, which leaves rounding error in A x − r.
    Cramer's rule leaves cond(A) times that, and slip where a long thin link sticks.

    Example:
        >>> solve_pair(2.0, 1.0, 1.0, 3.0, 2.0)
        (1.0, 1.0)
    """
    # + 0.0 turns −0 into 0.
    if a >= c:
        share = b / a
        x2 = (r2 - share * r1) / (c - share * b)
        return (r1 - b * x2) / a + 0.0, x2 + 0.0
    share = b / c
    x1 = (r1 - share * r2) / (a - share * b)
    return x1 + 0.0, (r2 - b * x1) / c + 0.0
