"""One impact along its normal impulse: what it has done so far, and where its phases end.

Compression ends at u_n = 0. Release ends at −e u_n⁻ (Newton), at 1 + e times the impulse of
compression (Poisson), or with e² of its work (Stronge 1990).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from impulsekit.reference import Arithmetic

MOST_EVENTS = 40


@dataclass
class Way:
    """An impact so far, in any numbers; tangents are (2,) in space, numbers in a plane.

    Attributes:
        numbers: what all is made of.
        law, e, target: "newton", "poisson" or "stronge", its e, and Newton's u_n⁺.
        ut, un: velocities now. pt, pn: impulses.
        pressed, spent: impulse and work of compression; regained: work of release.
    """

    numbers: Arithmetic
    law: str
    e: Any
    target: Any
    ut: Any
    un: Any
    pt: Any
    pn: Any
    pressed: Any
    spent: Any
    regained: Any
    compressing: bool = True

    @classmethod
    def begin(cls, numbers: Arithmetic, ut: Any, un: Any, e: Any, law: str) -> Way:
        """Before anything has happened."""
        return cls(numbers, law, e, -e * un, ut, un, ut * 0, *[un * 0] * 4)

    def advance(self, ut: Any, un: Any, pt: Any, pn: Any, work: Any) -> None:
        """Go on by impulses and the work of the normal one, to velocities."""
        if self.compressing:
            self.pressed, self.spent = self.pressed + pn, self.spent + work
        else:
            self.regained = self.regained + work
        self.ut, self.un, self.pt, self.pn = ut, un, self.pt + pt, self.pn + pn

    def go_straight(self, dt: Any, dn: Any, k: Any, slips: bool) -> bool | None:
        """Go on at rates by p_n; whether the phase is over then, None if nothing ever ends.

        Args:
            dt, dn, k: of u_t, u_n and P_t.
            slips: whether u_t can come to a stop.
        """
        phase, along = self.left(dn), np.dot(dt, self.ut)
        stop = -np.dot(self.ut, self.ut) / along if slips and along < 0 else None
        back = -self.un / dn if not self.compressing and dn < 0 and self.un > 0 else None
        steps = [step for step in (phase, stop, back) if step is not None]
        if not steps:
            return None
        step = min(steps)
        work = step * (self.un + step * dn / 2)
        ut = self.ut * 0 if stop is not None and step == stop else self.ut + dt * step
        self.advance(ut, self.un + dn * step, k * step, step, work)
        if phase is not None and step == phase:
            return True
        if back is not None and step == back:
            self.fall_back()
        return False

    def left(self, dn: Any) -> Any | None:
        """The normal impulse that is left of the phase at hand; None if it has no end."""
        if self.compressing:
            return -self.un / dn if dn > 0 else None
        if self.law == "newton":
            return (self.target - self.un) / dn if dn > 0 else None
        if self.law == "poisson":
            return (1 + self.e) * self.pressed - self.pn
        work = -self.e * self.e * self.spent - self.regained
        root = self.un * self.un + 2 * dn * work
        if root < 0:
            return None
        below = self.un + self.numbers.sqrt(root)
        return self.numbers.number(2 * work) / below if below > 0 else None

    def goal(self, un: Any, p: Any, work: Any) -> Any:
        """What is left of the phase, in its own kind, after p more; 0 or less where it is over."""
        if self.compressing:
            return -un
        if self.law == "newton":
            return self.target - un
        if self.law == "poisson":
            return (1 + self.e) * self.pressed - self.pn - p
        return -self.e * self.e * self.spent - self.regained - work

    def fall_back(self) -> None:
        """What was released is pressed again."""
        self.compressing, self.un = True, self.un * 0

    def ends(self) -> bool:
        """At the end of a phase: whether the impact is over; else it is released."""
        if not self.compressing or not self.e > 0:
            return True
        self.compressing, self.un = False, self.un * 0
        return False
