"""Impacts with known impulses, bilateral rows and Coulomb contacts, to 50 digits.

Unknowns x are Δv, λ and P; equations

    M Δv − Aᵀλ − JᵀP = I,    A (v + Δv) = b,    and by the mode of each contact
    separated: P = 0;   sticking: ξ = 0;   sliding: ξ_n = 0, P_t + µ P_n ξ_t/|ξ_t| = 0,

with ξ = J (v + Δv) + (e_t J_t v, e min(J_n v, 0)) (Moreau 1988; Glocker 2001). Newton goes
from the answer that was found to the solution beside it; modes are seen anew at each step
(Alart & Curnier 1991). That solution satisfies the law to the last digit, whatever it
started from, so an answer that is not near any solution is far from this one as well.

The condition is that of the linear equations K x = f at the solution: data that are known
to eps E and eps |f| move x by eps |K⁻¹| (E |x| + |f|) at most (Skeel 1979; Higham,
"Accuracy and stability of numerical algorithms", 7.2), with the sizes of ``mechanics`` in E.
It knows no norm and no units.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...reference.arithmetic import Array
from ...scene import Scene
from .elimination import generalized_inverse
from .found import Exact, Found
from .mechanics import Mechanics, SceneMechanics
from .numbers import EPS

__all__ = ["Impacts", "Residuals", "share_of"]

MOST_STEPS = 60
# Velocities below so many times their rounding.
DEGENERATE = 100
SEPARATED, STICKING, SLIDING = 0, 1, 2


@dataclass(frozen=True)
class Residuals:
    """What an answer leaves of its equations, relative, computed in 50 digits.

    Attributes:
        momentum: of M Δv = I + Aᵀλ + JᵀP, by row over the sizes of its terms.
        law: of the bilateral rows and the contact law, over the velocities in them.
    """

    momentum: float
    law: float


class Impacts:
    """The truth of a scene under Newton's law with slip at the end, or without contacts."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.mechanics = SceneMechanics(scene)
        number = self.mechanics.numbers.number
        self._e = [number(c.restitution) for c in scene.contacts]
        self._mu = [number(getattr(c, "friction", 0.0)) for c in scene.contacts]
        self._e_t = [number(getattr(c, "tangential_restitution", 0.0)) for c in scene.contacts]

    def at(self, q: np.ndarray, v: np.ndarray) -> _State:
        """The equations at a state."""
        return _State(self, self.mechanics.at(q, v), v)


class _State:
    """The equations of one state."""

    def __init__(self, owner: Impacts, mechanics: Mechanics, v: np.ndarray) -> None:
        self._owner, self._m = owner, mechanics
        self._numbers = numbers = owner.mechanics.numbers
        self._zero = numbers.number(0)
        m = mechanics
        self._v = numbers.array(v)
        self._n, self._r, self._c = len(m.masses), len(m.rows), len(m.axes)
        self._start = m.contacts @ self._v
        shift = self._start * 0
        for i in range(self._c):
            at = 3 * i
            shift[at : at + 2] = owner._e_t[i] * self._start[at : at + 2]
            if self._start[at + 2] < 0:
                shift[at + 2] = owner._e[i] * self._start[at + 2]
        self._shift = self._start + shift
        lengths = [self._length(row) for row in (*m.rows, *m.contacts)]
        # Units in which the equations and unknowns are all about one.
        self._units = np.array([*m.weights, *lengths], dtype=object)

    def _length(self, row: Array) -> Any:
        scaled = row / self._m.weights
        length = self._numbers.norm(scaled)
        return length if length > 0 else self._numbers.number(1)

    # -- solution -----------------------------------------------------------------

    def exact(self, found: Found | None = None) -> Exact | None:
        """The solution beside an answer; None where Newton finds none there."""
        start = self._start_of(found)
        solution = self._newton(start, None)
        return self.exact_in_its_modes(found) if solution is None else solution

    def exact_in_its_modes(self, found: Found | None) -> Exact | None:
        """The solution in the modes of an answer.

        Contacts that are redundant but for rounding may be in one mode as well as in another;
        what these modes leave of the law's inequalities is told.
        """
        if not self._c or found is None or not found.valid:
            return None
        start = self._start_of(found)
        return self._newton(start, self._modes(start))

    def _newton(self, x: Array, kept: list[int] | None) -> Exact | None:
        modes: list[int] | None = None
        inverse, rank = None, 0
        tiny = self._numbers.epsilon**2
        target = self._numbers.number(10) ** -36
        for _ in range(MOST_STEPS):
            seen = kept or self._modes(x)
            if inverse is None or seen != modes or SLIDING in seen:
                inverse, rank = generalized_inverse(self._numbers, self._matrix(x, seen))
            modes = seen
            step = (inverse @ (self._left_over(x, seen) / self._rows_units(seen))) / self._units
            x = x - step
            moved = np.max(np.abs(step * self._units))
            size = np.max(np.abs(x * self._units))
            if not moved > target * size + tiny and (kept or self._modes(x) == modes):
                # Where rank is lost, a step of zero may leave what nothing can bring to zero.
                left = np.max(np.abs(self._left_over(x, modes) / self._rows_units(modes)))
                if not left > self._numbers.sqrt(target) * size + tiny:
                    return self._told(x, modes, inverse, rank)
                return None
        return None

    def _start_of(self, found: Found | None) -> Array:
        x = self._numbers.zeros(self._n + self._r + 3 * self._c)
        if found is None or found.dv is None or not np.isfinite(found.dv).all():
            return x
        x[: self._n] = self._numbers.array(found.dv)
        impulses = self.own_axes(found)
        if impulses is not None:
            x[self._n :] = impulses
        return x

    def own_axes(self, found: Found) -> Array | None:
        """(r + 3c,) the impulses of an answer in the axes of the truth; NaN as zero."""
        if (self._r and found.rows is None) or (self._c and found.contacts is None):
            return None
        impulses = self._numbers.zeros(self._r + 3 * self._c)
        if found.rows is not None and self._r:
            impulses[: self._r] = self._numbers.array(np.nan_to_num(found.rows))
        for i, given in enumerate(found.contacts or ()):
            at, axes = self._r + 3 * i, self._m.axes[i]
            world = self._numbers.array(np.nan_to_num(given))
            if axes is None:
                impulses[at + 2] = self._m.signs[i] * world[0]
            else:
                impulses[at : at + 3] = axes @ world
        return impulses

    def _xi(self, x: Array) -> Array:
        return self._m.contacts @ x[: self._n] + self._shift

    def _modes(self, x: Array) -> list[int]:
        """The branch of the natural map that each contact is on."""
        modes = []
        xi = self._xi(x)
        for i in range(self._c):
            at, p = 3 * i, self._n + self._r + 3 * i
            units = self._units[p : p + 3]
            if not x[p + 2] * units[2] ** 2 > xi[at + 2]:
                modes.append(SEPARATED)
                continue
            mu = self._owner._mu[i]
            if not mu:
                modes.append(SLIDING)
                continue
            rate = units[0] ** 2 + units[1] ** 2
            q1, q2 = x[p] - xi[at] / rate, x[p + 1] - xi[at + 1] / rate
            bound = mu * x[p + 2]
            modes.append(SLIDING if q1 * q1 + q2 * q2 > bound * bound else STICKING)
        return modes

    def _matrix(self, x: Array, modes: list[int]) -> Array:
        """(n + r + 3c)² K, scaled to entries of order one."""
        m, n, r = self._m, self._n, self._r
        size = len(x)
        K = self._numbers.zeros(size, size)
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
            one = self._numbers.number(1)
            if mode == SEPARATED:
                K[p : p + 3, p : p + 3] = self._numbers.eye(3)
                continue
            K[p + 2, :n] = J[2]
            K[p, p] = K[p + 1, p + 1] = one
            edge = self._edge(x, i)
            if edge is not None:
                (e1, e2), length, rate = edge
                mu = self._owner._mu[i]
                K[p, p + 2], K[p + 1, p + 2] = -mu * e1, -mu * e2
                turning = mu * x[p + 2] / length
                across = turning / rate * (e2 * J[0] - e1 * J[1])
                K[p, :n], K[p + 1, :n] = e2 * across, -e1 * across
                K[p, p] -= turning * e2 * e2
                K[p + 1, p + 1] -= turning * e1 * e1
                K[p, p + 1] += turning * e1 * e2
                K[p + 1, p] += turning * e1 * e2
        return K / self._rows_units(modes)[:, None] / self._units[None, :]

    def _rows_units(self, modes: list[int]) -> Array:
        """The units of the equations: impulses where they speak of impulses."""
        units = self._units.copy()
        for i, mode in enumerate(modes):
            p = self._n + self._r + 3 * i
            count = {SEPARATED: 3, STICKING: 0, SLIDING: 2}[mode]
            units[p : p + count] = 1 / units[p : p + count]
        return units

    def _edge(self, x: Array, i: int) -> tuple[tuple[Any, Any], Any, Any] | None:
        """Direction and length of q = P_t − ξ_t/ρ, and ρ; None without friction.

        A sliding contact has P_t = µ P_n q/|q|, which says the same as ξ_t does and goes on
        saying it where the slip vanishes.
        """
        if not self._owner._mu[i]:
            return None
        p, at = self._n + self._r + 3 * i, 3 * i
        rate = self._units[p] ** 2 + self._units[p + 1] ** 2
        q = x[p : p + 2] - self._xi(x)[at : at + 2] / rate
        length = self._numbers.norm(q)
        if not length > 0:
            return None
        return (q[0] / length, q[1] / length), length, rate

    def _left_over(self, x: Array, modes: list[int]) -> Array:
        m, n, r = self._m, self._n, self._r
        left = x * 0
        dv = x[:n]
        left[:n] = m.masses @ dv - m.known
        if len(x) > n:
            left[:n] -= x[n:] @ np.concatenate([m.rows, m.contacts])
            left[n : n + r] = m.rows @ (self._v + dv) - m.target
        xi = self._xi(x)
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
                    bound = self._owner._mu[i] * x[p + 2]
                    left[p] -= bound * edge[0][0]
                    left[p + 1] -= bound * edge[0][1]
        return left

    def _told(self, x: Array, modes: list[int], inverse: Array, rank: int) -> Exact:
        n = self._n
        sizes = self._sizes(x, modes) / self._rows_units(modes)
        slack = (np.abs(inverse) @ sizes) / self._units
        has_impulses = len(x) > n
        if has_impulses:
            # What is held altogether stays at rest whatever the data; rounding there is that of
            # what the blow would do to the heaviest body.
            m = self._m
            heaviest = np.max(m.weights / m.spans)
            slack[:n] += np.max(m.known_size / m.weights) / heaviest / m.spans
        violation, degenerate = 0.0, False
        if self._c:
            speeds = np.abs(x[:n]) + np.abs(self._v)
            rounding = self._m.contacts_size @ (speeds + slack[:n])
            violation = self._violation(x, modes, rounding)
            # A contact that parts by next to nothing might as well bear the load of others.
            parting = rounding[2::3] * (DEGENERATE * EPS)
            xi = self._xi(x)[2::3]
            degenerate = any(
                mode == SEPARATED and abs(xi[i]) <= parting[i] for i, mode in enumerate(modes)
            )
            for i in range(self._c):
                # Told in world axes, components round like the length; and what rounding
                # leaves of a velocity may be taken for a push.
                at, p = slice(3 * i, 3 * i + 3), n + self._r + 3 * i
                own = slice(p, p + 3)
                slack[own] += np.abs(x[own]).sum() + rounding[at] / self._units[own] ** 2
        return Exact(
            dv=x[:n],
            slack=slack[:n],
            weights=self._m.spans,
            impulses_weights=self._units[n:],
            impulses=x[n:] if has_impulses else None,
            impulses_slack=slack[n:] if has_impulses else None,
            determined=rank == len(x) and not degenerate,
            violation=violation,
            before=self._v if has_impulses else None,
        )

    def _violation(self, x: Array, modes: list[int], rounding: Array) -> float:
        """What is left of the inequalities, in units of eps times what rounding may do."""
        worst = self._zero
        xi = self._xi(x)
        for i, mode in enumerate(modes):
            at, p = 3 * i, self._n + self._r + 3 * i
            normal = self._units[p + 2] ** 2
            if mode == SEPARATED:
                worst = max(worst, -xi[at + 2] / rounding[at + 2])
                continue
            size = rounding[at + 2] + normal * abs(x[p + 2])
            worst = max(worst, -x[p + 2] * normal / size)
            if mode == STICKING:
                beyond = self._numbers.norm(x[p : p + 2]) - self._owner._mu[i] * x[p + 2]
                rate = self._units[p] ** 2 + self._units[p + 1] ** 2
                size = max(rounding[at : at + 2]) + rate * abs(x[p + 2])
                worst = max(worst, beyond * rate / size)
        return float(worst) / EPS

    def _sizes(self, x: Array, modes: list[int]) -> Array:
        """E |x| + |f|, equation by equation."""
        m, n, r = self._m, self._n, self._r
        sizes = np.abs(x) * 0
        sizes[:n] = self._momentum_size(x)
        speeds = np.abs(x[:n]) + np.abs(self._v)
        if r:
            sizes[n : n + r] = m.rows_size @ speeds + np.abs(m.target)
        moving = m.contacts_size @ speeds if self._c else speeds
        for i, mode in enumerate(modes):
            p, at = n + r + 3 * i, 3 * i
            if mode == STICKING:
                sizes[p : p + 3] = moving[at : at + 3]
            elif mode == SLIDING:
                sizes[p + 2] = moving[at + 2]
                edge = self._edge(x, i)
                if edge is not None:
                    turned = self._owner._mu[i] * np.abs(x[p + 2]) / edge[1] / edge[2]
                    sizes[p : p + 2] = np.abs(x[p : p + 2]) + turned * moving[at : at + 2]
        return sizes

    def _momentum_size(self, x: Array) -> Array:
        m, n = self._m, self._n
        size = m.weights * (m.weights @ np.abs(x[:n])) + m.known_size
        if len(x) > n:
            size = size + np.abs(x[n:]) @ np.concatenate([m.rows_size, m.contacts_size])
        return size

    # -- residuals ------------------------------------------------------------------

    def residuals(self, found: Found) -> Residuals:
        """What an answer leaves of its equations."""
        if found.dv is None or not np.isfinite(found.dv).all():
            return Residuals(np.inf, np.inf)
        n, r = self._n, self._r
        impulses = self.own_axes(found)
        if impulses is None:
            return Residuals(np.nan, np.nan)
        x = np.concatenate([self._numbers.array(found.dv), impulses])
        left = np.abs(self._left_over(x, [SEPARATED] * self._c)[: n + r])
        momentum = share_of(left[:n], self._momentum_size(x))
        # Beside what rests, velocities are those of what the blow would do to the heaviest body.
        heaviest = np.max(self._m.weights / self._m.spans)
        floor = np.max(self._m.known_size / self._m.weights) / heaviest / self._m.spans
        speeds = np.abs(x[:n]) + np.abs(self._v) + floor
        law = 0.0
        if r:
            sizes = self._m.rows_size @ speeds + np.abs(self._m.target)
            law = share_of(left[n:], np.full(r, np.max(sizes), dtype=object))
        if self._c:
            law = max(law, self._law_left(x, speeds))
        return Residuals(momentum, law)

    def _law_left(self, x: Array, speeds: Array) -> float:
        """The natural map of the contact law over the velocities at hand."""
        xi = self._xi(x)
        moving = self._m.contacts_size @ speeds
        scale = np.max(moving)
        worst = self._zero
        for i in range(self._c):
            at, p = 3 * i, self._n + self._r + 3 * i
            units = self._units[p : p + 3]
            # Impulses in balance make velocities that nobody sees.
            scale = max(scale, units[2] ** 2 * abs(x[p + 2]))
            worst = max(worst, abs(min(xi[at + 2], units[2] ** 2 * x[p + 2])))
            mu = self._owner._mu[i]
            if not mu:
                continue
            rate = units[0] ** 2 + units[1] ** 2
            q = x[p : p + 2] - xi[at : at + 2] / rate
            bound = max(mu * x[p + 2], self._zero)
            size = self._numbers.norm(q)
            if size > bound:
                q = q * (bound / size)
            worst = max(worst, rate * self._numbers.norm(x[p : p + 2] - q))
        return float(worst / scale) if scale > 0 else float(worst)


def share_of(left: Array, sizes: Array) -> float:
    """The largest entry of ``left`` over its size."""
    worst = 0.0
    for entry, size in zip(left, sizes, strict=True):
        if size > 0:
            worst = max(worst, float(entry / size))
        elif entry != 0:
            return float("inf")
    return worst
