"""Energetic impacts of several contacts, waves included (Liu, Zhao & Brogliato 2008).

From where contacts touch, impulses grow by ``wave.rates`` until all have parted. Steps are of
order 8 with an error estimate; they end where a contact changes what it does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .compiled import borrowing, compiled, entry
from .dop853 import ERROR_3, ERROR_5, FROM, NODES, STAGES, WEIGHTS
from .status import BY_CODE, Status
from .wave import (
    CREEPS,
    HELD,
    LOADS,
    NONE,
    OPEN,
    SLIPS,
    STICKS,
    UNLOADS,
    Array,
    Matrix,
    Wave,
    acceleration,
    any_held,
    force_rate,
    rates,
    smooth_rates,
    velocities,
)
from .wave import wave as new_wave
from .wave_changes import IN_CONE, RISES, change, choose_slips

__all__ = ["AT_REST", "Waved", "strike_by_energy"]

# By how much a flight goes beyond the contact that it leads to; the error below which the next
# step grows as far as it may; how exactly a change is located, as a share of the step.
BEYOND, EXACT, FOUND = 1e-12, 1e-12, 1e-15
# Contacts that end by this much later than the one that leads end with it.
SAME_END = 1.0 + 1e-9
# The error of a step, in units in which velocities, impulses and indentations are of size 1.
# With friction slip may pass 0 at next to no distance, which makes of errors many times as large.
TOLERANCE, WITH_FRICTION = 2e-12, 2e-13
# The first step, in units in which the impact takes about 3.
FIRST = 0.03
# A contact leads the step where its start or end is nearer than this many steps.
NEARBY = 1.5
# A step goes so far towards the end of a contact, where the force has no smooth derivatives.
NEARER = 0.6
# Approaches this small have ended [of the largest velocity].
AT_REST = 1e-10
# Forces this small have ended where nothing moves: they hold energies of 1e-20.
WEAK = 1e-12
# What is beyond a change by less is at it; a step that is none.
_SMALL, NEXT_TO_NOTHING = 1e-14, 1e-9
MOST_STEPS, MOST_WITH_FRICTION = 40_000, 1_500
# Where works and velocities differ by more than CLOSED the impact is integrated again, at most
# MOST_AGAIN times: in steps of at most LONGEST [of the impact's time], then SHORTER times that.
CLOSED, LONGEST, SHORTER, MOST_AGAIN = 1e-10, 0.1, 0.3, 3
# The energy is brought to that of the works where it depends on the impulses by more than this
# share, and is off by less.
STEEP, NEARLY = 1e-3, 1e-9
_SOLVED, _ENDLESS = int(Status.SOLVED), int(Status.NOT_CONVERGED)


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


@entry(_examples, seconds=20.0)
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
    """
    n = len(mu)
    speed, mobility = _units(W, free, mu)
    none = np.zeros(n)
    if speed == 0.0 or mobility == 0.0:
        return _SOLVED, 0.0, np.zeros(3 * n), free.copy(), none, none.copy(), 0
    w = _prepared(W, free, restitution, mu, stiffness, exponent, speed, mobility)
    best = _told(w, _run(w, math.inf), W, free, speed, mobility)
    cap = LONGEST
    for _ in range(MOST_AGAIN):
        if best[1] <= CLOSED:
            break
        # A change and its end within one step were passed over.
        w = _prepared(W, free, restitution, mu, stiffness, exponent, speed, mobility)
        other = _told(w, _run(w, cap), W, free, speed, mobility)
        if other[1] < best[1]:
            best = other
        cap *= SHORTER
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
    return (speed if approach > AT_REST * speed else 0.0), mobility


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
        if un > AT_REST:
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
        if _is_over(w):
            return count
        if rubs and count >= MOST_WITH_FRICTION:
            return MOST_STEPS
        _choose_lead(w, step)
        h = min(step, _longest(w), cap)
        crossed, step = _adaptive_step(w, h)
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
        elif un < -AT_REST or (
            mode != OPEN and depth > 0.0 and (un > AT_REST or w.force[w.normal[i]] > WEAK)
        ):
            return False
    return True


@borrowing
def _rate(w: Wave, i: int) -> float:
    """dδ/dt of a contact that gives way."""
    un = float(w.u[w.normal[i]])
    return -un / float(w.e2[i]) if w.mode[i] == UNLOADS else -un


@borrowing
def _choose_lead(w: Wave, step: float) -> None:
    """Where a contact starts or ends within a step, its √δ is the variable of the step, not t.

    With δ = s² its force κ δ^n has derivatives in s, as δ has where it goes through 0 at a
    speed. Of several the one whose force bends most leads.
    """
    r, power, most = len(w.free), w.power[0], 0.0
    w.lead[0] = -1
    for i in range(len(w.kappa)):
        if w.mode[i] != LOADS and w.mode[i] != UNLOADS:
            continue
        depth, rate = w.y[r + i], _rate(w, i)
        speed = abs(rate)
        # What others press in from rest did not start at a speed.
        pressed = rate > 0.0 and acceleration(w, int(w.normal[i])) < 0.0
        if depth < 0.0 or speed <= AT_REST or pressed or (rate < 0.0 and depth == 0.0):
            continue
        near = depth / speed
        if near < NEARBY * step:
            bend = w.kappa[i] * speed**power * (near + FIRST * step) ** (power - 8.0)
            if bend > most:
                w.lead[0], w.pace[0], most = i, rate, bend


@borrowing
def _longest(w: Wave) -> float:
    """How far a step may go: not beyond what a parting or closing contact allows."""
    r = len(w.free)
    longest, still = math.inf, True
    lead, leads = w.lead[0], 0.0
    if lead >= 0 and w.pace[0] < 0.0:
        leads = float(-w.y[r + lead] / w.pace[0])
    for i in range(len(w.kappa)):
        depth, un = w.y[r + i], w.u[w.normal[i]]
        if w.mode[i] in (LOADS, UNLOADS) and depth > 0.0:
            still = False
            if un > 0.0:
                rate = un / w.e2[i] if w.mode[i] == UNLOADS else un
                whole = i == lead or depth <= SAME_END * leads * rate
                longest = min(longest, depth / rate if whole else NEARER * depth / rate)
        elif w.mode[i] == HELD:
            still = still and w.force[w.normal[i]] == 0.0
    if still:
        # Free flight to the next contact.
        for i in range(len(w.kappa)):
            depth, un = w.y[r + i], w.u[w.normal[i]]
            if un < -AT_REST and depth < 0.0:
                longest = min(longest, -depth / -un * (1.0 + BEYOND))
    return longest


@borrowing
def _adaptive_step(w: Wave, h: float) -> tuple[int, float]:
    """One step of at most h; the change at which it ended or −1, and the next one's length."""
    for _ in range(60):
        error = _trial(w, h)
        if error <= 1.0:
            break
        h *= max(0.2, 0.9 * error ** (-1.0 / 8.0))
    grown = h * min(6.0, 0.9 * max(error, EXACT) ** (-1.0 / 8.0))
    which = _first_crossed(w)
    if which >= 0:
        which = _to_change(w, h, which)
    for k in range(len(w.y)):
        w.y[k] = w.trial[k]
    return which, grown


@borrowing
def _trial(w: Wave, h: float) -> float:
    """The error of a step of h over what it may be; y behind it is in ``w.trial``."""
    K, y, trial, lead = w.stages, w.y, w.trial, w.lead[0]
    m, r = len(y), len(w.free)
    # What the rates are multiplied by is the variable's way of the step: time, or √δ.
    length, root = h, 0.0
    if lead >= 0:
        root = math.sqrt(max(y[r + lead], 0.0))
        length = math.sqrt(max(y[r + lead] + w.pace[0] * h, 0.0)) - root
    smooth = len(w.free) == len(w.kappa) and not any_held(w.mode)
    if smooth:
        kappa, e2, power, modes = w.kappa, w.e2, w.power[0], w.mode
        W, reach, free, u, force = w.W, w.reach, w.free, w.u, w.force
        for s in range(STAGES):
            _state_of_stage(y, length, K, s, trial)
            velocities(W, reach, free, trial, u)
            smooth_rates(e2, kappa, power, modes, trial, K[s], u, force)
            if lead >= 0 and not _led(w, K, s, root + NODES[s] * length):
                return math.inf
    else:
        for s in range(STAGES):
            _state_of_stage(y, length, K, s, trial)
            rates(w, trial, K[s])
            if lead >= 0 and not _led(w, K, s, root + NODES[s] * length):
                return math.inf
    fifth, third = 0.0, 0.0
    tolerance = TOLERANCE if r == len(w.kappa) else WITH_FRICTION
    for k in range(m):
        total, e5, e3 = 0.0, 0.0, 0.0
        for j in range(STAGES):
            total += WEIGHTS[j] * K[j, k]
            e5 += ERROR_5[j] * K[j, k]
            e3 += ERROR_3[j] * K[j, k]
        trial[k] = y[k] + length * total
        allowed = tolerance * (0.1 + abs(y[k]))
        fifth += (e5 / allowed) ** 2
        third += (e3 / allowed) ** 2
    if lead >= 0:
        trial[r + lead] = (root + length) ** 2
    rates(w, trial, w.error)
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return float(abs(length) * fifth / math.sqrt((fifth + 0.01 * third) * m))


@borrowing
def _led(w: Wave, K: Matrix, s: int, root: float) -> bool:
    """Let the rates of a stage be by √δ of the contact that leads: dy/d√δ = dy/dt 2 √δ/(dδ/dt).

    False where its δ turns back.
    """
    rate = K[s, len(w.free) + w.lead[0]]
    if not rate * w.pace[0] > 0.0:
        return False
    share = 2.0 * root / rate
    for k in range(len(w.y)):
        K[s, k] *= share
    return True


@borrowing
def _state_of_stage(y: Array, h: float, K: Matrix, s: int, state: Array) -> None:
    m = len(y)
    for k in range(m):
        state[k] = 0.0
    for j in range(s):
        share = FROM[s, j]
        if share != 0.0:
            for k in range(m):
                state[k] += share * K[j, k]
    for k in range(m):
        state[k] = y[k] + h * state[k]


@borrowing
def _left(w: Wave, which: int) -> float:
    """How far the trial is from a change: below 0 beyond it; infinite where there is none.

    ``which``: i for the normal of contact i, n + i for its slip, 2n + i where it is held and
    might be loaded again.
    """
    n, r = len(w.kappa), len(w.free)
    if which < n:
        i = which
        mode, un, depth = w.mode[i], w.u[w.normal[i]], w.trial[r + i]
        if mode == LOADS and w.e2[i] < 1.0 and depth > 0.0:
            return float(-un)
        if mode == UNLOADS:
            return float(un)
        if mode == OPEN and w.y[r + i] < 0.0:
            return float(-depth) if un < 0.0 else math.inf
        if mode == HELD:
            return float(w.force[w.normal[i]])
        return math.inf
    if which >= 2 * n:
        i = which - 2 * n
        if w.mode[i] != HELD or w.kappa[i] == math.inf:
            return math.inf
        return RISES - force_rate(w, w.trial, i)
    i = which - n
    t = w.tangent[i]
    if t < 0 or w.mode[i] == OPEN:
        return math.inf
    if w.slip[i] == SLIPS:
        return float(w.u[t] * w.way[i, 0] + w.u[t + 1] * w.way[i, 1])
    if w.slip[i] == CREEPS:
        # Along its friction it is accelerated, as long as it could not stick.
        force = w.mu[i] * w.force[w.normal[i]]
        if not force > 0.0:
            return math.inf
        pull = acceleration(w, int(t)) * w.force[t] + acceleration(w, int(t) + 1) * w.force[t + 1]
        return float(-pull / force)
    if w.slip[i] == STICKS:
        pull = math.sqrt(w.force[t] ** 2 + w.force[t + 1] ** 2)
        return float(w.mu[i] * w.force[w.normal[i]] * (1.0 + IN_CONE) - pull)
    return math.inf


@borrowing
def _first_crossed(w: Wave) -> int:
    """Of the changes that the trial went beyond, the one that it left farthest behind; or −1."""
    modes, slip, normal, e2, u, y, trial = w.mode, w.slip, w.normal, w.e2, w.u, w.y, w.trial
    n, r = len(modes), len(u)
    found, most = -1, 0.0
    for i in range(n):
        mode, un = modes[i], u[normal[i]]
        left = 0.0
        if mode == LOADS:
            if e2[i] < 1.0 and trial[r + i] > 0.0:
                left = -un
        elif mode == UNLOADS:
            left = un
        elif mode == HELD or (y[r + i] < 0.0 and trial[r + i] > 0.0):
            left = _left(w, i)
        if left < -_SMALL and left < most:
            found, most = i, left
        if mode == HELD:
            left = _left(w, 2 * n + i)
            if left < -_SMALL and left < most:
                found, most = 2 * n + i, left
        if slip[i] != NONE:
            left = _left(w, n + i)
            if left < -_SMALL and left < most:
                found, most = n + i, left
    return found


@borrowing
def _to_change(w: Wave, h: float, which: int) -> int:
    """Shorten the step to the first change, by the Illinois rule on steps of their own.

    Which change it is; the step is in ``w.trial``.
    """
    low, high, side = 0.0, h, 0
    at_high, at_low = _left(w, which), _left_at_start(w, which)
    for _ in range(80):
        if not at_low > 0.0:
            # It was there already: the change is made behind a step of next to nothing.
            high = min(high, NEXT_TO_NOTHING)
            break
        if high - low <= FOUND * h:
            break
        middle = low + (high - low) * min(max(at_low / (at_low - at_high), 0.01), 0.99)
        _trial(w, middle)
        other = _first_crossed(w)
        if other >= 0 and other != which:
            # Another change comes before.
            which, high, low, side = other, middle, 0.0, 0
            at_high, at_low = _left(w, which), _left_at_start(w, which)
            continue
        here = _left(w, which)
        if abs(here) <= _SMALL:
            return which
        if here < 0.0:
            high, at_high = middle, here
            at_low = 0.5 * at_low if side < 0 else at_low
            side = -1
        else:
            low, at_low = middle, here
            at_high = 0.5 * at_high if side > 0 else at_high
            side = 1
    _trial(w, high)
    return which


@borrowing
def _left_at_start(w: Wave, which: int) -> float:
    """``_left`` where the step begins."""
    for k in range(len(w.y)):
        w.trial[k] = w.y[k]
    rates(w, w.y, w.error)
    return _left(w, which)
