"""Contacts whose forces grow with their indentation (Liu, Zhao & Brogliato 2008), in time.

F = k δ^n presses; dδ/dt = −u_n in compression and −u_n/e² in restitution, so that each contact
regains e² of the work that it took. One that has parted, δ < 0, comes back by the way that it
went. The impact ends when none is pressed or approaches. Friction is −µ F u_t/√(|u_t|² + ε²), with
ε far below all speeds.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

OPEN, LOADS, UNLOADS = range(3)
SMOOTH = 1e-10
# An approach of this share of the largest velocity is none.
OVER = 1e-12


def waves(W, free, e, mu, stiffness, exponent=1.5):
    """(3n,) P of contacts that act at once; e > 0."""
    n, r = len(e), len(free)
    speed = np.abs(free).max()
    W_nn = W.diagonal()[2::3].max()
    # Units in which the largest velocity, mobility and stiffness are 1.
    W, free, k = W / W_nn, free / speed, np.asarray(stiffness) / np.max(stiffness)
    mode = np.where(free[2::3] < 0.0, LOADS, OPEN)
    y, rough = np.zeros(r + n), bool(np.any(mu))

    def force_of(y):
        return np.where(mode == OPEN, 0.0, k * np.maximum(y[r:], 0.0) ** exponent)

    def rates(_, y):
        u, F = free + W @ y[:r], force_of(y)
        slip = u.reshape(n, 3)[:, :2]
        pull = -mu * F / np.sqrt((slip**2).sum(axis=1) + SMOOTH**2)
        give = np.where(mode == UNLOADS, 1.0 / e**2, 1.0)
        return np.concatenate([np.column_stack([pull[:, None] * slip, F]).ravel(), -u[2::3] * give])

    def slopes(_, y):
        u, F = free + W @ y[:r], force_of(y)
        rise = np.where(mode == OPEN, 0.0, exponent * k * np.maximum(y[r:], 0.0) ** (exponent - 1))
        give = np.where(mode == UNLOADS, 1.0 / e**2, 1.0)
        J = np.zeros((r + n, r + n))
        for i in range(n):
            slip = u[3 * i : 3 * i + 2]
            size = np.sqrt(slip @ slip + SMOOTH**2)
            way = slip / size
            across = -mu[i] * F[i] / size * (np.eye(2) - np.outer(way, way))
            J[3 * i : 3 * i + 2, :r] = across @ W[3 * i : 3 * i + 2]
            J[3 * i : 3 * i + 2, r + i] = -mu[i] * rise[i] * way
            J[3 * i + 2, r + i] = rise[i]
        J[r:, :r] = -W[2::3] * give[:, None]
        return J

    def event(i, ends):
        def value(_, y):
            return y[r + i] if ends else free[3 * i + 2] + W[3 * i + 2] @ y[:r]

        value.terminal = True
        value.direction = 1.0 if mode[i] == (OPEN if ends else LOADS) else -1.0
        return value

    options = (
        {"method": "Radau", "rtol": 1e-11, "atol": 1e-14, "jac": slopes}
        if rough
        else {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
    )
    for _ in range(60):
        if (mode == OPEN).all() and (free + W @ y[:r])[2::3].min() >= -OVER:
            return y[:r] * speed / W_nn
        asked = [(i, False) for i in range(n) if mode[i] != OPEN]
        asked += [(i, True) for i in range(n) if mode[i] != LOADS]
        found = solve_ivp(rates, [0.0, 1e6], y, events=[event(*one) for one in asked], **options)
        assert found.status == 1, "a contact is neither restored nor parts"
        y = found.y[:, -1].copy()
        for (i, ends), times in zip(asked, found.t_events, strict=True):
            if not len(times):
                continue
            if ends:
                mode[i], y[r + i] = (LOADS if mode[i] == OPEN else OPEN), 0.0
            else:
                mode[i] = UNLOADS if mode[i] == LOADS else LOADS
    raise AssertionError("the waves do not end")
