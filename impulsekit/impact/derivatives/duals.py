"""Numbers that carry their derivatives, and functions of the laws that run on them.

The laws are functions of floats. Run on numbers a + Σ bᵢ dxᵢ they give their own derivatives, so
that what is differentiated is the law itself (Griewank & Walther, Evaluating Derivatives, 2008).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType, SimpleNamespace
from typing import Any, TypeAlias

import numpy as np

__all__ = ["Dual", "on_duals", "value_of"]

Number: TypeAlias = "Dual | float"


class Dual:
    """A number and its derivatives (k,) by some parameters; compared by the number alone."""

    __slots__ = ("by", "value")
    # numpy's own numbers leave products with this to it.
    __array_ufunc__ = None

    def __init__(self, value: float, by: np.ndarray) -> None:
        self.value, self.by = value, by

    def __add__(self, other: Number) -> Dual:
        if isinstance(other, Dual):
            return Dual(self.value + other.value, self.by + other.by)
        return Dual(self.value + other, self.by)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.by)

    def __sub__(self, other: Number) -> Dual:
        if isinstance(other, Dual):
            return Dual(self.value - other.value, self.by - other.by)
        return Dual(self.value - other, self.by)

    def __rsub__(self, other: float) -> Dual:
        return Dual(other - self.value, -self.by)

    def __mul__(self, other: Number) -> Dual:
        if isinstance(other, Dual):
            by = other.by * self.value
            by += self.by * other.value
            return Dual(self.value * other.value, by)
        other = float(other)
        return Dual(self.value * other, self.by * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Dual:
        if isinstance(other, Dual):
            value = self.value / other.value
            return Dual(value, (self.by - value * other.by) / other.value)
        return Dual(self.value / other, self.by / other)

    def __rtruediv__(self, other: float) -> Dual:
        value = other / self.value
        return Dual(value, -value / self.value * self.by)

    def __pow__(self, power: float) -> Dual:
        value = self.value**power
        return Dual(value, power * value / self.value * self.by)

    def __abs__(self) -> Dual:
        return self if self.value >= 0.0 else -self

    def __float__(self) -> float:
        return float(self.value)

    def __lt__(self, other: Number) -> bool:
        return bool(self.value < value_of(other))

    def __le__(self, other: Number) -> bool:
        return bool(self.value <= value_of(other))

    def __gt__(self, other: Number) -> bool:
        return bool(self.value > value_of(other))

    def __ge__(self, other: Number) -> bool:
        return bool(self.value >= value_of(other))

    def __eq__(self, other: object) -> bool:
        return bool(self.value == (other.value if isinstance(other, Dual) else other))

    __hash__ = None  # type: ignore[assignment]


def value_of(number: Number) -> float:
    """The number without its derivatives."""
    return number.value if isinstance(number, Dual) else number


def _root(x: Number) -> Number:
    """√x; at 0 without derivatives, which it has none of there."""
    if not isinstance(x, Dual):
        return math.sqrt(x)
    root = math.sqrt(x.value)
    return Dual(root, 0.5 / root * x.by) if root > 0.0 else 0.0


_MATH = SimpleNamespace(sqrt=_root, inf=math.inf)


def on_duals(function: Callable[..., Any], instead: dict[str, Any]) -> Callable[..., Any]:
    """A function of the laws, with all of them that it calls, on numbers with derivatives.

    Args:
        function: as Python runs it.
        instead: by name, what stands in place of a global of these functions.
    """
    return _on_duals(function, {"math": _MATH, **instead}, {})


def _on_duals(
    function: Any, instead: dict[str, Any], made: dict[Any, FunctionType]
) -> FunctionType:
    if function not in made:
        own = {**function.__globals__}
        made[function] = FunctionType(function.__code__, own, function.__name__)
        for name in function.__code__.co_names:
            value = own.get(name)
            if name in instead:
                own[name] = instead[name]
            elif isinstance(value, FunctionType):
                own[name] = _on_duals(value, instead, made)
    return made[function]
