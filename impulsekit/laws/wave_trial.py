"""One step of the impulses of a ``Wave``, of order 8 with an estimate of its error.

Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, II.5 (1993).
"""

from __future__ import annotations

import math

from .borrowed import borrowing
from .dop853 import ERROR_3, ERROR_5, FROM, NODES, STAGES, WEIGHTS
from .wave import any_held, rates, smooth_rates, velocities
from .wave_state import Array, Matrix, Wave
from .wave_stiff import implicit_trial

__all__ = ["APPROACH_ENDED", "FIRST", "trial_step"]

# The error of a step, in units in which velocities, impulses and indentations are of size 1.
# With friction slip may pass 0 at next to no distance, which makes of errors many times as large.
TOLERANCE, WITH_FRICTION = 2e-12, 2e-13
# The first step, in units in which the impact takes about 3.
FIRST = 0.03
# Approaches this small have ended [of the largest velocity].
APPROACH_ENDED = 1e-10


@borrowing
def trial_step(w: Wave, h: float) -> float:
    """The error of a step of h over what it may be; y behind it is in ``w.trial``."""
    if w.stiff[0] == 1:
        return float(implicit_trial(w, h))
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
