"""Contacts in a plane whose forces grow with their indentation, followed in time.

F = κ δ^n presses, dδ/dt = −u_n in compression and −u_n/e² in restitution, an infinite κ keeps
u_n = 0 while F ≥ 0. Friction is −µ F s while a contact slips, and at no slip what keeps it there,
|F_t| ≤ µ F. Between two events all forces are smooth: scipy's DOP853 follows them at 1e-13. What
a contact that neither slips nor parts does next is found by trying all: holds, slips one way or
the other, parts. (Nothing of the core is called.)
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from impulsekit.tolerances import NONZERO

__all__ = ["Planar", "follow_in_time"]

# At 1e-12 errors of 1e-9 stay behind where forces like δ^1.5 begin and end.
RTOL, ATOL = 1e-13, 1e-16
MOST_EVENTS = 200
# Of the time of one contact alone: longer impacts are given up.
LONGEST = 1e4
# Forces and accelerations below this share of the largest are zero where modes are tried.
ZERO = 1e-9
# Singular values of W below this share of the largest are rounding: the shortest forces are taken.
NULL = 1e-12
# An event that lies this far behind was passed over; ways are tried so often. Within each step of
# a way so many places are looked at, and what is nearest to an event there.
PASSED, MOST_TRIES, PLACES = 1e-8, 6, 8
OPEN, LOADS, UNLOADS, HELD = range(4)


@dataclass(eq=False)
class Planar:
    """Contacts of one impact; rows are n normals, then m tangents.

    Points of a body on one line rub along the same tangent: how they share its friction moves
    nothing.

    Attributes:
        W: (n + m, n + m) Delassus matrix. free: (n + m,) velocities before.
        e, kappa: (n,) restitution and stiffness. power: n of the force.
        rub: (m, n) friction µ of the contacts along each tangent.
    """

    W: np.ndarray
    free: np.ndarray
    e: np.ndarray
    kappa: np.ndarray
    power: float
    rub: np.ndarray
    mode: np.ndarray = field(init=False)
    slip: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        n = len(self.e)
        rigid = np.isinf(self.kappa)
        self.mode = np.where(rigid, HELD, np.where(self.free[:n] < 0.0, LOADS, OPEN))
        self.slip = np.sign(self.free[n:])

    def forces(self, y: np.ndarray) -> np.ndarray:
        """(n + m,) dP/dt at y = P, δ."""
        return self._balanced(self._pressed(y), self.mode == HELD, self.slip)

    def _pressed(self, y: np.ndarray) -> np.ndarray:
        """(n,) normal forces of what gives way."""
        n, depths = len(self.e), y[len(self.free) :]
        normal = np.zeros(n)
        for i in range(n):
            if self.mode[i] in (LOADS, UNLOADS) and depths[i] > 0.0:
                normal[i] = self.kappa[i] * depths[i] ** self.power
        return normal

    def _balanced(self, normal: np.ndarray, held: np.ndarray, slip: np.ndarray) -> np.ndarray:
        """(n + m,) forces from the normal ones that are known: what is held and sticks stays."""
        n = len(self.e)
        sticks = (slip == 0.0) & (self.rub @ ((normal > 0.0) | held) > 0.0)
        start = np.concatenate([normal, -slip * (self.rub @ normal)])
        rows = np.concatenate([np.flatnonzero(held), n + np.flatnonzero(sticks)])
        if not len(rows):
            return start
        # F = start + way x with x the forces that are sought.
        way = np.zeros((len(start), len(rows)))
        way[rows, np.arange(len(rows))] = 1.0
        for k, i in enumerate(np.flatnonzero(held)):
            way[n:, k] -= slip * self.rub[:, i]
        matrix = self.W[rows] @ way
        x: np.ndarray = np.linalg.lstsq(matrix, -self.W[rows] @ start, rcond=NULL)[0]
        return start + way @ x

    def speed(self, y: np.ndarray, row: int) -> float:
        """The velocity of a row [m/s]."""
        return float(self.free[row] + self.W[row] @ y[: len(self.free)])

    def rates(self, _: float, y: np.ndarray) -> np.ndarray:
        """dy/dt."""
        n, r = len(self.e), len(self.free)
        un = self.free[:n] + self.W[:n] @ y[:r]
        way = np.where(self.mode == UNLOADS, un / self.e**2, un)
        return np.concatenate([self.forces(y), np.where(self.mode == HELD, 0.0, -way)])

    def choose(self, y: np.ndarray, moved: int) -> bool:
        """What tangents without slip, and contacts that are held, do next; whether any way fits.

        ``moved``: the row that has just reached its cone, or no force; −1 for none.
        """
        n, r = len(self.e), len(self.free)
        velocity, normal = self.free + self.W @ y[:r], self._pressed(y)
        held = np.flatnonzero(self.mode == HELD)
        loads = self.rub @ ((normal > 0.0) | (self.mode == HELD))
        rests = np.flatnonzero((np.abs(velocity[n:]) < ZERO) & (loads > 0.0))
        best, least = None, ZERO
        for holds in itertools.product((True, False), repeat=len(held)):
            for slips in itertools.product((0.0, 1.0, -1.0), repeat=len(rests)):
                keeps, slip = self.mode == HELD, self.slip.copy()
                keeps[held], slip[rests] = holds, slips
                if moved >= 0 and (keeps[moved] if moved < n else slip[moved - n] == 0.0):
                    continue
                left = self._left(self._balanced(normal, keeps, slip), keeps, held, slip, rests)
                if left < least:
                    best, least = (keeps, slip), left
        if best is None:
            return False
        self.slip = best[1]
        self.mode[held[~best[0][held]]] = OPEN
        return True

    def _left(
        self,
        found: np.ndarray,
        keeps: np.ndarray,
        held: np.ndarray,
        slip: np.ndarray,
        rests: np.ndarray,
    ) -> float:
        """By how much such forces miss what these modes ask for, relative."""
        n = len(self.e)
        speeds_up = self.W @ found
        force = np.abs(found).max() + NONZERO
        fast = (np.abs(self.W) @ np.abs(found)).max() + NONZERO
        left = 0.0
        for i in held:
            left = max(left, -found[i] / force if keeps[i] else -speeds_up[i] / fast)
        for k in rests:
            if slip[k]:
                left = max(left, -slip[k] * speeds_up[n + k] / fast)
            else:
                left = max(left, (abs(found[n + k]) - self.rub[k] @ found[:n]) / force)
        return float(left)

    def events(self) -> list[tuple[int, str]]:
        """What can end the modes at hand: row, and what it does."""
        n = len(self.e)
        found: list[tuple[int, str]] = []
        for i in range(n):
            mode = self.mode[i]
            if mode == LOADS and self.e[i] < 1.0:
                found.append((i, "turns"))
            if mode == UNLOADS:
                found.append((i, "returns"))
            if mode in (LOADS, UNLOADS):
                found.append((i, "parts"))
            if mode == OPEN:
                found.append((i, "meets"))
            if mode == HELD:
                found.append((i, "lifts"))
        for k in np.flatnonzero(self.rub @ (self.mode != OPEN) > 0.0):
            found.append((n + int(k), "stops" if self.slip[k] else "slips"))
        return found

    def left(self, row: int, what: str, _: float, y: np.ndarray) -> float:
        """How far that is away: it falls through 0 where it happens."""
        n, r = len(self.e), len(self.free)
        if what == "turns":
            return -self.speed(y, row)
        if what == "returns":
            return self.speed(y, row)
        if what in ("parts", "meets"):
            return float(y[r + row] if what == "parts" else -y[r + row])
        if what == "stops":
            return float(self.slip[row - n]) * self.speed(y, row)
        forces = self.forces(y)
        if what == "lifts":
            return float(forces[row])
        return float(self.rub[row - n] @ forces[:n] - abs(forces[row]))

    def change(self, row: int, what: str, y: np.ndarray) -> None:
        """Let a contact go over."""
        n = len(self.e)
        if what == "turns":
            self.mode[row] = UNLOADS
        elif what == "parts":
            self.mode[row] = OPEN
        elif what == "returns":
            self.mode[row] = LOADS
        elif what == "meets":
            self.mode[row] = LOADS
            for k in map(int, np.flatnonzero(self.rub[:, row])):
                # What nothing pressed before slips as it moves now.
                if self.rub[k] @ (self.mode != OPEN) == self.rub[k, row]:
                    self.slip[k] = np.sign(self.speed(y, n + k))

    def is_over(self, y: np.ndarray) -> bool:
        """Whether nothing presses or comes back."""
        n, r = len(self.e), len(self.free)
        un = self.free[:n] + self.W[:n] @ y[:r]
        if (self.mode == OPEN).all():
            return bool((un >= 0.0).all())
        still = (self.mode == HELD) | ((self.mode == OPEN) & (un >= -ZERO))
        return bool(still.all() and np.abs(self.forces(y)).max() <= ZERO**2)


class _Ends:
    """An event of ``solve_ivp`` that ends a way."""

    terminal, direction = True, -1.0

    def __init__(self, planar: Planar, row: int, what: str) -> None:
        self._planar, self._row, self._what = planar, row, what

    def __call__(self, t: float, y: np.ndarray) -> float:
        return self._planar.left(self._row, self._what, t, y)


def follow_in_time(planar: Planar) -> np.ndarray | None:
    """(n + m,) the impulses; None where the impact does not end, or no mode fits."""
    n, r = len(planar.e), len(planar.free)
    y = np.zeros(r + n)
    finite = planar.kappa[np.isfinite(planar.kappa)]
    end = LONGEST / math.sqrt(float(np.diag(planar.W)[:n].min() * finite.min()))
    moved = -1
    for _ in range(MOST_EVENTS):
        if not planar.choose(y, moved):
            return None
        if planar.is_over(y):
            return y[:r]
        events = planar.events()
        ends: list[Any] = [_Ends(planar, *event) for event in events]
        way = _until_an_end(planar, y, end, ends)
        if way.status != 1:
            return None
        y, moved = way.y[:, -1], -1
        for (row, what), times in zip(events, way.t_events, strict=True):
            if len(times):
                planar.change(row, what, y)
                moved = row if what in ("slips", "lifts") else moved
    return None


def _until_an_end(planar: Planar, y: np.ndarray, end: float, ends: list[Any]) -> Any:
    """The way from y to the first event; again where one was passed over."""
    longest = np.inf
    for _ in range(MOST_TRIES):
        way = solve_ivp(
            planar.rates, (0.0, end), y, "DOP853", rtol=RTOL, atol=ATOL, events=ends,
            max_step=longest, dense_output=True,
        )  # fmt: skip
        beyond = [
            t
            for t, state in zip(way.t, way.y.T, strict=True)
            if any(event(t, state) < -PASSED for event in ends)
        ]
        within = _passed_within(way, ends)
        if beyond:
            longest = 0.05 * beyond[0]
        elif within is not None:
            # A way that ends beyond the event meets it.
            end = within
        else:
            break
    return way


def _passed_within(way: Any, ends: list[Any]) -> float | None:
    """When an event was passed and came back within one step of a way; None for never."""
    for first, last in itertools.pairwise(way.t):
        times = np.linspace(first, last, PLACES + 2)
        states = way.sol(times)
        for event in ends:
            left = [event(t, state) for t, state in zip(times, states.T, strict=True)]
            k = int(np.argmin(left))
            if k in (0, len(left) - 1):
                continue
            down, up = left[k] - left[k - 1], left[k + 1] - left[k]
            lowest = times[k] - 0.5 * (up + down) / (up - down) * (times[k] - times[k - 1])
            if event(lowest, way.sol(lowest)) < -PASSED:
                return float(lowest)
    return None
