"""Energetic impacts of several contacts, waves included (Liu, Zhao & Brogliato 2008).

From where contacts touch, impulses grow by ``wave.rates`` until all have parted. Steps are of
order 8 with an error estimate; they end where a contact changes what it does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .borrowed import borrowing
from .compiled import compiled, entry
from .status import BY_CODE, Status
from .wave_changes import STILL_FORCES, change, end_compressions, largest_force
from .wave_holds import acceleration
from .wave_slips import choose_slips
from .wave_state import FAINT, HELD, LOADS, OPEN, Array, Wave
from .wave_state import wave as new_wave
from .wave_steps import APPROACH_ENDED, FIRST, adaptive_step, choose_lead, longest_step

__all__ = ["APPROACH_ENDED", "Waved", "strike_by_energy"]

# Forces this small have ended where nothing moves: they hold energies of 1e-20.
WEAK = 1e-12
MOST_STEPS, MOST_WITH_FRICTION = 40_000, 4_000
# An impact takes some 100 steps: what takes as many as this is stiff, and goes on implicitly.
STIFF = 600
# Where works and velocities differ by more than CLOSED the impact is integrated again, at most
# MOST_AGAIN times: in steps of at most LONGEST_STEP [of the impact's time], then SHORTER
# times that.
CLOSED, LONGEST_STEP, SHORTER, MOST_AGAIN = 1e-10, 0.1, 0.3, 3
# The energy is brought to that of the works where it depends on the impulses by more than this
# share, and is off by less.
STEEP, NEARLY = 1e-3, 1e-9
# A support is met again where it is still approached by more than this share of the velocities.
MET = 1e-9
# Points of the same bodies whose mobilities and velocities differ by less than this share are one:
# friction that turns slip about them is stiffer than velocities are known, and what it does to
# them is no more than this share.
ONE_POINT = 1e-9
_SOLVED, _ENDLESS = int(Status.SOLVED), int(Status.NOT_CONVERGED)
_REFUSED, _NONE = int(Status.REFUSED), int(Status.NO_SOLUTION)


class Waved(NamedTuple):
    """What the contacts did.

    Attributes:
        code: of its ``Status``.
        residual: how far velocities and works are from each other, relative to the energies.
        impulse, after: (3n,) P [N s], u⁺ [m/s].
        normal_work, friction_work: (n,) [J].
        steps: how many.
    """

    code: int
    residual: float
    impulse: Array
    after: Array
    normal_work: Array
    friction_work: Array
    steps: int

    @property
    def status(self) -> Status:
        """How it is to be taken."""
        return BY_CODE[self.code]


# A named tuple made by compiled code would end the process where an interrupt meets it.
PlainWaved = tuple[int, float, Array, Array, Array, Array, int]


def _examples() -> tuple[object, ...]:
    few = np.ones(2)
    return np.eye(6), np.ones(6), few, few, few, 1.5


@entry(_examples, seconds=12.0)
def strike_by_energy(
    W: np.ndarray,
    free: np.ndarray,
    restitution: np.ndarray,
    mu: np.ndarray,
    stiffness: np.ndarray,
    exponent: float,
) -> PlainWaved:
    """The impulses of n contacts: the fields of a ``Waved``.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        free: (3n,) u_free [m/s].
        restitution, mu: (n,) e and friction.
        stiffness: (n,) k in F = k δ^exponent; infinite ones are held from the start.
        exponent: n.

    The code is that of REFUSED where an infinite one is left and met again.
    """
    n = len(mu)
    first, count = _points(W, free, restitution, mu, stiffness)
    if count == n:
        return _strike(W, free, restitution, mu, stiffness, exponent)
    # Of contacts at one point the resultant: their springs are parallel.
    mean, e, rub, total = (
        np.zeros((3 * count, 3 * n)),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
    )
    for i in range(n):
        at = first[i]
        e[at], rub[at] = restitution[i], mu[i]
        total[at] += stiffness[i]
    share = np.ones(n)
    for i in range(n):
        at = first[i]
        share[i] = stiffness[i] / total[at] if total[at] < math.inf else 1.0
        for k in range(3):
            mean[3 * at + k, 3 * i + k] = share[i]
    # The transpose in one piece: numba's product is of contiguous arrays.
    few = np.dot(np.dot(mean, W), mean.T.copy())
    code, residual, P, _, normal, friction, steps = _strike(
        few, np.dot(mean, free), e, rub, total, exponent
    )
    impulse = np.dot(mean.T.copy(), P)
    own, rubbed = np.empty(n), np.empty(n)
    for i in range(n):
        own[i], rubbed[i] = share[i] * normal[first[i]], share[i] * friction[first[i]]
    return code, residual, impulse, free + np.dot(W, impulse), own, rubbed, steps


@compiled
def _points(
    W: np.ndarray, free: np.ndarray, restitution: np.ndarray, mu: np.ndarray, stiffness: np.ndarray
) -> tuple[np.ndarray, int]:
    """(n,) the number of each contact's point, and how many points there are."""
    n = len(mu)
    number, leads = np.zeros(n, np.int64), np.zeros(n, np.int64)
    count = 0
    mobility, speed = 0.0, 0.0
    for k in range(3 * n):
        mobility, speed = max(mobility, W[k, k]), max(speed, abs(free[k]))
    for i in range(n):
        found = -1
        for at in range(count):
            j = leads[at]
            if restitution[i] != restitution[j] or mu[i] != mu[j]:
                continue
            same = stiffness[i] < math.inf and stiffness[j] < math.inf
            for r in range(3):
                same = same and abs(free[3 * i + r] - free[3 * j + r]) <= ONE_POINT * speed
                for k in range(3 * n):
                    apart = abs(W[3 * i + r, k] - W[3 * j + r, k])
                    same = same and apart <= ONE_POINT * mobility
            if same:
                found = at
                break
        if found < 0:
            found, leads[count] = count, i
            count += 1
        number[i] = found
    return number, count


@compiled
def _strike(
    W: np.ndarray,
    free: np.ndarray,
    restitution: np.ndarray,
    mu: np.ndarray,
    stiffness: np.ndarray,
    exponent: float,
) -> PlainWaved:
    """``strike_by_energy`` of contacts at points of their own."""
    n = len(mu)
    speed, mobility = _units(W, free, mu)
    none = np.zeros(n)
    if speed == 0.0 or mobility == 0.0:
        return _SOLVED, 0.0, np.zeros(3 * n), free.copy(), none, none.copy(), 0
    w = _prepared(W, free, restitution, mu, stiffness, exponent, speed, mobility)
    best = _told(w, _run(w, math.inf), W, free, speed, mobility)
    cap = LONGEST_STEP
    for _ in range(MOST_AGAIN):
        if best[1] <= CLOSED or best[0] == _NONE:
            break
        # A change and its end within one step were passed over.
        w = _prepared(W, free, restitution, mu, stiffness, exponent, speed, mobility)
        other = _told(w, _run(w, cap), W, free, speed, mobility)
        if other[1] < best[1]:
            best = other
        cap *= SHORTER
    after = best[3]
    for i in range(n):
        if stiffness[i] == math.inf and after[3 * i + 2] < -MET * speed:
            # A support that was left and met again: how it strikes has no stiffness to tell.
            return _REFUSED, 1.0, best[2], after, best[4], best[5], best[6]
    return best


@compiled
def _told(
    w: Wave, steps: int, W: np.ndarray, free: np.ndarray, speed: float, mobility: float
) -> PlainWaved:
    """What ``strike_by_energy`` gives, after so many steps."""
    n, r = len(w.kappa), len(w.free)
    impulse = np.zeros(3 * n)
    normal, friction = np.zeros(n), np.zeros(n)
    work = speed * speed / mobility
    total = 0.0
    for i in range(n):
        impulse[3 * i + 2] = w.y[w.normal[i]] * speed / mobility
        if w.tangent[i] >= 0:
            for k in range(2):
                impulse[3 * i + k] = w.y[w.tangent[i] + k] * speed / mobility
        lost = w.loaded[i] * (1.0 - w.e2[i])
        rubbed = w.y[r + n + i] if r > n else 0.0
        normal[i], friction[i] = -lost * work, rubbed * work
        total += rubbed - lost
    after = free + W @ impulse
    # Σ P·(u_free + u⁺)/2 is the energy that contacts add.
    added, size = 0.0, 0.0
    for k in range(3 * n):
        added += 0.5 * impulse[k] * (free[k] + after[k])
        size += abs(impulse[k]) * (abs(free[k]) + abs(after[k])) / work
    residual = abs(added / work - total) / size if size > 0.0 else 0.0
    code = _SOLVED
    _to_energy(impulse, free, after, total * work, added, size * work)
    if steps >= MOST_STEPS or not math.isfinite(added):
        code, residual = _ENDLESS, 1.0
    elif _is_wedged(w):
        code = _NONE
    return code, residual, impulse, after, normal, friction, steps


@borrowing
def _to_energy(
    impulse: Array, free: Array, after: Array, total: float, added: float, size: float
) -> None:
    """Scale all impulses by what the steps have left, so that they add the energy of the works.

    A projection onto the energy's surface (Hairer, Lubich & Wanner 2006, IV.4), as far as the
    error of the steps goes; cones are kept. d(added)/d(scale) = P·u⁺.
    """
    slope = 0.0
    for k in range(len(impulse)):
        slope += impulse[k] * after[k]
    if abs(slope) <= STEEP * size or abs(total - added) > NEARLY * abs(slope):
        return
    share = (total - added) / slope
    for k in range(len(impulse)):
        after[k] += share * (after[k] - free[k])
        impulse[k] *= 1.0 + share


@borrowing
def _units(W: np.ndarray, free: np.ndarray, mu: np.ndarray) -> tuple[float, float]:
    """The size of the velocities that count, and of the mobility."""
    speed, mobility = 0.0, 0.0
    for i in range(len(mu)):
        for k in range(0 if mu[i] > 0.0 else 2, 3):
            speed = max(speed, abs(free[3 * i + k]))
            mobility = max(mobility, W[3 * i + k, 3 * i + k])
    approach = 0.0
    for i in range(len(mu)):
        approach = max(approach, -free[3 * i + 2])
    return (speed if approach > APPROACH_ENDED * speed else 0.0), mobility


@compiled
def _prepared(
    W: np.ndarray,
    free: np.ndarray,
    restitution: np.ndarray,
    mu: np.ndarray,
    stiffness: np.ndarray,
    exponent: float,
    speed: float,
    mobility: float,
) -> Wave:
    """The contacts in their units, as they begin."""
    n = len(mu)
    r, stiffest = n, 0.0
    for i in range(n):
        if mu[i] > 0.0:
            r += 2
        if stiffness[i] < math.inf:
            stiffest = max(stiffest, stiffness[i])
    w = new_wave(n, r)
    kept = np.zeros(r, dtype=np.int64)
    row = 0
    for i in range(n):
        w.tangent[i] = -1
        if mu[i] > 0.0:
            w.tangent[i] = row
            kept[row], kept[row + 1] = 3 * i, 3 * i + 1
            row += 2
        w.normal[i], kept[row] = row, 3 * i + 2
        row += 1
        w.kappa[i] = stiffness[i] / stiffest if stiffness[i] < math.inf else math.inf
        w.e2[i], w.mu[i] = restitution[i] ** 2, mu[i]
    for a in range(r):
        w.free[a] = free[kept[a]] / speed
        w.u[a] = w.free[a]
        for b in range(r):
            w.W[a, b] = W[kept[a], kept[b]] / mobility
            if w.W[a, b] != 0.0:
                w.reach[a, 0] = b if w.reach[a, 1] == 0 else w.reach[a, 0]
                w.reach[a, 1] = b + 1
    w.power[0] = exponent
    for i in range(n):
        un = w.free[w.normal[i]]
        if un > APPROACH_ENDED:
            w.mode[i] = OPEN
        else:
            w.mode[i] = HELD if w.kappa[i] == math.inf else LOADS
    return w


@borrowing
def _run(w: Wave, cap: float) -> int:
    """Until no contact presses or approaches, in steps of at most ``cap``; how many they were."""
    step, rubs = FIRST, len(w.free) > len(w.kappa)
    choose_slips(w)
    for count in range(MOST_STEPS):
        if _is_over(w) or (rubs and _is_wedged(w) and not end_compressions(w)):
            return count
        if rubs and count >= MOST_WITH_FRICTION:
            return MOST_STEPS
        if rubs and count == STIFF:
            w.stiff[0] = 1
        choose_lead(w, step)
        h = min(step, longest_step(w), cap)
        crossed, step = adaptive_step(w, h)
        change(w, crossed)
    return MOST_STEPS


@borrowing
def _is_over(w: Wave) -> bool:
    """Whether nothing presses any more and nothing that touches or will touch approaches."""
    r = len(w.free)
    for i in range(len(w.kappa)):
        mode = w.mode[i]
        depth, un = w.y[r + i], w.u[w.normal[i]]
        if mode == HELD:
            if w.force[w.normal[i]] > WEAK:
                return False
        elif un < -APPROACH_ENDED or (
            mode != OPEN and depth > 0.0 and (un > APPROACH_ENDED or w.force[w.normal[i]] > WEAK)
        ):
            return False
    return True


@borrowing
def _is_wedged(w: Wave) -> bool:
    """Whether forces act that move nothing any more: they would stay for ever.

    Forces are told by indentations, which change with normal velocities alone.
    """
    presses, push = False, STILL_FORCES * largest_force(w)
    for i in range(len(w.kappa)):
        row, mode = w.normal[i], w.mode[i]
        un = float(w.u[row])
        if mode == OPEN:
            if un < -FAINT:
                return False
            continue
        if w.force[row] > WEAK:
            if abs(un) > FAINT:
                return False
            presses = True
        for k in range(row if w.tangent[i] < 0 else w.tangent[i], row + 1):
            if abs(acceleration(w, int(k))) > push:
                return False
    return presses
