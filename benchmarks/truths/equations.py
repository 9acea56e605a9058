"""The equations of known impulses, bilateral rows and Coulomb contacts at one state, in 50 digits.

Unknowns x are Δv, λ and P; equations

    M Δv − Aᵀλ − JᵀP = I,    A (v + Δv) = b,    and by the mode of each contact
    separated: P = 0;   sticking: ξ = 0;   sliding: ξ_n = 0, P_t + µ P_n ξ_t/|ξ_t| = 0,

with ξ = J (v + Δv) + (e_t J_t v, e min(J_n v, 0)) (Moreau 1988; Glocker 2001).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from impulsekit.reference import Arithmetic
from impulsekit.reference.arithmetic import Array
from impulsekit.scene import Scene

from .found import Found
from .mechanics import Mechanics

SEPARATED, STICKING, SLIDING = 0, 1, 2


class Coefficients:
    """Restitution e, friction µ and tangential restitution e_t of a scene's contacts."""

    def __init__(self, scene: Scene, numbers: Arithmetic) -> None:
        number = numbers.number
        self.e = [number(c.restitution) for c in scene.contacts]
        self.mu = [number(getattr(c, "friction", 0.0)) for c in scene.contacts]
        self.e_t = [number(getattr(c, "tangential_restitution", 0.0)) for c in scene.contacts]


class Equations:
    """The equations of one state.

    Attributes:
        numbers: what they are computed in.
        m: masses, impulses and rows.
        coefficients: of the contacts.
        v: (n,) the velocity before.
        n, r, c: how many speeds, bilateral rows and contacts.
        units: (n + r + 3c,) in which the equations and unknowns are all about one.
    """

    def __init__(
        self, numbers: Arithmetic, mechanics: Mechanics, coefficients: Coefficients, v: np.ndarray
    ) -> None:
        self.numbers, self.m, self.coefficients = numbers, mechanics, coefficients
        self.v = numbers.array(v)
        m = mechanics
        self.n, self.r, self.c = len(m.masses), len(m.rows), len(m.axes)
        start = m.contacts @ self.v
        shift = start * 0
        for i in range(self.c):
            at = 3 * i
            shift[at : at + 2] = coefficients.e_t[i] * start[at : at + 2]
            if start[at + 2] < 0:
                shift[at + 2] = coefficients.e[i] * start[at + 2]
        self._shift = start + shift
        lengths = [self._length(row) for row in (*m.rows, *m.contacts)]
        self.units = np.array([*m.weights, *lengths], dtype=object)

    def _length(self, row: Array) -> Any:
        scaled = row / self.m.weights
        length = self.numbers.norm(scaled)
        return length if length > 0 else self.numbers.number(1)

    def own_axes(self, found: Found) -> Array | None:
        """(r + 3c,) the impulses of an answer in the axes of the truth; NaN as zero."""
        if (self.r and found.rows is None) or (self.c and found.contacts is None):
            return None
        impulses = self.numbers.zeros(self.r + 3 * self.c)
        if found.rows is not None and self.r:
            impulses[: self.r] = self.numbers.array(np.nan_to_num(found.rows))
        for i, given in enumerate(found.contacts or ()):
            at, axes = self.r + 3 * i, self.m.axes[i]
            world = self.numbers.array(np.nan_to_num(given))
            if axes is None:
                impulses[at + 2] = self.m.signs[i] * world[0]
            else:
                impulses[at : at + 3] = axes @ world
        return impulses

    def xi(self, x: Array) -> Array:
        """(3c,) ξ of each contact."""
        return self.m.contacts @ x[: self.n] + self._shift

    def modes(self, x: Array) -> list[int]:
        """The branch of the natural map that each contact is on."""
        modes = []
        xi = self.xi(x)
        for i in range(self.c):
            at, p = 3 * i, self.n + self.r + 3 * i
            units = self.units[p : p + 3]
            if not x[p + 2] * units[2] ** 2 > xi[at + 2]:
                modes.append(SEPARATED)
                continue
            mu = self.coefficients.mu[i]
            if not mu:
                modes.append(SLIDING)
                continue
            rate = units[0] ** 2 + units[1] ** 2
            q1, q2 = x[p] - xi[at] / rate, x[p + 1] - xi[at + 1] / rate
            bound = mu * x[p + 2]
            modes.append(SLIDING if q1 * q1 + q2 * q2 > bound * bound else STICKING)
        return modes

    def matrix(self, x: Array, modes: list[int]) -> Array:
        """(n + r + 3c)² K, scaled to entries of order one."""
        m, n, r = self.m, self.n, self.r
        size = len(x)
        K = self.numbers.zeros(size, size)
        K[:n, :n] = m.masses
        if size > n:
            both = np.concatenate([m.rows, m.contacts])
            K[:n, n:] = -both.T
            K[n : n + r, :n] = m.rows
        for i, mode in enumerate(modes):
            p, J = n + r + 3 * i, m.contacts[3 * i : 3 * i + 3]
            if mode == STICKING:
                K[p : p + 3, :n] = J
                continue
            one = self.numbers.number(1)
            if mode == SEPARATED:
                K[p : p + 3, p : p + 3] = self.numbers.eye(3)
                continue
            K[p + 2, :n] = J[2]
            K[p, p] = K[p + 1, p + 1] = one
            edge = self._edge(x, i)
            if edge is not None:
                (e1, e2), length, rate = edge
                mu = self.coefficients.mu[i]
                K[p, p + 2], K[p + 1, p + 2] = -mu * e1, -mu * e2
                turning = mu * x[p + 2] / length
                across = turning / rate * (e2 * J[0] - e1 * J[1])
                K[p, :n], K[p + 1, :n] = e2 * across, -e1 * across
                K[p, p] -= turning * e2 * e2
                K[p + 1, p + 1] -= turning * e1 * e1
                K[p, p + 1] += turning * e1 * e2
                K[p + 1, p] += turning * e1 * e2
        return K / self.rows_units(modes)[:, None] / self.units[None, :]

    def rows_units(self, modes: list[int]) -> Array:
        """The units of the equations: impulses where they speak of impulses."""
        units = self.units.copy()
        for i, mode in enumerate(modes):
            p = self.n + self.r + 3 * i
            count = {SEPARATED: 3, STICKING: 0, SLIDING: 2}[mode]
            units[p : p + count] = 1 / units[p : p + count]
        return units

    def _edge(self, x: Array, i: int) -> tuple[tuple[Any, Any], Any, Any] | None:
        """Direction and length of q = P_t − ξ_t/ρ, and ρ; None without friction.

        A sliding contact has P_t = µ P_n q/|q|, which says the same as ξ_t does and goes on
        saying it where the slip vanishes.
        """
        if not self.coefficients.mu[i]:
            return None
        p, at = self.n + self.r + 3 * i, 3 * i
        rate = self.units[p] ** 2 + self.units[p + 1] ** 2
        q = x[p : p + 2] - self.xi(x)[at : at + 2] / rate
        length = self.numbers.norm(q)
        if not length > 0:
            return None
        return (q[0] / length, q[1] / length), length, rate

    def left_over(self, x: Array, modes: list[int]) -> Array:
        """(n + r + 3c,) what x leaves of the equations in these modes."""
        m, n, r = self.m, self.n, self.r
        left = x * 0
        dv = x[:n]
        left[:n] = m.masses @ dv - m.known
        if len(x) > n:
            left[:n] -= x[n:] @ np.concatenate([m.rows, m.contacts])
            left[n : n + r] = m.rows @ (self.v + dv) - m.target
        xi = self.xi(x)
        for i, mode in enumerate(modes):
            p, at = n + r + 3 * i, 3 * i
            if mode == STICKING:
                left[p : p + 3] = xi[at : at + 3]
            elif mode == SEPARATED:
                left[p : p + 3] = x[p : p + 3]
            else:
                left[p + 2] = xi[at + 2]
                left[p : p + 2] = x[p : p + 2]
                edge = self._edge(x, i)
                if edge is not None:
                    bound = self.coefficients.mu[i] * x[p + 2]
                    left[p] -= bound * edge[0][0]
                    left[p + 1] -= bound * edge[0][1]
        return left

    def sizes(self, x: Array, modes: list[int]) -> Array:
        """E |x| + |f|, equation by equation."""
        m, n, r = self.m, self.n, self.r
        sizes = np.abs(x) * 0
        sizes[:n] = self.momentum_size(x)
        speeds = np.abs(x[:n]) + np.abs(self.v)
        if r:
            sizes[n : n + r] = m.rows_size @ speeds + np.abs(m.target)
        moving = m.contacts_size @ speeds if self.c else speeds
        for i, mode in enumerate(modes):
            p, at = n + r + 3 * i, 3 * i
            if mode == STICKING:
                sizes[p : p + 3] = moving[at : at + 3]
            elif mode == SLIDING:
                sizes[p + 2] = moving[at + 2]
                edge = self._edge(x, i)
                if edge is not None:
                    turned = self.coefficients.mu[i] * np.abs(x[p + 2]) / edge[1] / edge[2]
                    sizes[p : p + 2] = np.abs(x[p : p + 2]) + turned * moving[at : at + 2]
        return sizes

    def momentum_size(self, x: Array) -> Array:
        """(n,) E |x| + |f| of the rows of M Δv = I + Aᵀλ + JᵀP."""
        m, n = self.m, self.n
        size = m.weights * (m.weights @ np.abs(x[:n])) + m.known_size
        if len(x) > n:
            size = size + np.abs(x[n:]) @ np.concatenate([m.rows_size, m.contacts_size])
        return size
