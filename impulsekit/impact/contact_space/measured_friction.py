"""Friction that is more than one number: static and kinetic, by slip speed, by direction.

Each is brought to Coulomb's law with one µ by contact. An ellipse is a circle in other units:
with P_t = A y, |y| ≤ P_n, and rows Aᵀ u_t the law for y has µ = 1. What slips has its kinetic µ:
all contacts begin with the static one, and those that slip are solved again with the other,
which they keep, so that a lawful answer in which nothing slips is found first. µ by slip speed
is the µ for which µ = f(|u_t⁺|).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...laws.status import Status
from ...laws.tolerances import BAR
from ...scene.friction import EllipticFriction, StaticKinetic, friction_at, units_of_ellipse
from ...scene.law import Law
from ..turning_results import NO_SLIP
from .problem import ContactProblem, ContactSolution

__all__ = ["solve_measured"]

# µ by speed is found to this, relative to 1 + µ.
FOUND = 1e-13
# Of Broyden's method, at most.
MOST_STEPS = 60


def solve_measured(
    problem: ContactProblem,
    law: Law,
    models: Sequence[Any],
    along: Sequence[np.ndarray | None],
    solve: Callable[[ContactProblem, Law], ContactSolution],
) -> ContactSolution:
    """The impulses of contacts, with the µ that each has in the end in ``friction``.

    Args:
        problem: its friction is not used.
        law: Newton's or Poisson's, with slip at the end.
        models: (n,) the friction of each contact.
        along: (n,) of an ellipse (2,) its first axis in the contact's tangents, or None.
        solve: the law for one µ by contact.
    """
    rounded = _Rounded(problem, models, along)
    pairs = zip(models, along, strict=True)
    mu = np.array([1.0 if axis is not None else friction_at(f, 0.0) for f, axis in pairs])
    steps = [i for i, f in enumerate(models) if isinstance(f, StaticKinetic)]
    smooth = [i for i, f in enumerate(models) if callable(f) and i not in steps]
    kinetic: set[int] = set()
    while True:
        found, mu = _by_speed(rounded, law, mu, models, smooth, solve)
        if not found.status.obeys_law and found.status is not Status.ENERGY_GAIN:
            break
        slips = {i for i in steps if rounded.speed(found, i) > 0.0} - kinetic
        if not slips:
            break
        kinetic |= slips
        mu = mu.copy()
        for i in slips:
            mu[i] = models[i].kinetic
    return rounded.back(found, mu, law)


def _by_speed(
    rounded: _Rounded,
    law: Law,
    mu: np.ndarray,
    models: Sequence[Any],
    smooth: list[int],
    solve: Callable[[ContactProblem, Law], ContactSolution],
) -> tuple[ContactSolution, np.ndarray]:
    """The solution in which µ = f(|u_t⁺|) at each contact of ``smooth``, and all µ (Broyden)."""
    mu = mu.copy()
    found = solve(rounded.with_friction(mu), law)
    if not smooth:
        return found, mu

    def missing() -> np.ndarray:
        return np.array([friction_at(models[i], rounded.speed(found, i)) - mu[i] for i in smooth])

    # Broyden's method from the fixed point iteration, whose slope is −1.
    left, inverse = missing(), np.eye(len(smooth))
    for _ in range(MOST_STEPS):
        if not found.status.obeys_law or np.abs(left).max() <= FOUND * (1.0 + mu.max()):
            break
        before, step = mu[smooth], inverse @ left
        mu[smooth] = np.maximum(before + step, 0.0)
        found = solve(rounded.with_friction(mu), law)
        change, moved = missing() - left, mu[smooth] - before
        left = left + change
        across = moved @ inverse @ change
        if across:
            inverse -= np.outer(moved + inverse @ change, moved @ inverse) / across
    if np.abs(left).max() > BAR * (1.0 + mu.max()):
        found = dataclasses.replace(found, status=Status.NOT_CONVERGED)
    residual = max(found.residual, float(np.abs(left).max()) / (1.0 + float(mu.max())))
    return dataclasses.replace(found, residual=residual), mu


class _Rounded:
    """A problem in which ellipses are circles."""

    def __init__(
        self, problem: ContactProblem, models: Sequence[Any], along: Sequence[np.ndarray | None]
    ) -> None:
        self._problem, self._ways = problem, None
        self._rounded = problem
        if any(a is not None for a in along):
            ways = np.eye(len(problem.velocity_free))
            for i, (model, axis) in enumerate(zip(models, along, strict=True)):
                if axis is not None and isinstance(model, EllipticFriction):
                    own = slice(3 * i, 3 * i + 2)
                    ways[own, own] = units_of_ellipse(model, axis)
            self._ways = ways
            self._rounded = dataclasses.replace(
                problem,
                delassus=ways.T @ problem.delassus @ ways,
                velocity_before=problem.velocity_before @ ways,
                velocity_free=problem.velocity_free @ ways,
            )

    def with_friction(self, mu: np.ndarray) -> ContactProblem:
        """The problem with one µ by contact."""
        return dataclasses.replace(self._rounded, friction=mu)

    def speed(self, found: ContactSolution, i: int) -> float:
        """How fast a contact that is pressed slips at the end, in its own units; 0 for rounding."""
        adhesion = self._problem.adhesion
        # What adheres rubs while it is pulled, too.
        pressed = found.impulse[3 * i + 2] + (0.0 if adhesion is None else adhesion[i])
        if not pressed > 0.0:
            return 0.0
        after = found.velocity_after
        speed = float(np.hypot(after[3 * i], after[3 * i + 1]))
        return speed if speed > NO_SLIP * self._rounded.fastest(after) else 0.0

    def back(self, found: ContactSolution, mu: np.ndarray, law: Law) -> ContactSolution:
        """The solution in the units of the problem."""
        own, n = self._problem, len(self._problem.friction)
        used = np.zeros(len(found.impulse) // 3)
        used[:n] = mu
        if self._ways is None:
            return dataclasses.replace(found, friction=used)
        impulse = self._ways @ found.impulse
        for i in range(n):
            # The µ of the direction in which friction acts.
            size = float(np.hypot(*found.impulse[3 * i : 3 * i + 2]))
            if size > 0.0:
                used[i] *= float(np.hypot(*impulse[3 * i : 3 * i + 2])) / size
        start = own.velocity_before if law.restitution == "newton" else own.velocity_free
        return dataclasses.replace(
            found,
            impulse=impulse,
            velocity_after=own.velocity_free + own.delassus @ impulse,
            velocity_start=start,
            friction=used,
        )
