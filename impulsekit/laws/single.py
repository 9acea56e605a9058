"""One contact, struck once, with slip at the end: Newton's and Poisson's restitution."""

from __future__ import annotations

from typing import NamedTuple

from .borrowed import borrowing
from .compiled import entry
from .coulomb import coulomb, raising, released, residual_of
from .progress import Block, Triple
from .status import BY_CODE, Status
from .tolerances import GAIN, NEGLIGIBLE
from .words import NEWTON

__all__ = [
    "Hit", "PlainHit", "gained", "hit_at_end", "hit_contact", "largest", "moved",
    "newtons_shift",
    "strike_at_end", "times",
]  # fmt: skip

_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_JAM, _NOT_UNIQUE = int(Status.PAINLEVE_JAM), int(Status.NOT_UNIQUE)


class Hit(NamedTuple):
    """What one contact did.

    Attributes:
        impulse: [N s].
        after: u⁺ [m/s].
        code: of its ``Status``.
        residual: how far it is from the law, relative.
        normal_work, friction_work: [J].
    """

    impulse: Triple
    after: Triple
    code: int
    residual: float
    normal_work: float
    friction_work: float

    @property
    def status(self) -> Status:
        """How it is to be taken."""
        return BY_CODE[self.code]


# A ``Hit`` as compiled code returns it to Python: to make a named tuple there, numba imports
# and calls Python, and an interrupt in the middle of that ends the process.
PlainHit = tuple[Triple, Triple, int, float, float, float]


@entry(lambda: ((1.0,) * 6, (1.0,) * 3, (1.0,) * 3, 0.5, 0.5, 0.0, NEWTON), seconds=2.5, apart=True)
def hit_contact(
    block: Block, before: Triple, free: Triple, e: float, mu: float, e_t: float, restitution: int
) -> PlainHit:
    """``strike_at_end`` as Python calls it: the fields of its ``Hit``."""
    hit = strike_at_end(block, before, free, e, mu, e_t, restitution)
    impulse, after, code, residual, normal, friction = hit
    return impulse, after, code, residual, normal, friction


@borrowing
def newtons_shift(e: float, before: float) -> float:
    """What Newton's law adds to u_n⁺ for complementarity, e min(u_n⁻, 0) [m/s]."""
    return e * before if before < 0.0 else 0.0


@borrowing
def strike_at_end(
    block: Block, before: Triple, free: Triple, e: float, mu: float, e_t: float, restitution: int
) -> Hit:
    """The impulse of one contact.

    Args:
        block: W [1/kg].
        before: u⁻ [m/s].
        free: u_free [m/s].
        e, mu, e_t: restitution, friction, tangential restitution (0 but under Newton's).
        restitution: NEWTON or POISSON.
    """
    up = raising(largest(before, free))
    u, aim = times(up, before), times(up, free)
    hit = _hit(block, u, aim, e, mu, e_t, restitution)
    impulse, _, code, _, normal, friction = hit
    start = u if restitution == NEWTON else aim
    if gained(code, normal, friction, impulse, start, aim):
        code = _GAIN
    return _lowered(hit, code, up)


@borrowing
def hit_at_end(
    block: Block, before: Triple, free: Triple, e: float, mu: float, e_t: float, restitution: int
) -> Hit:
    """``strike_at_end`` without a look at the energy, which one hit of many may raise."""
    up = raising(largest(before, free))
    hit = _hit(block, times(up, before), times(up, free), e, mu, e_t, restitution)
    return _lowered(hit, hit.code, up)


@borrowing
def _hit(
    block: Block, before: Triple, free: Triple, e: float, mu: float, e_t: float, restitution: int
) -> Hit:
    """What the law of restitution says."""
    mu = mu if mu > NEGLIGIBLE else 0.0
    e = e if e > NEGLIGIBLE else 0.0
    scale = max(abs(before[2]), abs(free[2]))
    if mu > 0.0:
        scale = max(scale, abs(free[0]), abs(free[1]), abs(e_t * before[0]), abs(e_t * before[1]))
    if restitution == NEWTON:
        return _newton(block, before, free, e, mu, e_t, scale)
    return _poisson(block, free, e, mu, scale)


@borrowing
def largest(before: Triple, free: Triple) -> float:
    """The size of the velocities [m/s]."""
    return max(
        abs(before[0]), abs(before[1]), abs(before[2]), abs(free[0]), abs(free[1]), abs(free[2])
    )


@borrowing
def _lowered(hit: Hit, code: int, up: float) -> Hit:
    """A hit of velocities that were multiplied by a factor, as one of theirs."""
    impulse, after, _, residual, normal, friction = hit
    down = 1.0 / up
    return Hit(
        times(down, impulse), times(down, after), code, residual, normal * down * down,
        friction * down * down,
    )  # fmt: skip


@borrowing
def times(factor: float, vector: Triple) -> Triple:
    """A vector times a number."""
    return factor * vector[0], factor * vector[1], factor * vector[2]


@borrowing
def _newton(
    block: Block, before: Triple, free: Triple, e: float, mu: float, e_t: float, scale: float
) -> Hit:
    """u⁺ + e∘min(u⁻, 0) and P are complementary."""
    b = (0.0, 0.0, free[2] + newtons_shift(e, before[2]))
    if mu > 0.0:
        b = (free[0] + e_t * before[0], free[1] + e_t * before[1], b[2])
    impulse, code = coulomb(block, b[0], b[1], b[2], mu, scale)
    residual = residual_of(block, b, impulse, mu, 0.0, scale)
    after = moved(block, free, impulse, mu)
    normal, friction = _works(impulse, before, after)
    return Hit(impulse, after, code, residual, normal, friction)


@borrowing
def _poisson(block: Block, free: Triple, e: float, mu: float, scale: float) -> Hit:
    """Compression to u_n = 0, then P_n ≥ e P_n^c (Glocker & Pfeiffer 1995)."""
    pressed, code = coulomb(block, free[0], free[1], free[2], mu, scale)
    residual = residual_of(block, free, pressed, mu, 0.0, scale)
    # What sticks is still, but for velocities that W cannot change: the rounding of larger ones.
    middle = (0.0, 0.0, 0.0) if code == _NOT_UNIQUE else moved(block, free, pressed, mu)
    normal, friction = _works(pressed, free, middle)
    if pressed[2] == 0.0 or e == 0.0:
        return Hit(pressed, middle, code, residual, normal, friction)
    floor = e * pressed[2]
    back, second = released(block, middle, mu, floor, scale)
    residual = max(residual, residual_of(block, middle, back, mu, floor, scale))
    after = moved(block, middle, back, mu)
    if code in (_SOLVED, _JAM, _NOT_UNIQUE) and second != _SOLVED:
        code = second
    more, rubbed = _works(back, middle, after)
    impulse = (pressed[0] + back[0], pressed[1] + back[1], pressed[2] + back[2])
    return Hit(impulse, after, code, residual, normal + more, friction + rubbed)


@borrowing
def moved(block: Block, velocity: Triple, impulse: Triple, mu: float) -> Triple:
    """u + W P; without friction the tangents are left out of it."""
    p1, p2, pn = impulse
    t11, t12, t22, n1, n2, nn = block
    u1, u2, un = velocity[0] + n1 * pn, velocity[1] + n2 * pn, velocity[2] + nn * pn
    if mu > 0.0:
        u1, u2 = u1 + t11 * p1 + t12 * p2, u2 + t12 * p1 + t22 * p2
        un += n1 * p1 + n2 * p2
    return u1, u2, un


@borrowing
def _works(impulse: Triple, start: Triple, after: Triple) -> tuple[float, float]:
    """P·(u_start + u⁺)/2 along the normal and along the tangents."""
    p1, p2, pn = impulse
    normal = 0.5 * pn * (start[2] + after[2])
    return normal, 0.5 * (p1 * (start[0] + after[0]) + p2 * (start[1] + after[1]))


@borrowing
def gained(
    code: int, normal: float, friction: float, impulse: Triple, start: Triple, free: Triple
) -> bool:
    """Whether an impulse that obeys the law raised the energy by more than rounding.

    ``start``: the velocity from which the works count [m/s].
    """
    total = normal + friction
    if not total > 0.0 or code not in (_SOLVED, _JAM, _NOT_UNIQUE):
        return False
    p1, p2, pn = impulse
    by_blows = p1 * (free[0] - start[0]) + p2 * (free[1] - start[1]) + pn * (free[2] - start[2])
    total = min(total, total + 0.5 * by_blows)
    size = abs(p1 * start[0]) + abs(p2 * start[1]) + abs(pn * start[2])
    size += abs(p1 * free[0]) + abs(p2 * free[1]) + abs(pn * free[2])
    return total > GAIN * (size + abs(normal) + abs(friction))
