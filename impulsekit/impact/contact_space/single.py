"""One contact, struck once, under each law: the laws as they take and give Python's objects."""

from __future__ import annotations

import math

import numpy as np

from ...errors import InputError
from ...laws.path import follow
from ...laws.progress import Block, Triple, path_memory
from ...laws.single import Hit, hit_contact
from ...laws.status import Status
from ...laws.tolerances import NEGLIGIBLE
from ...scene.law import RESTITUTIONS, Law

__all__ = ["block_of", "is_finite", "refuse_tangential", "strike"]


def strike(
    block: Block, before: Triple, free: Triple, e: float, mu: float, e_t: float, law: Law
) -> Hit:
    """The impulse of one contact.

    Args:
        block: W [1/kg] as (t1t1, t1t2, t2t2, t1n, t2n, nn).
        before: u⁻ [m/s].
        free: u_free [m/s].
        e, mu, e_t: restitution, friction, tangential restitution.
        law: restitution and slip; the order is of no matter here.
    """
    if e_t and mu > NEGLIGIBLE and (law.slip == "path" or law.restitution != "newton"):
        refuse_tangential(law)
    # One contact alone is Stronge's, whatever its stiffness.
    word = "stronge" if law.restitution == "lzb" else law.restitution
    restitution = RESTITUTIONS.index(word)
    if law.slip == "end":
        hit = Hit(*hit_contact(block, before, free, e, mu, e_t, restitution))
        if hit.status is not Status.MANY_SOLUTIONS:
            return hit
        from ...laws.confirmed import confirmed

        code = confirmed(block, before, free, e, mu, e_t, restitution, hit.impulse)
        return hit._replace(code=code)
    mu = mu if mu > NEGLIGIBLE else 0.0
    e = e if e > NEGLIGIBLE else 0.0
    memory = path_memory()
    code = follow(block, before[2], free, e, mu, restitution, memory)
    u1, u2, un, p1, p2, p, friction, _, _, _, _, _, normal, residual = memory.now.tolist()
    return Hit((p1, p2, p), (u1, u2, un), code, residual, normal, friction)


def block_of(delassus: np.ndarray, i: int) -> Block:
    """W of contact i with itself."""
    own = slice(3 * i, 3 * i + 3)
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = delassus[own, own].tolist()
    return (t11, t12, t22, n1, n2, nn)


def refuse_tangential(law: Law) -> None:
    """The error that says where tangential restitution has a meaning."""
    raise InputError(
        f'contacts: tangential restitution has no meaning with restitution="{law.restitution}", '
        f'slip="{law.slip}"; it belongs to Law(restitution="newton", slip="end"), or is 0'
    )


def is_finite(values: Triple) -> bool:
    """Whether no entry is NaN or infinite."""
    return math.isfinite(values[0] + values[1] + values[2])
