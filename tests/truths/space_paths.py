"""Contacts in space whose forces grow with their indentation, followed in time by a stiff method.

F = κ δ^n presses, dδ/dt = −u_n in compression and −u_n/e² in restitution. Friction is
−µ F u_t/√(|u_t|² + ε²): slip and sticking are one smooth motion, in which what sticks creeps at
less than ε, however many contacts depend on each other. scipy's Radau (Hairer & Wanner 1996,
IV.8) follows it with the Jacobian in closed form; a way ends where a contact turns, parts or
meets. Two values of ε tell how far the truth itself is from ε = 0. (Nothing of the core is
called.)
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp

__all__ = ["Spatial", "space_error"]

RTOL, ATOL = 1e-11, 1e-14
# Slips of friction that is smoothed [of the largest velocity]: errors in u⁺ are about as large.
SMOOTH = 1e-10
MOST_EVENTS, MOST_RATES = 60, 60_000
# Differences from an answer up to here need no second value of ε.
NEAR = 5e-9
# In units in which the shortest contact takes some 3: longer impacts are given up.
LONGEST = 1e3
OPEN, LOADS, UNLOADS = range(3)
# Approaches below this share of the velocities are over.
AT_REST = 1e-12


@dataclass(eq=False)
class Spatial:
    """Contacts of one impact, in units in which the largest speed, κ and mobility are 1.

    Attributes:
        W: (3n, 3n) Delassus matrix. free: (3n,) velocities before; tangents, then the normal.
        e, kappa, mu: (n,) restitution, stiffness and friction. power: n of the force.
    """

    W: np.ndarray
    free: np.ndarray
    e: np.ndarray
    kappa: np.ndarray
    mu: np.ndarray
    power: float
    smooth: float = SMOOTH
    mode: np.ndarray = field(init=False)
    asked: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self.mode = np.where(self.free[2::3] < 0.0, LOADS, OPEN)

    def velocity(self, y: np.ndarray) -> np.ndarray:
        """(3n,) u at y = P, δ."""
        return self.free + self.W @ y[: len(self.free)]

    def _normal(self, y: np.ndarray) -> np.ndarray:
        depth = np.where(self.mode == OPEN, 0.0, np.maximum(y[len(self.free) :], 0.0))
        return self.kappa * depth**self.power

    def _give(self) -> np.ndarray:
        """(n,) −dδ/dt over u_n."""
        return np.where(self.mode == UNLOADS, 1.0 / self.e**2, 1.0)

    def rates(self, _: float, y: np.ndarray) -> np.ndarray:
        """dy/dt."""
        self.asked += 1
        if self.asked > MOST_RATES:
            raise _Endless
        u, force = self.velocity(y), self._normal(y)
        slip = u.reshape(-1, 3)[:, :2]
        pull = -self.mu * force / np.sqrt((slip**2).sum(axis=1) + self.smooth**2)
        forces = np.column_stack([pull[:, None] * slip, force])
        return np.concatenate([forces.ravel(), -u[2::3] * self._give()])

    def jacobian(self, _: float, y: np.ndarray) -> np.ndarray:
        """Its derivative by y."""
        n, r = len(self.e), len(self.free)
        u, force = self.velocity(y), self._normal(y)
        depth = np.where(self.mode == OPEN, 0.0, np.maximum(y[r:], 0.0))
        rise = self.power * self.kappa * depth ** (self.power - 1.0)
        rise[self.mode == OPEN] = 0.0
        found = np.zeros((r + n, r + n))
        for i in range(n):
            t = slice(3 * i, 3 * i + 2)
            slip = u[t]
            size = float(np.sqrt(slip @ slip + self.smooth**2))
            way = slip / size
            across = -self.mu[i] * force[i] / size * (np.eye(2) - np.outer(way, way))
            found[t, :r] = across @ self.W[t]
            found[t, r + i] = -self.mu[i] * rise[i] * way
            found[3 * i + 2, r + i] = rise[i]
        found[r:, :r] = -self.W[2::3] * self._give()[:, None]
        return found

    def events(self) -> list[tuple[int, str]]:
        """What can end the modes at hand: contact, and what it does."""
        found = []
        for i, mode in enumerate(self.mode.tolist()):
            if mode == OPEN:
                found.append((i, "meets"))
            elif mode == LOADS and self.e[i] < 1.0:
                found.append((i, "turns"))
            else:
                found.append((i, "parts"))
            if mode == UNLOADS:
                found.append((i, "returns"))
        return found

    def left(self, i: int, what: str, y: np.ndarray) -> float:
        """How far that is away: it falls through 0 where it happens."""
        depth, un = float(y[len(self.free) + i]), float(self.velocity(y)[3 * i + 2])
        return {"meets": -depth, "parts": depth, "turns": -un, "returns": un}[what]

    def change(self, i: int, what: str) -> None:
        """Let contact i go over."""
        self.mode[i] = {"meets": LOADS, "returns": LOADS, "turns": UNLOADS, "parts": OPEN}[what]

    def is_over(self, y: np.ndarray) -> bool:
        """Whether all have parted and none comes back."""
        return bool((self.mode == OPEN).all() and (self.velocity(y)[2::3] >= -AT_REST).all())


class _Ends:
    """An event of ``solve_ivp`` that ends a way."""

    terminal, direction = True, -1.0

    def __init__(self, spatial: Spatial, i: int, what: str) -> None:
        self._spatial, self._i, self._what = spatial, i, what

    def __call__(self, _: float, y: np.ndarray) -> float:
        return self._spatial.left(self._i, self._what, y)


class _Endless(Exception):
    """An impact took more steps than is worth while."""


def space_error(spatial: Spatial, after: np.ndarray) -> float | None:
    """How far a u⁺ is from the truth beyond the truth's own error; None where that has no end.

    The error of ε is of first order: two values of it give the limit, and what the second
    changes is taken for what is left.
    """
    first = _after(spatial)
    if first is None:
        return None
    error = float(np.abs(after - first).max())
    if error <= NEAR:
        return error
    second = _after(replace(spatial, smooth=10.0 * spatial.smooth))
    if second is None:
        return None
    own = (second - first) / 9.0
    return max(float(np.abs(after - first + own).max() - np.abs(own).max()), 0.0)


def _after(spatial: Spatial) -> np.ndarray | None:
    try:
        impulse = _followed(spatial)
    except _Endless:
        return None
    return None if impulse is None else spatial.free + spatial.W @ impulse


def _followed(spatial: Spatial) -> np.ndarray | None:
    """(3n,) the impulses; None where the impact does not end."""
    r = len(spatial.free)
    y, now = np.zeros(r + len(spatial.e)), 0.0
    end = LONGEST
    settings = {"method": "Radau", "rtol": RTOL, "atol": ATOL}
    for _ in range(MOST_EVENTS):
        if spatial.is_over(y):
            return y[:r]
        events = spatial.events()
        ends = [_Ends(spatial, *event) for event in events]
        way = solve_ivp(spatial.rates, (now, end), y, jac=spatial.jacobian, events=ends, **settings)
        if way.status != 1:
            return None
        # Between its steps Radau is of lower order: the last one goes to the event itself.
        now = float(way.t[-1])
        last = solve_ivp(
            spatial.rates, (way.t[-2], now), way.y[:, -2], jac=spatial.jacobian, **settings
        )
        y = last.y[:, -1]
        for (i, what), times in zip(events, way.t_events, strict=True):
            if len(times):
                spatial.change(i, what)
                if what in ("parts", "meets"):
                    y[r + i] = 0.0
    return None
