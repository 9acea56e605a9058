"""The struck chain of rods in exact arithmetic.

Uniform slender rods, n of them, lie in a straight line, pinned end to end and at
rest; one end is struck at right angles to the line with an impulse P. Point 0 is the
struck end, point k the pin between link k and link k + 1, point n the far end, which
is free (:func:`struck_chain`) or held by a pin (:func:`struck_pendulum`).

Let u_k be the velocity of point k along the blow, and S_k the impulse that link k
gives link k + 1 along the blow, S_0 = P. Momentum and moment of momentum about the
mass centre of link k, whose inertia is m l²/12, read::

    m (u_{k-1} + u_k) / 2 = S_{k-1} - S_k
    m (u_{k-1} - u_k) / 6 = S_{k-1} + S_k

so S_{k-1} = m (2 u_{k-1} + u_k) / 6 and S_k = -m (u_{k-1} + 2 u_k) / 6, hence::

    2 u_0 + u_1 = 6 P / m
    u_{k-1} + 4 u_k + u_{k+1} = 0          0 < k < n
    u_{n-1} + 2 u_n = 0                    free far end (S_n = 0)
    u_n = 0                                pinned far end

Neighbours tend to the ratio -(2 - √3) and u_0 to 2√3 P/m as n grows. The kinetic
energy is P u_0 / 2, half the blow times the velocity that it makes where it acts.

Sources: Whittaker, *Analytical Dynamics*, p. 175; Chang & Huston, "Methods for
studying impact in multibody systems", Computers & Structures 57(3), 1995, Table 1
(the free chain) and example 2 (the chain that hangs from a pin).
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from numbers import Integral
from typing import SupportsIndex, TypeAlias

from impulsekit.errors import InputError, NotFiniteError, RangeError

Number: TypeAlias = int | float | Fraction | Decimal | str
"""int, Fraction, Decimal, text such as ``"0.1"`` or ``"1/3"``, or float, each taken exactly."""


@dataclass(frozen=True, slots=True)
class StruckChain:
    """The response of a chain to a blow on its end, every number an exact fraction.

    Links and points count from the struck end: ``link_rates[0]`` and
    ``centre_velocities[0]`` belong to the struck link, which :func:`impulsekit.models.chain_urdf`
    calls ``link_n``.

    Attributes:
        mass: of each link, kg.
        length: of each link, m.
        impulse: the blow P, N s, at right angles to the chain.
        point_velocities: (n + 1) u_0..u_n, m/s, positive along the blow.
        link_rates: (n) (u_{k-1} - u_k) / l, rad/s; positive turns the way the blow
            turns the link it strikes, that is, counter-clockwise about z for a chain
            along x that is struck towards +y at its end of greatest x.
        centre_velocities: (n) (u_{k-1} + u_k) / 2 of the mass centres, m/s.
        pin_impulses: (n + 1) S_0..S_n, N s, along the blow: S_0 = P, S_k is what link k
            gives link k + 1, S_n what the last link gives the pivot, 0 if there is none.
        energy: kinetic energy P u_0 / 2, J.
    """

    mass: Fraction
    length: Fraction
    impulse: Fraction
    point_velocities: tuple[Fraction, ...]
    link_rates: tuple[Fraction, ...]
    centre_velocities: tuple[Fraction, ...]
    pin_impulses: tuple[Fraction, ...]
    energy: Fraction

    @property
    def links(self) -> int:
        """The number of links n."""
        return len(self.link_rates)

    @property
    def pivot_impulse(self) -> Fraction:
        """The impulse -S_n that the pivot gives the chain, N s along the blow; 0 if free."""
        return -self.pin_impulses[-1]


def struck_chain(
    links: SupportsIndex, mass: Number = 1, length: Number = 1, impulse: Number = 1
) -> StruckChain:
    """Solve the free chain of ``links`` rods, struck at one end (Whittaker, p. 175).

    Args:
        links: how many, at least 1.
        mass: of each link, kg, positive.
        length: of each link, m, positive.
        impulse: the blow P at right angles to the chain, N s, of either sign.

    Raises:
        RangeError: fewer than 1 link, a mass or a length that is not positive.
        NotFiniteError: NaN or an infinity.
        InputError: something that is no number.

    Example:
        >>> blow = struck_chain(10)
        >>> blow.point_velocities[0]
        Fraction(262087, 75658)
        >>> [f"{float(5 * u):.3f}" for u in blow.point_velocities[:4]]
        ['17.321', '-4.641', '1.244', '-0.333']
        >>> struck_chain(1, mass=2, length="0.5", impulse=3).link_rates  # 6 P / (m l)
        (Fraction(18, 1),)
    """
    return _struck(links, mass, length, impulse, pinned=False)


def struck_pendulum(
    links: SupportsIndex, mass: Number = 1, length: Number = 1, impulse: Number = 1
) -> StruckChain:
    """Solve the same chain with its far end on a fixed pin, struck at the free end.

    It hangs straight and at rest; gravity has no part in an impact. The arguments and
    the errors are those of :func:`struck_chain`. Source: Chang & Huston 1995, example 2.

    Example:
        >>> blow = struck_pendulum(2)
        >>> blow.link_rates  # the struck lower rod first
        (Fraction(30, 7), Fraction(-6, 7))
        >>> blow.pivot_impulse
        Fraction(-1, 7)
    """
    return _struck(links, mass, length, impulse, pinned=True)


def _struck(
    links: SupportsIndex, mass: Number, length: Number, impulse: Number, *, pinned: bool
) -> StruckChain:
    n = _count(links)
    m = _positive("mass", mass)
    span = _positive("length", length)
    p = _exact("impulse", impulse)

    # The equations are homogeneous but for the first, so the shape follows from the far
    # end in whole numbers, and the first equation scales it. No fraction grows on the way.
    shape = [0, 1] if pinned else [1, -2]
    while len(shape) <= n:
        shape.append(-4 * shape[-1] - shape[-2])
    shape.reverse()
    scale = 6 * p / (m * (2 * shape[0] + shape[1]))

    u = tuple(scale * s for s in shape)
    near_far = tuple(pairwise(shape))
    sixth = -m * scale / 6
    return StruckChain(
        mass=m,
        length=span,
        impulse=p,
        point_velocities=u,
        link_rates=tuple((scale / span) * (near - far) for near, far in near_far),
        centre_velocities=tuple((scale / 2) * (near + far) for near, far in near_far),
        pin_impulses=(p, *(sixth * (near + 2 * far) for near, far in near_far)),
        energy=p * u[0] / 2,
    )


def _count(links: SupportsIndex) -> int:
    try:
        n = operator.index(links)
    except TypeError:
        raise InputError(f"links must be a whole number, got {links!r}") from None
    if n < 1:
        raise RangeError.of("links", n, "1 or more")
    return n


def _positive(what: str, value: Number) -> Fraction:
    exact = _exact(what, value)
    if exact <= 0:
        raise RangeError.of(what, value, "greater than 0")
    return exact


def _exact(what: str, value: Number) -> Fraction:
    """Return ``value`` as the Fraction that it is."""
    try:
        # int(): a fixed-width integer of an array library would overflow unseen.
        return Fraction(int(value) if isinstance(value, Integral) else value)
    except (OverflowError, ValueError, TypeError, ZeroDivisionError):
        if str(value).strip("+-").lower() in ("nan", "inf", "infinity"):
            raise NotFiniteError.of("the struck chain", what, value) from None
        raise InputError(f"{what} must be a number, got {value!r}") from None
