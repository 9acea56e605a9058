"""The answer of a solve: the state, Δv, the momenta and what each entry put into them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..formatting import Displayed
from ..named import ByName, Named
from ..robot.arrays import read_only
from ..scene import Scene

if TYPE_CHECKING:
    from .._core import Loads, StateRows
    from .constraint_results import ConstraintResult
    from .flat.scene import NamedPoint
    from .mechanics import Mechanics
    from .outcome import Outcome
    from .scene_jump import Solved

__all__ = ["Answer"]


class Answer(Displayed):
    """The result of ``solve``; ``Impact`` adds quantities derived from it."""

    def __init__(
        self,
        scene: Scene,
        q: np.ndarray,
        v: np.ndarray,
        dv: np.ndarray,
        outcome: Outcome | None = None,
        solved: Solved | None = None,
    ) -> None:
        self.scene = scene
        self._q = q
        self._v = v
        self._dv = dv
        self._outcome = outcome
        self._solved = solved

    @property
    def q(self) -> np.ndarray:
        """(nq,) the configuration; an impact does not change it."""
        return read_only(self._q)

    @property
    def v_before(self) -> np.ndarray:
        """(nv,) the velocity before the impact."""
        return read_only(self._v)

    @property
    def dv(self) -> np.ndarray:
        """(nv,) the velocity jump Δv = v⁺ − v⁻."""
        return read_only(self._dv)

    @cached_property
    def v_after(self) -> np.ndarray:
        """(nv,) the velocity after the impact."""
        return read_only(self._v + self._dv)

    @cached_property
    def mechanics(self) -> Mechanics:
        """Mass matrix, placements and Jacobians at q, for all that is derived from ``dv``."""
        from .mechanics import Mechanics

        return Mechanics(self.scene, self._q, self._v)

    @cached_property
    def generalized_impulse(self) -> np.ndarray:
        """(nv,) I_l = Σ_k v_k^l·∫F_k dt + ω_k^l·∫M_k dt (Chang & Huston 1995, eq. (18))."""
        return read_only(sum(self.impulse_shares.values(), np.zeros(len(self._v))))

    @cached_property
    def impulse_shares(self) -> Mapping[str, np.ndarray]:
        """The momentum balance: by entry name, (nv,) its share in the generalized impulse."""
        shares = self.mechanics.known_impulses()
        if self.constraints:
            matrix, slices = self.mechanics.constraint_matrix, self.mechanics.flat.slices
            for result, where in zip(self.constraints, slices, strict=True):
                shares[result.name] = result.impulse @ matrix[where]
        shares.update(self._contact_shares())
        return ByName({n: read_only(share) for n, share in shares.items()}, "entry")

    def _contact_shares(self) -> dict[str, np.ndarray]:
        shares = {n: np.zeros(len(self._v)) for n in self.scene.entry_names("contacts")}
        outcome = self.outcome
        if outcome is not None and outcome.contacts is not None:
            names = tuple(shares)
            triples = outcome.contacts.impulse.reshape(-1, 3)
            for touch, impulse in zip(outcome.touches, triples, strict=True):
                shares[names[touch.entry]] += impulse @ touch.jacobian
        return shares

    @cached_property
    def constraints(self) -> Named[ConstraintResult]:
        """The impulse of each constraint of the scene, in their order or by name."""
        from .constraint_results import constraint_results

        found = (self.mechanics, self.outcome, self.v_before, self.v_after)
        return Named(constraint_results(*found), "constraint")

    @property
    def outcome(self) -> Outcome | None:
        """The solver's results besides ``dv``; None if there are none."""
        if self._outcome is None and self._solved is not None:
            from .outcome import outcome_of

            self._outcome = outcome_of(self._solved)
        return self._outcome

    @cached_property
    def solved(self) -> Solved:
        """The impact in the core; solved there now where it comes from elsewhere."""
        if self._solved is not None:
            return self._solved
        from .scene_jump import jump_of

        own = self.scene, self._q, self._v
        return jump_of(self.scene).solve(*own, *self._taking_part)

    @property
    def rows(self) -> StateRows:
        """The rows of the core at the points that touched."""
        if self._solved is not None:
            return self._solved.core.rows
        from .scene_jump import jump_of

        return jump_of(self.scene).rows(self._q, self._v, *self._taking_part)

    @property
    def _taking_part(self) -> tuple[set[int] | None, list[NamedPoint] | None]:
        """The contacts that touched, and points of bodies by name; None where all do."""
        if self.outcome is None:
            return None, None
        touches = self.outcome.touches
        features = [(t.entry, t.feature) for t in touches if t.feature is not None and t.turns < 0]
        return {touch.entry for touch in touches}, features or None

    @cached_property
    def loads(self) -> Loads:
        """What the impact does to joints, links and bodies, in the core.

        With Δv known, the recursion of Newton and Euler over the tree gives the wrench through
        every joint: Chang & Huston 1995, eqs. (11), (12), without the gyroscopic couple. Entries
        are those of ``impulses`` on links, then ``held``, then ``contacts``.
        """
        from .._core import impact_loads
        from .flat.links import flat_links_of

        scene, flat = self.scene, self.mechanics.flat
        links = flat_links_of(scene.robot).core
        numbers = np.array([x for entry in scene.impulses for x in entry.values], dtype=float)
        own = flat.core, links, self._q, self._dv, numbers[flat.order]
        if self.outcome is None:
            return impact_loads(*own, None, np.zeros(0), np.zeros(0))
        contacts = self.outcome.contacts
        P = np.zeros(0) if contacts is None else contacts.impulse
        return impact_loads(*own, self.rows, self.outcome.constraint_impulses, P)

    @cached_property
    def momentum_before(self) -> np.ndarray:
        """(nv,) P_l = a_lp y_p before the impact (Chang & Huston 1995, eq. (29))."""
        return read_only(self.mechanics.mass_matrix @ self._v)

    @cached_property
    def momentum_after(self) -> np.ndarray:
        """(nv,) P_l after the impact (Chang & Huston 1995, eq. (29))."""
        return read_only(self.mechanics.mass_matrix @ self.v_after)

    def __getstate__(self) -> dict[str, Any]:
        # What follows from the answer is worked out again on the other side.
        _ = self.outcome
        kept = {name: vars(self)[name] for name in ("scene", "_q", "_v", "_dv", "_outcome")}
        return {**kept, "_solved": None}
