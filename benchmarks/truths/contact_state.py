"""Contacts and known impulses at one state, in long numbers: what any law of theirs starts from."""

from __future__ import annotations

import numpy as np

from impulsekit.reference import Arithmetic
from impulsekit.reference.arithmetic import Array

from .elimination import generalized_inverse
from .found import Found
from .mechanics import Mechanics
from .residuals import Residuals, share_of


class ContactState:
    """M⁻¹, W and u of one state.

    Attributes:
        numbers: what all is made of. m: masses, impulses and rows.
        inverse: (n, n) M⁻¹.
        rows: which of the 3c rows of contacts take part. J, J_size: (k, n) of them.
        moved: (n, k) M⁻¹ Jᵀ. W: (k, k). u: (k,) velocities once known impulses have acted.
        v, known: (n,) velocities before, and what known impulses change.
    """

    def __init__(
        self,
        numbers: Arithmetic,
        mechanics: Mechanics,
        v: np.ndarray,
        rows: list[int] | None = None,
    ) -> None:
        self.numbers, self.m = numbers, mechanics
        weights = mechanics.weights
        scaled, _ = generalized_inverse(
            numbers, mechanics.masses / weights[:, None] / weights[None, :]
        )
        self.inverse = scaled / weights[:, None] / weights[None, :]
        self.rows = list(range(len(mechanics.contacts))) if rows is None else rows
        self.J, self.J_size = mechanics.contacts[self.rows], mechanics.contacts_size[self.rows]
        self.moved = self.inverse @ self.J.T
        self.v, self.known = numbers.array(v), self.inverse @ mechanics.known
        self.W, self.u = self.J @ self.moved, self.J @ (self.v + self.known)

    def impulses_of(self, found: Found | None) -> Array:
        """(c, 3) the impulses of an answer in the contacts' axes; zero where it tells none."""
        impulses = self.numbers.zeros(len(self.m.axes), 3)
        if found is None or found.contacts is None:
            return impulses
        for i, given in enumerate(found.contacts):
            axes = self.m.axes[i]
            if axes is not None and np.isfinite(given).all():
                impulses[i] = axes @ self.numbers.array(given)
        return impulses

    def first_order(self, P: Array, dv: Array) -> tuple[Array, Array]:
        """(n,) by how much relative changes of M and J move Δv, and (k, k) the size of W's."""
        m = self.m
        sizes = m.weights * (m.weights @ np.abs(dv)) + np.abs(P) @ self.J_size + m.known_size
        heavy = m.weights @ np.abs(self.moved)
        across = self.J_size @ np.abs(self.moved)
        return np.abs(self.inverse) @ sizes, np.outer(heavy, heavy) + across + across.T

    def residuals(self, found: Found) -> Residuals:
        """What an answer leaves of M Δv = I + JᵀP; the law is judged by its solutions."""
        if found.dv is None or found.contacts is None:
            return Residuals(np.nan, np.nan)
        m = self.m
        if not np.isfinite(found.dv).all():
            return Residuals(np.inf, np.nan)
        P = self.impulses_of(found).ravel()
        dv = self.numbers.array(found.dv)
        left = np.abs(m.masses @ dv - m.known - P @ m.contacts)
        sizes = m.weights * (m.weights @ np.abs(dv)) + np.abs(P) @ m.contacts_size + m.known_size
        return Residuals(share_of(left, sizes), np.nan)
