"""Coefficients of restitution and friction: numbers, by speed, by direction, static and kinetic."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

import numpy as np

from ..errors import InputError, RangeError, quoted
from ..errors.calls import public
from .entry import Checked
from .functions import numbers_from
from .numbers import (
    Check,
    NotNegative,
    Vector,
    between,
    keep_table,
    not_negative,
    number,
    optional,
    positive,
)

_coefficient = between(0.0, 1.0)


@dataclass(frozen=True)
class SpeedTable:
    """Values by speed, linear between the points, constant beyond them.

    Subclasses name the check of a value.

    Attributes:
        speeds: (n,) [m/s, rad/s], 0 or more, rising.
        values: (n,) the coefficient at each speed.

    Raises:
        InputError: not a sequence. NotFiniteError: not finite numbers.
        ShapeError: empty, or not as many values as speeds.
        RangeError: speeds that are negative or do not rise, a value that is not allowed.
    """

    coefficient: ClassVar[Any] = staticmethod(number)
    speeds: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        keep_table(self, "speeds", self.coefficient, "0 or more, each above the last", 0.0)

    def __call__(self, speed: float) -> float:
        """The coefficient at a speed [m/s, rad/s]."""
        return float(np.interp(speed, self.speeds, self.values))


@public
@dataclass(frozen=True)
class Restitution(Checked):
    """A coefficient that is zero below a capture speed.

    Attributes:
        value: e above the capture speed, 0 to 1.
        capture_speed: approach speed [m/s, rad/s for a stop] below which e is zero.

    Raises:
        RangeError, NotFiniteError.

    Example:
        >>> bounce = Restitution(0.8, capture_speed=0.01)
        >>> bounce(1.0), bounce(0.005)
        (0.8, 0.0)
    """

    value: Annotated[float, _coefficient]
    capture_speed: NotNegative = 0.0

    def __call__(self, approach_speed: float) -> float:
        """e at an approach speed."""
        return self.value if approach_speed >= self.capture_speed else 0.0


@public
@dataclass(frozen=True)
class RestitutionTable(SpeedTable):
    """A coefficient by approach speed, linear between the points, constant beyond them.

    Attributes:
        speeds: approach speeds [m/s, rad/s for a stop], rising.
        values: e at each, 0 to 1.

    Raises:
        ShapeError, RangeError, NotFiniteError.

    Example:
        >>> RestitutionTable([0.0, 1.0], [1.0, 0.5])(0.5)
        0.75
    """

    coefficient = staticmethod(_coefficient)


def checked_restitution(value: Any, what: str) -> float | Callable[[float], float]:
    """Return a number in [0, 1], or something that gives one for an approach speed."""
    if callable(value):
        return value
    if isinstance(value, str | bytes | dict | list | tuple):
        raise InputError(
            f"{what} must be a number, a Restitution, a RestitutionTable or a function of the "
            f"approach speed, got {quoted(value)}"
        )
    return _coefficient(value, what)


def restitution_at(
    value: float | Callable[[float], float] | str, approach_speed: float, what: str
) -> float:
    """Return e at an approach speed; what a user's own function gives is checked.

    Raises:
        RangeError, NotFiniteError, ShapeError, CallbackError: the function raised, or gave
            something else than 0 to 1.
        InputError: "material", outside of a scene with materials.
    """
    if isinstance(value, str):
        raise InputError(f'{what}: "{value}" needs the Scene(materials=[...]) that has its pair')
    if not callable(value):
        return value
    return _at_speed(value, approach_speed, _coefficient, what)


def _at_speed(function: Any, speed: float, check: Check, what: str) -> float:
    """A coefficient at a speed; what a user's own function gives is checked."""
    if type(function) in (Restitution, RestitutionTable, StaticKinetic, FrictionTable):
        return float(function(speed))
    where = f"{what} at {speed:g} m/s"
    try:
        return check(numbers_from(function, where, 1, speed)[0], where)
    except RangeError as error:
        error.from_function = True
        raise


# A length that is 1 but for rounding: such a vector is kept as it is, to the last digit.
UNIT_AXIS = 4e-16


@public
@dataclass(frozen=True)
class StaticKinetic(Checked):
    """µ of a contact that sticks, and of one that slips. ``friction=(0.6, 0.4)`` is the same.

    Attributes:
        static: |P_t| ≤ static·P_n where it sticks.
        kinetic: |P_t| = kinetic·P_n where it slips; at most ``static``.

    Raises:
        RangeError, NotFiniteError.

    Example:
        >>> StaticKinetic(0.6, 0.4)(0.0), StaticKinetic(0.6, 0.4)(0.1)
        (0.6, 0.4)
    """

    static: NotNegative
    kinetic: NotNegative

    def _check(self, what: str) -> None:
        if self.kinetic > self.static:
            most = f"at most the static one, {self.static:g}"
            raise RangeError.of("StaticKinetic: kinetic", self.kinetic, most)

    def __call__(self, slip_speed: float) -> float:
        """µ at a slip speed [m/s]."""
        return self.kinetic if slip_speed > 0.0 else self.static


@public
@dataclass(frozen=True)
class FrictionTable(SpeedTable):
    """µ by slip speed, linear between the points, constant beyond them.

    Attributes:
        speeds: slip speeds [m/s], 0 or more, rising.
        values: µ at each.

    Raises:
        ShapeError, RangeError, NotFiniteError.

    Example:
        >>> FrictionTable([0.0, 1.0], [0.6, 0.4])(0.5)
        0.5
    """

    coefficient = staticmethod(not_negative)


@public
@dataclass(frozen=True)
class EllipticFriction(Checked):
    """µ by direction: (P₁/µ₁)² + (P₂/µ₂)² ≤ P_n², with maximal dissipation.

    Slip ξ is opposed by P_t = −P_n (µ₁² ξ₁, µ₂² ξ₂)/√(µ₁² ξ₁² + µ₂² ξ₂²) (Goyal, Ruina &
    Papadopoulos 1991; MuJoCo's elliptic cones).

    Attributes:
        first: µ₁, along ``along``. second: µ₂, across it.
        along: a direction in the coordinates of ``against``; its part in the plane counts.

    Raises:
        RangeError, NotFiniteError, ShapeError.

    Example:
        >>> EllipticFriction(0.8, 0.2, along=[0, 2, 0]).along
        (0.0, 1.0, 0.0)
    """

    first: NotNegative
    second: NotNegative
    along: Vector = (1.0, 0.0, 0.0)

    def _check(self, what: str) -> None:
        length = math.hypot(*self.along)
        if not length > 0.0:
            raise RangeError.of(f"{what}: length of along", length, "above zero")
        if abs(length - 1.0) > UNIT_AXIS:
            object.__setattr__(self, "along", tuple(x / length for x in self.along))


Friction: TypeAlias = (
    float
    | tuple[float, float]
    | StaticKinetic
    | FrictionTable
    | EllipticFriction
    | Callable[[float], float]
)


def checked_friction(value: Any, what: str) -> Any:
    """Return a number of 0 or more, a class of this module, or a function of the speed."""
    if isinstance(value, EllipticFriction) or callable(value):
        return value
    if isinstance(value, tuple | list) and len(value) == 2:
        return StaticKinetic(*value)
    return not_negative(value, what)


def checked_stiffness(value: Any, what: str) -> float | None:
    """Return a number above 0, infinity, or None."""
    if isinstance(value, float | np.floating) and value == math.inf:
        return math.inf
    return optional(positive)(value, what)


def _or_material(check: Check) -> Check:
    return lambda value, what: value if is_by_material(value) else check(value, what)


RestitutionLike: TypeAlias = Annotated[float | Callable[[float], float], checked_restitution]
FrictionLike: TypeAlias = Annotated[Friction, checked_friction]
RestitutionOrMaterial: TypeAlias = Annotated[
    float | Callable[[float], float] | Literal["material"], _or_material(checked_restitution)
]
FrictionOrMaterial: TypeAlias = Annotated[
    Friction | Literal["material"], _or_material(checked_friction)
]
Stiffness: TypeAlias = Annotated[float | None, checked_stiffness]
# The share of its work that a spring keeps from giving back; all of it no spring does.
Damping: TypeAlias = Annotated[float, between(0.0, 0.99)] | None


def is_plain(friction: Any) -> bool:
    """Return whether friction is a number."""
    return not (isinstance(friction, EllipticFriction) or callable(friction))


def static_friction(friction: Any, what: str = "friction") -> float:
    """Return µ of a contact that sticks; of an ellipse the larger one."""
    if isinstance(friction, EllipticFriction):
        return max(friction.first, friction.second)
    return friction_at(friction, 0.0, what)


def friction_at(friction: Any, slip_speed: float, what: str = "friction") -> float:
    """Return µ at a slip speed [m/s]; what a user's own function gives is checked.

    Raises:
        RangeError, NotFiniteError, ShapeError, CallbackError: the function raised, or gave
            something else than a number of 0 or more.
    """
    if not callable(friction):
        return float(friction)
    return _at_speed(friction, slip_speed, not_negative, what)


# Of each coefficient that a table gave: its name, what the user gave, and the table's number.
ByTable = tuple[tuple[str, Any, Any], ...]
# What a contact gives instead of a coefficient that the table of pairs has.
BY_MATERIAL = "material"


def is_by_material(value: Any) -> bool:
    """Return whether a coefficient is left to the table of pairs."""
    return isinstance(value, str) and value == BY_MATERIAL


def asks_for_materials(contact: Any) -> bool:
    """Return whether a contact leaves a coefficient to the table of pairs."""
    given = getattr(contact, "restitution", 0.0), getattr(contact, "friction", 0.0)
    return any(map(is_by_material, given))


def keep_from_table(contact: Any, by_table: ByTable) -> None:
    """Keep which coefficients of a contact its table of pairs gave: those that are not replaced."""
    kept = [one for one in by_table if getattr(contact, one[0]) == one[2]]
    object.__setattr__(contact, "_by_table", tuple(kept))


def as_given(contact: Any) -> Any:
    """Return a contact as the user gave it, "material" in place of the pair's numbers."""
    by_table = getattr(contact, "_by_table", ())
    if not by_table:
        return contact
    return replace(contact, _by_table=(), **{name: given for name, given, _ in by_table})
