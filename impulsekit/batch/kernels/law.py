"""Newton's and Poisson's law with slip at the end, for the contacts of one state."""

from __future__ import annotations

from ...laws.approach import block_at
from ...laws.compiled import entry
from ...laws.modes import FINE
from ...laws.progress import Block, Triple
from ...laws.several import newton, poisson
from ...laws.single import Hit, hit_contact
from ...laws.status import Status
from ...laws.tolerances import RESIDUAL_LIMIT
from ...laws.words import NEWTON
from ...laws.workspace import workspace
from ...tolerances import EPS
from ..codes import AGAIN
from .jit import built_in
from .left import LEFT, care_for, is_left
from .problem import problem_in
from .uniqueness import find_others, gives_back_shares, judge_lone, judge_others

__all__ = ["memory", "solved"]

# Where more than this is left ``solve`` refines, or tells that rows are nearly dependent; with
# friction more than FINE, which is 2e-14 to 1e-11 off where three points are nearly one.
ROUGH = 2.0 * FINE
# Of many contacts no less than the rounding of W P, a sum of so many terms, is asked for.
ROUNDED = 0.5 * EPS
_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)
_JAM = int(Status.PAINLEVE_JAM)
_GAIN, _MANY = int(Status.ENERGY_GAIN), int(Status.MANY_SOLUTIONS)


@built_in
def memory(contacts):
    """What the law of several contacts works in."""
    return workspace(max(contacts, 1))


def _one_examples() -> tuple[object, ...]:
    return (1.0,) * 6, (1.0,) * 3, (1.0,) * 3, 0.5, 0.5, 0.0, NEWTON, 53


@entry(_one_examples, seconds=2.0, apart=True)
def _one_touches(
    block: Block,
    before: Triple,
    free: Triple,
    e: float,
    mu: float,
    e_t: float,
    restitution: int,
    digits: int,
) -> tuple[int, float, float, float]:
    """The code and P where one contact alone touches: nothing of it is compiled on the ground."""
    impulse, after, code, residual, normal, friction = hit_contact(
        block, before, free, e, mu, e_t, restitution
    )
    hit = Hit(impulse, after, code, residual, normal, friction)
    left = is_left(block, before, free, e, mu, e_t, restitution, hit, digits)
    if left or (residual > RESIDUAL_LIMIT and code in (_SOLVED, _JAM, _NOT_UNIQUE)):
        code = AGAIN
    elif code in (_NOT_UNIQUE, _MANY):
        code = judge_lone(block, before, free, e, mu, e_t, restitution, impulse, code)
    return code, impulse[0], impulse[1], impulse[2]


@built_in
def solved(count, posed, digits, space, work):
    """The code, with P of the contacts that touch in ``space``."""
    restitution = posed.words[0]
    W, before, free, mus, es, ets, P = problem_in(space)
    smooth = True
    for i in range(count):
        smooth = smooth and mus[i] == 0.0
        if restitution != NEWTON and mus[i] > 0.0 and ets[i] != 0.0:
            # Which is refused.
            return AGAIN
    if count == 1:
        u, start = (before[0], before[1], before[2]), (free[0], free[1], free[2])
        code, P[0], P[1], P[2] = _one_touches(
            block_at(W, 0), u, start, es[0], mus[0], ets[0], restitution, digits
        )
        return code
    care = care_for(digits)
    for i in range(count):
        work.mu[i] = mus[i]
    if restitution == NEWTON:
        code, residual = newton(work, W, before, free, es, ets, count, care)
    else:
        code, residual = poisson(work, W, free, es, count, care)
    # Of answers that gain energy ``solve`` looks for others.
    if code in LEFT or (not smooth and code == _GAIN):
        return AGAIN
    if residual > (ROUGH if smooth else max(FINE, 3.0 * count * ROUNDED)):
        return AGAIN
    for k in range(3 * count):
        P[k] = work.P[k]
    if smooth or code not in (_SOLVED, _NOT_UNIQUE):
        return code
    how, known, others, split = find_others(
        W, before, free, work.velocity, mus, es, ets, count, P, restitution
    )
    gives = restitution != NEWTON and gives_back_shares(mus, es, work.unique, count)
    return judge_others(code, how, known, others, split, gives)
