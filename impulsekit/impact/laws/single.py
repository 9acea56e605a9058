"""One contact, struck once, under each law: closed forms in plain floats."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...laws.status import Status
from ...scene.law import RESTITUTIONS, Law
from .coulomb import NOTHING, Impulse, bounded_friction, coulomb, residual_of
from .slide import Block

__all__ = ["Hit", "Triple", "block_of", "strike"]

Triple = tuple[float, float, float]

# Coefficients this small would only underflow.
NEGLIGIBLE = 1e-150
# Work above this share of the energies in play is a gain.
GAIN = 1e-10


@dataclass(slots=True)
class Hit:
    """What one contact did. Impulse [N s], residual, works [J] of normal and friction."""

    impulse: Impulse
    after: Triple
    status: Status
    residual: float
    normal_work: float
    friction_work: float


def strike(
    block: Block,
    before: Triple,
    free: Triple,
    e: float,
    mu: float,
    e_t: float,
    law: Law,
    *,
    from_before: bool = True,
) -> Hit:
    """The impulse of one contact.

    Args:
        block: W [1/kg] as (t1t1, t1t2, t2t2, t1n, t2n, nn).
        before: u⁻ [m/s].
        free: u_free [m/s].
        e, mu, e_t: restitution, friction, tangential restitution.
        law: restitution and slip; the order is of no matter here.
        from_before: with Newton's law at the end, works count from u⁻, else from u_free.
    """
    mu = mu if mu > NEGLIGIBLE else 0.0
    e = e if e > NEGLIGIBLE else 0.0
    scale = max(
        abs(before[2]),
        abs(free[2]),
        *((abs(free[0]), abs(free[1]), abs(e_t * before[0]), abs(e_t * before[1])) if mu else ()),
    )
    if e_t and mu and (law.slip == "path" or law.restitution != "newton"):
        refuse_tangential(law)
    if law.slip == "path":
        return _along_path(block, before, free, e, mu, law)
    if law.restitution == "poisson":
        return _poisson(block, free, e, mu, scale)
    target = e * before[2] if before[2] < 0.0 else 0.0
    if mu:
        b = (free[0] + e_t * before[0], free[1] + e_t * before[1], free[2] + target)
    else:
        b = (0.0, 0.0, free[2] + target)
    impulse, status = coulomb(block, b[0], b[1], b[2], mu, scale)
    residual = residual_of(block, b, impulse, mu, 0.0, scale)
    after = moved(block, free, impulse, mu)
    return booked(impulse, before if from_before else free, after, status, residual)


def _along_path(block: Block, before: Triple, free: Triple, e: float, mu: float, law: Law) -> Hit:
    """``laws.path.follow`` as a hit."""
    from ...laws.path import follow
    from ...laws.progress import path_memory

    memory = path_memory()
    code = follow(block, before[2], free, e, mu, RESTITUTIONS.index(law.restitution), memory)
    u1, u2, un, p1, p2, p, friction, _, _, _, _, _, normal, residual = memory.now.tolist()
    return Hit((p1, p2, p), (u1, u2, un), Status(code), residual, normal, friction)


def block_of(delassus: np.ndarray, i: int) -> Block:
    """W of contact i with itself."""
    own = slice(3 * i, 3 * i + 3)
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = delassus[own, own].tolist()
    return (t11, t12, t22, n1, n2, nn)


def moved(block: Block, velocity: Triple, impulse: Impulse, mu: float) -> Triple:
    """u + W P; without friction the tangents are left out of it."""
    p1, p2, pn = impulse
    t11, t12, t22, n1, n2, nn = block
    if not mu:
        return (velocity[0] + n1 * pn, velocity[1] + n2 * pn, velocity[2] + nn * pn)
    return (
        velocity[0] + t11 * p1 + t12 * p2 + n1 * pn,
        velocity[1] + t12 * p1 + t22 * p2 + n2 * pn,
        velocity[2] + n1 * p1 + n2 * p2 + nn * pn,
    )


def booked(impulse: Impulse, start: Triple, after: Triple, status: Status, residual: float) -> Hit:
    """The hit with its works P·(u_start + u⁺)/2."""
    p1, p2, pn = impulse
    normal = 0.5 * pn * (start[2] + after[2])
    friction = 0.5 * (p1 * (start[0] + after[0]) + p2 * (start[1] + after[1])) if p1 or p2 else 0.0
    return Hit(
        impulse, after, gained(status, normal, friction, impulse, start), residual, normal, friction
    )


def gained(
    status: Status, normal: float, friction: float, impulse: Impulse, start: Triple
) -> Status:
    """The status, or that the energy went up."""
    total = normal + friction
    if total > 0.0 and status.valid:
        p1, p2, pn = impulse
        size = abs(p1 * start[0]) + abs(p2 * start[1]) + abs(pn * start[2])
        if total > GAIN * (size + abs(normal) + abs(friction)):
            return Status.ENERGY_GAIN
    return status


def refuse_tangential(law: Law) -> None:
    """The error that says where tangential restitution has a meaning."""
    raise InputError(
        f'contacts: tangential restitution has no meaning with restitution="{law.restitution}", '
        f'slip="{law.slip}"; it belongs to Law(restitution="newton", slip="end"), or is 0'
    )


def _poisson(block: Block, free: Triple, e: float, mu: float, scale: float) -> Hit:
    """Compression to u_n = 0, then P_n ≥ e P_n^c (Glocker & Pfeiffer 1995)."""
    pressed, status = coulomb(block, free[0], free[1], free[2], mu, scale)
    if not pressed[2] or not e:
        residual = residual_of(block, free, pressed, mu, 0.0, scale)
        return booked(pressed, free, moved(block, free, pressed, mu), status, residual)
    middle = moved(block, free, pressed, mu)
    floor = e * pressed[2]
    back, second = released(block, middle, mu, floor, scale)
    residual = max(
        residual_of(block, free, pressed, mu, 0.0, scale),
        residual_of(block, middle, back, mu, floor, scale),
    )
    after = moved(block, middle, back, mu)
    if status.valid and second is not Status.SOLVED:
        status = second
    one = booked(pressed, free, middle, Status.SOLVED, 0.0)
    two = booked(back, middle, after, Status.SOLVED, 0.0)
    impulse = (pressed[0] + back[0], pressed[1] + back[1], pressed[2] + back[2])
    normal, friction = one.normal_work + two.normal_work, one.friction_work + two.friction_work
    return Hit(
        impulse, after, gained(status, normal, friction, impulse, free), residual, normal, friction
    )


def released(
    block: Block, b: Triple, mu: float, floor: float, scale: float
) -> tuple[Impulse, Status]:
    """Coulomb's law with P_n ≥ floor instead of 0."""
    if floor > 0.0:
        p1, p2 = bounded_friction(block, b[0], b[1], floor, mu) if mu else (0.0, 0.0)
        velocity = b[2] + block[3] * p1 + block[4] * p2 + block[5] * floor
        if velocity >= -1e-15 * scale:
            return (p1, p2, floor), Status.SOLVED
    impulse, status = coulomb(block, b[0], b[1], b[2], mu, scale)
    if impulse[2] < floor * (1.0 - 1e-12):
        return (NOTHING if floor == 0.0 else impulse), Status.NO_SOLUTION
    return impulse, status


def is_finite(values: Triple) -> bool:
    """Whether no entry is NaN or infinite."""
    return math.isfinite(values[0] + values[1] + values[2])
