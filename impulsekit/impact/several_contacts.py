"""Several contacts of points on planes that stand still: the shortest way to Δv.

Between Pinocchio's rows, its factor of M and the answer there is one compiled call. The rest of
the outcome is computed on first access. Residuals above machine precision go to
``ConstrainedJump``, which refines the impulses.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from functools import partial

import numpy as np

from ..laws.status import BY_CODE, Status
from ..laws.struck import PlainTogether, Together, strike_at_once
from ..laws.struck_in_turn import strike_in_turn
from ..laws.words import AGAIN, END, PATH
from ..rows.reach import ReachedModel
from ..scene import Scene
from ..scene.law import RESTITUTIONS
from .algorithms import crba
from .constrained import ConstrainedJump
from .contact_space import ContactSolution
from .known import KnownImpulses
from .outcome import Outcome
from .scene_contacts import SceneContacts

__all__ = ["SeveralContactsJump", "outcome_of_some", "shortest_way"]

# Time that one call saves against ``ConstrainedJump`` [s], about: compiling waits until it pays.
SAVED_OF_SEVERAL = 2e-5
_GAIN = int(Status.ENERGY_GAIN)


class SeveralContactsJump:
    """Δv with several plain contacts, at once with slip at the end, or in sequence."""

    def __init__(self, scene: Scene, general: ConstrainedJump, coefficients: np.ndarray) -> None:
        self._general, self._coefficients = general, coefficients
        self._points = general.contacts.rows.plain_points()
        law = scene.law
        self._in_turn = law.order == "sequential"
        self._restitution = RESTITUTIONS.index(law.restitution)
        self._slip = END if law.slip == "end" else PATH

    def solve(
        self, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, Callable[[], Outcome] | Outcome]:
        """(nv,) Δv of the reached model, and the rest of the outcome or a call that gives it.

        Raises:
            As ``ConstrainedJump.solve``.
        """
        entry = strike_in_turn if self._in_turn else strike_at_once
        if not entry.is_compiled:
            entry.wait(SAVED_OF_SEVERAL)
            return self._general.solve(q, v)
        model, data = self._general.model, self._general.data
        rows = np.concatenate([point.jacobian_at(data, q) for point in self._points])
        crba(model, data, q)
        if not self._general.decompose():
            return self._general.solve(q, v)
        given = data.U.T, data.D, rows, v, self._coefficients, self._restitution
        found = strike_in_turn(*given, self._slip) if self._in_turn else strike_at_once(*given)
        code, residual, off, fastest = found[:4]
        if code in (AGAIN, _GAIN):
            # Another answer may gain no energy.
            return self._general.solve(q, v)
        if not self._general.contacts.is_near(residual, off, fastest):
            return self._general.solve(q, v, known=self._solution(found))
        return found[6], partial(self._outcome, rows, found)

    def _solution(self, found: PlainTogether) -> ContactSolution:
        return _solution(self._general.contacts, Together(*found), in_turn=self._in_turn)

    def _outcome(self, rows: np.ndarray, found: PlainTogether) -> Outcome:
        touches = tuple(
            point.touch_of(self._general.data, rows[3 * i : 3 * i + 3])
            for i, point in enumerate(self._points)
        )
        return Outcome(np.empty(0), None, touches, self._solution(found))


def outcome_of_some(
    general: ConstrainedJump, q: np.ndarray, said: Together, touching: Container[int]
) -> Outcome:
    """The outcome of some plain contacts that were solved at once.

    Args:
        q: (nq,) of the reached model.
    """
    touches = general.contacts.rows.touching(general.data, q, touching)
    solution = _solution(general.contacts, said, in_turn=False)
    return Outcome(np.empty(0), None, tuple(touches), solution)


def _solution(contacts: SceneContacts, said: Together, *, in_turn: bool) -> ContactSolution:
    status = BY_CODE[said.code]
    impulse, after, before = said.points
    normal, friction, unique = said.works
    none_shared = status is Status.SOLVED and not in_turn
    solution = ContactSolution(
        impulse,
        after,
        status,
        said.residual,
        None if none_shared or unique.all() else unique > 0.0,
        before,
        normal,
        friction,
        said.hits,
        said.tied,
    )
    return contacts.with_status(solution)


def shortest_way(
    scene: Scene, known: KnownImpulses, reached: ReachedModel, *, always_regular: bool
) -> ConstrainedJump | SeveralContactsJump:
    """The fastest algorithm for a scene with bilateral rows or contacts."""
    general = ConstrainedJump(scene, known, reached, always_regular=always_regular)
    if scene.held or scene.impulses or len(scene.contacts) < 2 or not general.is_sparse:
        return general
    coefficients = general.contacts.plain_coefficients()
    if coefficients is None or not general.contacts.rows.plain_points():
        return general
    return SeveralContactsJump(scene, general, coefficients)
