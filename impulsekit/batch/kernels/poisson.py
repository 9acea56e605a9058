"""Poisson's restitution with slip at the end: compression, then P_n ≥ e P_n^c at least.

For one contact or several at once, as ``impact.laws.simultaneous`` has it.
"""

from __future__ import annotations

from ...laws.single import GAIN, strike_at_end
from ...laws.status import Status
from ...laws.words import POISSON
from ..codes import AGAIN
from .coulomb import block_at, is_left
from .jit import built_in
from .layout import CONTACT_INTS
from .many import is_redundant
from .modes import MOST_STEPS, RIDGE, polish
from .problem import COARSE, pose, problem_in, put_back, room
from .several import DEPENDENT, several
from .smooth import ALIKE, FINE
from .uniqueness import judge_feedback

__all__ = ["poisson_lanes"]

NULL = 1e-14
_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_NOT_UNIQUE = int(Status.NOT_UNIQUE)


def poisson_lanes(
    base, rows, target, keeping, contact_ints, contact_floats, given, words, digits,
    work, w_at, before_at, free_at, p_at, w, code,
):  # fmt: skip
    """Write the impulses of all rows, and the codes, for the states of a block from ``base`` on.

    The arguments are those of ``problem.pose``.
    """
    space = room(rows, len(contact_ints) // CONTACT_INTS)
    for lane in range(w):
        count = pose(
            base + lane, lane, rows, target, keeping, contact_ints, contact_floats, given, digits,
            work, w_at, before_at, free_at, w, code, space,
        )  # fmt: skip
        if count > 0:
            code[lane] = _solved(count, digits, space)
        put_back(lane, count, rows, len(target), contact_ints, work, p_at, w, code, space)


@built_in
def _solved(count, digits, space):
    """The code, with P of the contacts that touch in ``space``."""
    line = space[1]
    W, _, free, mus, es, ets, P = problem_in(space)
    smooth = True
    for i in range(count):
        if mus[i] > 0.0:
            smooth = False
            if ets[i] != 0.0:
                # Which is refused.
                return AGAIN
    if count == 1:
        block, u = block_at(W, 0), (free[0], free[1], free[2])
        hit = strike_at_end(block, u, u, es[0], mus[0], 0.0, POISSON)
        P[0], P[1], P[2] = hit.impulse
        close = is_left(block, u, u, es[0], mus[0], 0.0, POISSON, hit, digits)
        return AGAIN if close else hit.code
    b = line[10]
    total, velocity, normal, friction, floor = line[19:24]
    scale = 0.0
    for k in range(3 * count):
        b[k] = free[k]
        total[k] = 0.0
        velocity[k] = free[k]
    for i in range(count):
        normal[i], friction[i] = 0.0, 0.0
        scale = max(scale, abs(free[3 * i + 2]))
    code = several(b, count, smooth, scale, digits, space)
    if code == AGAIN:
        return AGAIN
    _book(W, count, P, total, velocity, normal, friction)
    pressed = False
    for i in range(count):
        floor[i] = es[i] * P[3 * i + 2]
        pressed = pressed or floor[i] > 0.0
        if code == _NOT_UNIQUE and (not smooth or es[i] != es[0]):
            # What comes back depends on how the load was shared.
            return AGAIN
    if pressed:
        if smooth:
            second = _expand_smooth(W, count, scale, digits, space)
        else:
            second = _expand_rough(W, count, digits, space)
        if second == AGAIN:
            return AGAIN
        if code == _SOLVED:
            code = second
        _book(W, count, P, total, velocity, normal, friction)
    size, all_normal, all_friction = 0.0, 0.0, 0.0
    for k in range(3 * count):
        P[k] = total[k]
        size += abs(P[k] * free[k])
    for i in range(count):
        all_normal += normal[i]
        all_friction += friction[i]
        size += abs(normal[i]) + abs(friction[i])
    gained = all_normal + all_friction
    if gained > 0.0 and gained > GAIN * size:
        return _GAIN
    return code if smooth else judge_feedback(code, W, free, mus, count)


@built_in
def _book(W, count, P, total, velocity, normal, friction):
    """Add the impulses P of one part, with what they do and their works."""
    size = 3 * count
    for i in range(count):
        for k in range(3 * i, 3 * i + 3):
            change = 0.0
            for j in range(size):
                change += W[k, j] * P[j]
            work = P[k] * (velocity[k] + 0.5 * change)
            velocity[k] += change
            total[k] += P[k]
            if k == 3 * i + 2:
                normal[i] += work
            else:
                friction[i] += work


@built_in
def _expand_smooth(W, count, scale, digits, space):
    """P of the expansion where nothing rubs; the code."""
    line = space[1]
    P, b, velocity, floor = line[9], line[10], line[20], line[23]
    for k in range(3 * count):
        b[k] = velocity[k]
        for j in range(count):
            b[k] += W[k, 3 * j + 2] * floor[j]
    code = several(b, count, True, scale, digits, space)
    for i in range(count):
        P[3 * i + 2] += floor[i]
    return code


@built_in
def _expand_rough(W, count, digits, space):
    """P of the expansion with friction, from e times that of the compression; the code."""
    square, line, (slip, _, _), (_, mode) = space
    own, way, aim, newton = square[4:]
    mus, es, P = line[2], line[3], line[9]
    b, best, xi, x, moved = line[10:15]
    velocity, floor = line[20], line[23]
    size = 3 * count
    scale, largest = 0.0, 0.0
    for k in range(size):
        i = k // 3
        cleared = mus[i] == 0.0 and k < 3 * i + 2
        b[k] = 0.0 if cleared else velocity[k]
        P[k] = 0.0 if cleared else es[i] * P[k]
        for j in range(size):
            none = cleared or (mus[j // 3] == 0.0 and j % 3 != 2)
            own[k, j] = 0.0 if none else W[k, j]
        scale = max(scale, abs(b[k]))
        largest = max(largest, own[k, k])
    for k in range(0, size, 3):
        if max(own[k, k], own[k + 1, k + 1], own[k + 2, k + 2]) < ALIKE * largest:
            return AGAIN
    residual = polish(
        own, b, mus, floor, count, scale, largest, NULL * largest, FINE, MOST_STEPS, RIDGE, P, best,
        xi, mode, slip, way, aim, newton, x, moved,
    )  # fmt: skip
    if not residual <= 10.0 * FINE:
        return AGAIN
    dependent = DEPENDENT if digits == 53 else COARSE
    redundant = is_redundant(own, mus, count, dependent, largest, P, newton, way, True)
    return _NOT_UNIQUE if redundant else _SOLVED
