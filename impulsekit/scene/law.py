"""``Law``: how restitution, slip and the order of contacts are understood."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, get_args

from ..errors import InputError
from ..errors.calls import public
from .entry import Checked
from .numbers import between, choice

Restitution = Literal["newton", "poisson", "stronge", "lzb"]
Slip = Literal["end", "path", "compliant"]
Order = Literal["simultaneous", "sequential"]
RESTITUTIONS, SLIPS, ORDERS = map(get_args, (Restitution, Slip, Order))


@public
@dataclass(frozen=True)
class Law(Checked):
    """The laws of contact: restitution, slip and order. Coefficients belong to each contact.

    u is the relative velocity at a contact, n its normal part, t its tangential one;
    P the impulse, µ the friction, e the restitution; − before, + after.

    Attributes:
        restitution: the meaning of e, for the normal of each contact.

            - "newton": u_n⁺ = −e·min(u_n⁻, 0): the separation speed is e times the
              approach speed (Newton 1687).
            - "poisson": P_n ≥ (1 + e) P_n^c, where P_n^c is the impulse of the
              compression, which ends with no approach left (Poisson 1817; for many
              contacts Glocker & Pfeiffer 1995).
            - "stronge": the normal impulse regains W_r = −e² W_c, where W_c is its
              work in compression (Stronge 1990). Needs slip="path".
            - "lzb": energetic, for contacts that act at once: each has a ``stiffness``, impulses
              grow in the proportion dP_i/dP_j = F_i/F_j of F = k δ^exponent, and each regains
              e² of the work of its compressions, which may be several (Liu, Zhao & Brogliato
              2008). Waves run through chains; a contact that has parted comes back by the way
              that it went. With e = 1 it is the limit of elastic springs. One contact alone
              obeys Stronge's law. Friction acts along the path.
        slip: the instant whose slip direction friction opposes.

            - "end": at the end of the impact. P_t = −µ P_n u_t⁺/|u_t⁺|, or
              |P_t| ≤ µ P_n and u_t⁺ = 0 (Moreau 1988; Glocker 2001). Any number
              of contacts.
            - "path": at every instant. dP_t = −µ s dP_n, with s the direction of slip
              at that instant; slip may turn, stop, stay stopped or start again (Routh
              1860; Keller 1986). One frictional contact at a time of those that act on
              each other.
            - "compliant": at every instant, of contacts with springs along their normals and
              tangents, such as rubber: F_t = −κ k ζ, |F_t| ≤ µ F_n, with the ``stiffness_ratio`` κ
              of each contact. They stick, slip and turn back within one impact, as a superball
              does (Maw, Barber & Fawcett 1976; Stronge 2000, ch. 5). Restitution is Stronge's.
              Several that act at once share the impact as under "lzb" with exponent 1, by the
              ``stiffness`` of each, or as equally stiff ones where none has any; a
              ``tangential_damping`` is lost of the tangential springs' work. For κ = ∞ it is
              "path", or "lzb".
        order: of several contacts at one instant.

            - "simultaneous": all at once.
            - "sequential": the fastest approach first, one at a time, until none
              approaches; three equal balls with e = 1 pass the blow on. The fastest
              has the largest |u_n|/√W_nn, the same unit for contacts and joint
              stops. An infinite series of ever weaker hits is taken to its limit.

            With one contact the two differ under Newton's restitution if something
            else acts at the same instant. Simultaneous impulses act together: u_n⁻
            is the velocity before all of them. In a sequence the known impulses act
            first, and u_n⁻ of every hit is the velocity after them. A ball at rest,
            e = 0.5, that a blow drives down at 2 m/s stays at rest in the first case
            and rises at 1 m/s in the second, as it does under Poisson's restitution,
            which uses the impulse of the compression.

        exponent: of "lzb": 1.5 for round surfaces (Hertz), 1 for flat ones.

    Raises:
        UnknownNameError: an unknown name.
        RangeError: an exponent that is not 1 to 10.
        InputError: names that cannot be combined.

    Example:
        >>> Law(restitution="stronge", slip="path")
        Law(restitution='stronge', slip='path', order='simultaneous', exponent=1.5)
    """

    wording = "law"

    restitution: Annotated[Restitution, choice(*RESTITUTIONS, separator=" or ")] = "newton"
    slip: Annotated[Slip, choice(*SLIPS, separator=" or ")] = "end"
    order: Annotated[Order, choice(*ORDERS, separator=" or ")] = "simultaneous"
    exponent: Annotated[float, between(1.0, 10.0)] = 1.5

    def _check(self, what: str) -> None:
        if self.slip == "compliant":
            if self.restitution not in ("newton", "stronge") or self.order == "sequential":
                raise InputError(
                    'law: slip="compliant" has Stronge\'s restitution, of contacts that act at '
                    "once; leave out restitution and order"
                )
            # What its springs regain is work.
            object.__setattr__(self, "restitution", "stronge")
        if self.restitution == "lzb":
            if self.order == "sequential":
                raise InputError(
                    'law: restitution="lzb" is for contacts that act at once; in a sequence use '
                    'restitution="stronge", slip="path", which it is for one contact'
                )
            # Its impulses have a path, along which friction acts.
            object.__setattr__(self, "slip", "path")
        if self.restitution == "stronge" and self.slip == "end":
            raise InputError(
                'law: restitution="stronge" balances the work of the normal impulse, which is '
                'known only along the impact; it needs slip="path"'
            )
