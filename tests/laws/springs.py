"""Contacts with springs along normals and tangents, followed in time by phases.

F_n = k δ with δ' = −u_n in compression and −u_n/e² in restitution; F_t = −κ k ζ, |F_t| ≤ µ F_n.
ζ' = u_t where it sticks; where its length falls, it falls 1/(1 − D) times as fast. A contact that
slips is described by the angle of ζ, whose length is µ δ/κ.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

OPEN, LOADS, UNLOADS = range(3)
# A contact is followed from this depth on, times its approach, and down to the other one; that it
# begins so much ahead of those that stick is the error of what is found.
BEGUN, SPENT = 1e-10, 1e-6
# A phase that begins on the edge of sticking leaves it by more than this.
ROUNDING = 1e-13


class Springs:
    """The phases of n contacts; W (3n, 3n), u (3n,), the coefficients (n,)."""

    def __init__(self, W, u, e, mu, k, ratio, damping):
        self.W, self.u0, self.e, self.mu, self.ratio, self.kept = W, u, e, mu, ratio, 1.0 - damping
        self.k, self.n = np.asarray(k) / np.max(k) / W.diagonal().max(), len(e)
        self.mode, self.slips = np.full(self.n, OPEN), np.zeros(self.n, dtype=bool)

    def velocity(self, y):
        return (self.u0 + self.W @ y[: 3 * self.n]).reshape(-1, 3)

    def gives(self, i):
        return 1.0 / self.e[i] ** 2 if self.mode[i] == UNLOADS else 1.0

    def spring(self, y, i):
        """(2,) ζ or the angle of contact i, and where it stands in y."""
        at = 4 * self.n + 2 * i
        return y[at : at + 2], at

    def way(self, y, i):
        angle = self.spring(y, i)[0][0]
        return np.array([np.cos(angle), np.sin(angle)])

    def slip(self, y, u, i):
        """The speed of slip of a contact that slips."""
        rise = -self.gives(i) * u[2]
        share = 1.0 if rise > 0 else self.kept[i]
        return u[:2] @ self.way(y, i) - share * self.mu[i] / self.ratio[i] * rise

    def rates(self, _, y):
        dy, u, n = np.zeros_like(y), self.velocity(y), self.n
        for i in range(n):
            depth, (z, at) = y[3 * n + i], self.spring(y, i)
            dy[3 * n + i] = -self.gives(i) * u[i, 2]
            if self.mode[i] == OPEN:
                continue
            F = self.k[i] * depth
            if self.slips[i]:
                way = self.way(y, i)
                across = way[0] * u[i, 1] - way[1] * u[i, 0]
                dy[at] = self.ratio[i] * across / (self.mu[i] * depth)
                dy[3 * i : 3 * i + 2] = -self.mu[i] * F * way
            else:
                dy[3 * i : 3 * i + 2] = -self.ratio[i] * self.k[i] * z
                length = np.hypot(*z)
                back = min(u[i, :2] @ z / length, 0.0) if length > 0 else 0.0
                dy[at : at + 2] = u[i, :2]
                if back < 0.0:
                    dy[at : at + 2] += (1.0 / self.kept[i] - 1.0) * back * z / length
            dy[3 * i + 2] = F
        return dy

    def events(self):
        """(contact, kind) and functions of what may happen next."""
        found, n = [], self.n

        def add(i, kind, function, direction):
            def event(_, y):
                return function(y)

            event.terminal, event.direction = True, direction
            found.append((i, kind, event))

        for i in range(n):

            def depth(y, i=i):
                return y[3 * n + i]

            def normal(y, i=i):
                return self.velocity(y)[i, 2]

            def leaves(y, i=i):
                if self.slips[i]:
                    return self.slip(y, self.velocity(y)[i], i) + ROUNDING
                z = self.spring(y, i)[0]
                return self.mu[i] * y[3 * n + i] - self.ratio[i] * np.hypot(*z) + ROUNDING

            if self.mode[i] == OPEN:
                add(i, "closes", depth, 1)
                continue
            add(i, "leaves", leaves, -1)
            add(i, "turns", normal, 1 if self.mode[i] == LOADS else -1)
            add(i, "parts", lambda y, i=i: depth(y, i) - SPENT * abs(self.u0[3 * i + 2]), -1)
        return found

    def close(self, y, i):
        u = self.velocity(y)[i]
        self.mode[i] = LOADS
        z, at = self.spring(y, i)
        z[:] = 0.0
        self.slips[i] = self.ratio[i] * np.hypot(*u[:2]) > self.mu[i] * abs(u[2])
        y[3 * self.n + i] = 0.0
        if self.slips[i]:
            y[at] = np.arctan2(u[1], u[0])
            depth = y[3 * self.n + i] = BEGUN * abs(u[2])
            push = np.array([*(-self.mu[i] * self.way(y, i)), 1.0])
            y[3 * i : 3 * i + 3] += 0.5 * BEGUN * self.k[i] * depth * push

    def change(self, y, i, kind):
        z, at = self.spring(y, i)
        if kind == "closes":
            self.close(y, i)
        elif kind == "turns":
            self.mode[i] = UNLOADS if self.mode[i] == LOADS else LOADS
        elif kind == "parts":
            # It parts as soon as its depth is gone at the rate of restitution.
            y[3 * self.n + i] /= self.gives(i)
            self.mode[i] = OPEN
        elif self.slips[i]:
            self.slips[i] = False
            z[:] = self.mu[i] / self.ratio[i] * y[3 * self.n + i] * self.way(y, i)
        else:
            self.slips[i] = True
            y[at : at + 2] = np.arctan2(z[1], z[0]), 0.0


def spring_impulses(W, u, e, mu, k, ratio, damping=None):
    """(3n,) P of contacts that all approach; e > 0."""
    springs = Springs(W, u, e, mu, k, ratio, np.zeros(len(e)) if damping is None else damping)
    y = np.zeros(6 * springs.n)
    for i in range(springs.n):
        springs.close(y, i)
    for _ in range(400):
        if (springs.mode == OPEN).all() and springs.velocity(y)[:, 2].min() >= 0.0:
            return y[: 3 * springs.n]
        happens = springs.events()
        found = solve_ivp(
            springs.rates, [0.0, 1e3], y, "DOP853", rtol=1e-12, atol=1e-15,
            events=[event for _, _, event in happens], first_step=1e-10, max_step=0.05,
        )  # fmt: skip
        assert found.status == 1, "no contact changes"
        y = found.y[:, -1].copy()
        for (i, kind, _), times in zip(happens, found.t_events, strict=True):
            if len(times):
                springs.change(y, i, kind)
    raise AssertionError("the impact does not end")
