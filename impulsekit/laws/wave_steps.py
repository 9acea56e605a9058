"""The steps in which the impulses of a ``Wave`` grow, up to what a contact changes."""

from __future__ import annotations

import math

from .borrowed import borrowing
from .wave_crossings import find_change
from .wave_holds import acceleration
from .wave_slips import SLOW
from .wave_state import BEGAN, CREEPS, FAINT, HELD, LOADS, SLIPS, UNLOADS, Wave
from .wave_trial import APPROACH_ENDED, FIRST, trial_step

__all__ = ["APPROACH_ENDED", "FIRST", "adaptive_step", "choose_lead", "longest_step"]

# By how much a flight goes beyond the contact that it leads to; the error below which the next
# step grows as far as it may.
BEYOND, EXACT = 1e-12, 1e-12
# Contacts that end by this much later than the one that leads end with it.
SAME_END = 1.0 + 1e-9
# A contact leads the step where its start or end is nearer than this many steps.
NEARBY = 1.5
# A step goes so far towards the end of a contact, where the force has no smooth derivatives.
NEARER = 0.6
# A step goes so far at most beyond the slip up to which it creeps.
OUT_OF_CREEP = 2.0
# Slip whose direction rounding decides: how fast it changes [times it] is as uncertain as this.
UNCERTAIN = 1e-14


@borrowing
def _rate(w: Wave, i: int) -> float:
    """dδ/dt of a contact that gives way."""
    un = float(w.u[w.normal[i]])
    return -un / float(w.e2[i]) if w.mode[i] == UNLOADS else -un


@borrowing
def choose_lead(w: Wave, step: float) -> None:
    """Where a contact starts or ends within a step, its √δ is the variable of the step, not t.

    With δ = s² its force κ δ^n has derivatives in s, as δ has where it goes through 0 at a
    speed. Of several the one whose force bends most leads.
    """
    r, power, most = len(w.free), w.power[0], 0.0
    w.lead[0] = -1
    if w.stiff[0] == 1:
        return
    for i in range(len(w.kappa)):
        if w.mode[i] != LOADS and w.mode[i] != UNLOADS:
            continue
        depth, rate = w.y[r + i], _rate(w, i)
        speed = abs(rate)
        # What others press in from rest did not start at a speed.
        pressed = rate > 0.0 and acceleration(w, int(w.normal[i])) < 0.0
        if depth < 0.0 or speed <= APPROACH_ENDED or pressed or (rate < 0.0 and depth == 0.0):
            continue
        near = depth / speed
        if near < NEARBY * step:
            bend = w.kappa[i] * speed**power * (near + FIRST * step) ** (power - 8.0)
            if bend > most:
                w.lead[0], w.pace[0], most = i, rate, bend


@borrowing
def longest_step(w: Wave) -> float:
    """How far a step may go: not beyond what a parting or closing contact allows, nor a slip.

    A slip that slows down might end, and come back, within one step: it goes to where its line
    ends, which is Newton's iteration to its first zero.
    """
    r = len(w.free)
    rubs = r > len(w.kappa)
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
        if rubs and w.slip[i] == SLIPS:
            longest = min(longest, _line_of_slip(w, i))
    if still:
        # Free flight to the next contact.
        for i in range(len(w.kappa)):
            depth, un = w.y[r + i], w.u[w.normal[i]]
            if un < -APPROACH_ENDED and depth < 0.0:
                longest = min(longest, -depth / -un * (1.0 + BEYOND))
    return longest


@borrowing
def _line_of_slip(w: Wave, i: int) -> float:
    """When the slip of contact i would end at the rate it has; infinity where it does not fall."""
    t = w.tangent[i]
    speed = w.u[t] * w.way[i, 0] + w.u[t + 1] * w.way[i, 1]
    rate = acceleration(w, int(t)) * w.way[i, 0] + acceleration(w, int(t) + 1) * w.way[i, 1]
    if rate >= 0.0 or speed <= FAINT or (w.stiff[0] == 1 and -rate * speed <= UNCERTAIN):
        return math.inf
    return float(-speed / rate)


@borrowing
def adaptive_step(w: Wave, h: float) -> tuple[int, float]:
    """One step of at most h; the change at which it ended or −1, and the next one's length."""
    for k in range(len(w.free)):
        w.stages[BEGAN, k] = w.force[k]
    for _ in range(60):
        error = trial_step(w, h)
        if error > 1.0:
            h *= max(0.2, 0.9 * error ** (-1.0 / 8.0))
            continue
        slip = _creeping_slip(w)
        if slip <= OUT_OF_CREEP * SLOW:
            break
        # Friction against the acceleration: no error of a step tells that it is slip's by now.
        h *= max(0.2, math.sqrt(SLOW / slip))
    grown = h * min(6.0, 0.9 * max(error, EXACT) ** (-1.0 / 8.0))
    which = find_change(w, h)
    for k in range(len(w.y)):
        w.y[k] = w.trial[k]
    return which, grown


@borrowing
def _creeping_slip(w: Wave) -> float:
    """The fastest slip of what creeps, at the end of a trial."""
    most = 0.0
    for i in range(len(w.kappa)):
        if w.slip[i] == CREEPS:
            u1, u2 = float(w.u[w.tangent[i]]), float(w.u[w.tangent[i] + 1])
            most = max(most, math.sqrt(u1 * u1 + u2 * u2))
    return most
