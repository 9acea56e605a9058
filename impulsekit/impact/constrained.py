"""Δv with bilateral constraints and contacts: M Δv = I + Aᵀλ + JᵀP, A v⁺ = b, P by law.

λ comes from W λ = b − A v_free with the Delassus matrix W = A M⁻¹ Aᵀ. Contacts see a
system from which the bilateral rows are eliminated: their own Delassus matrix is that
of the rows J projected off the span of A in the metric of M⁻¹.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..laws.rank_tolerances import FAINT_PIVOT, SMALLEST_PIVOT
from ..laws.tolerances import ROUNDING
from ..robot.mass_matrix import crba_of, symmetric
from ..rows.constraints import ConstraintRows
from ..rows.contacts import Touch
from ..rows.entries import JointRows
from ..rows.reach import ReachedModel
from ..scene import Scene
from .elimination import BilateralSolution, Elimination, refined
from .factor import Factor, MassFactor
from .known import KnownImpulses
from .massless_locks import with_massless_locks
from .outcome import Outcome
from .scene_contacts import SceneContacts, with_work_of_rows
from .singular import has_uneven_masses
from .steps import steps_of

if TYPE_CHECKING:
    from .contact_space import ContactSolution

__all__ = ["ConstrainedJump"]


class ConstrainedJump:
    """Δv under bilateral rows and contacts, on CRBA with Cholesky.

    Attributes:
        model, data: of the part of the robot that is reached.
        always_regular: whether no configuration has pivots near rounding error.
        is_sparse: whether Pinocchio's sparse Cholesky supports the model, where pivots allow it.
    """

    def __init__(
        self, scene: Scene, known: KnownImpulses, reached: ReachedModel, *, always_regular: bool
    ) -> None:
        self._known, self._struck = known, bool(scene.impulses)
        self._rows = ConstraintRows.of(scene, reached) if scene.held else None
        self._vectors = np.array(() if self._rows is None else self._rows.triples, dtype=np.int64)
        self._contacts = SceneContacts(scene, reached) if scene.contacts else None
        self.model, self.data = known.model, known.model.createData()
        self._crba = crba_of(self.model)
        self.always_regular = always_regular
        # Rows have to make up for what M lacks at every configuration, whatever pivots say.
        motions = () if always_regular else scene.robot.massless_motions
        self._singular = any(motion.joint in reached.model.names for motion in motions)
        # A row may speak of speeds that are far smaller than others.
        uneven = has_uneven_masses(reached.model)
        # Small pivots of light bodies beside heavy ones are inertia, and are refined.
        self._mass_factor = MassFactor(
            self.model,
            self.data,
            singular=self._singular,
            regular=always_regular,
            least_pivot=SMALLEST_PIVOT if uneven else FAINT_PIVOT,
        )
        blocks = () if self._rows is None else self._rows.blocks
        self._row_by_row = uneven or any(isinstance(block.said, JointRows) for block in blocks)
        self.is_sparse = self._mass_factor.is_sparse

    @property
    def contacts(self) -> SceneContacts:
        """The contacts, of a scene that has some."""
        if self._contacts is None:
            raise InputError("no contacts")
        return self._contacts

    def decompose(self) -> bool:
        """Whether the sparse factor, which is written to ``data``, has no pivot near rounding."""
        return self._mass_factor.decompose()

    def solve(
        self,
        q: np.ndarray,
        v: np.ndarray,
        touching: Container[int] | None = None,
        known: ContactSolution | None = None,
    ) -> tuple[np.ndarray, Outcome | Callable[[], Outcome]]:
        """(nv,) Δv of the reached model, and the impulses that constraints and contacts took.

        ``touching``: the indices of the contacts that take part; None for all that touch.
        ``known``: the solution of contacts without bilateral rows, where it is known already.

        Raises:
            ContradictionError: dependent rows demand different things.
            SingularMassError: M is singular and the constraints do not make up for it.
            InputError, RangeError: what the contact law refuses.
        """
        model, data = self.model, self.data
        impulse = struck = self._known.generalized_impulse(data, q)
        rows = asked = None
        doubt = False
        if self._rows is not None:
            rows, doubt = self._rows.matrix_and_doubt(data, q)
            before = rows.dot(v)
            asked = self._rows.target(before) - before
        touches = [] if self._contacts is None else self._contacts.rows.touching(data, q, touching)
        self._crba(model, data, q)
        factor = self._mass_factor.at(rows)
        if asked is not None:
            impulse = factor.filled(impulse, asked)
        outcome: Outcome | Callable[[], Outcome]
        if not touches:
            dv, outcome = self._without_contacts(factor, impulse, rows, asked, q, v, doubt)
        else:
            given = factor, impulse, rows, asked, touches, q, v, doubt
            dv, outcome = self._with_contacts(*given, known)
        if self._singular and rows is not None and isinstance(outcome, Outcome):
            outcome = with_massless_locks(outcome, self._rows_there, rows, struck, data.M)
        return dv, outcome

    def _without_contacts(
        self,
        factor: Factor,
        impulse: np.ndarray,
        rows: np.ndarray | None,
        asked: np.ndarray | None,
        q: np.ndarray,
        v: np.ndarray,
        doubt: bool,
    ) -> tuple[np.ndarray, Outcome | Callable[[], Outcome]]:
        if rows is None or asked is None:
            return factor.solve(impulse), Outcome(np.empty(0), None)
        found = factor.held(rows, impulse, v, asked, self._vectors, self._row_by_row)
        if found is not None:
            dv, multipliers, unique = found
            self._prescribe(dv, asked, unique)
            return dv, partial(Outcome, multipliers, unique, nearly_dependent=doubt)
        half = factor.half(rows, impulse[None])
        eliminated = Elimination.of(half[:, :-1], self._rows_there, self.data, q)
        solution = self._multipliers(eliminated, half[:, -1], asked, q, v)
        multipliers = solution.impulse
        dv = factor.solve(impulse + multipliers.dot(rows))
        units = self._lacks(asked - rows.dot(dv), rows, dv, v, asked)
        if units is not None:
            multipliers, dv = _refined(factor, eliminated, rows, asked, multipliers, dv, units)
        self._prescribe(dv, asked, solution.unique)
        return dv, Outcome(multipliers, solution.unique, nearly_dependent=doubt or solution.nearly)

    def _lacks(
        self,
        missing: np.ndarray,
        rows: np.ndarray,
        dv: np.ndarray,
        v: np.ndarray,
        asked: np.ndarray,
    ) -> np.ndarray | None:
        """(m,) the units in which A Δv lacks more than its own rounding; None if it does not."""
        if self._row_by_row:
            sizes = np.abs(rows).dot(np.abs(dv) + np.abs(v)) + np.abs(asked)
            lacks = (np.abs(missing) > ROUNDING * sizes).any()
            return np.where(sizes > 0.0, sizes, 1.0) if lacks else None
        # In norms, which cost next to nothing.
        flat = rows.reshape(-1)
        size = flat.dot(flat) * (dv.dot(dv) + v.dot(v)) + asked.dot(asked)
        return np.ones(len(rows)) if missing.dot(missing) > ROUNDING**2 * size else None

    def _with_contacts(
        self,
        factor: Factor,
        impulse: np.ndarray,
        rows: np.ndarray | None,
        asked: np.ndarray | None,
        touches: list[Touch],
        q: np.ndarray,
        v: np.ndarray,
        doubt: bool,
        known: ContactSolution | None,
    ) -> tuple[np.ndarray, Outcome]:
        """Contacts in the system that is left when the bilateral rows are eliminated."""
        contacts = self.contacts
        jacobian = np.concatenate([touch.jacobian for touch in touches])
        before = jacobian.dot(v)
        if rows is None or asked is None:
            return self._with_contacts_alone(factor, impulse, touches, jacobian, before, known)
        count = len(rows)
        half = factor.half(rows, jacobian, impulse[None])
        half_rows, half_contacts, start = half[:, :count], half[:, count:-1], half[:, -1]
        eliminated = Elimination.of(half_rows, self._rows_there, self.data, q)
        held = self._multipliers(eliminated, start, asked, q, v)
        # Rows that are imposed move the contact points, too.
        held_impulse, moved = eliminated.refined(held.impulse, start, asked)
        free = before + moved.dot(half_contacts)
        left = eliminated.off_the_span(half_contacts)
        still = eliminated.still_what_is_held(left, half_contacts)
        if still.any():
            imposed = self._rows_there.target(rows.dot(v))
            free[still] = eliminated.velocity_of_held(still, half_contacts, imposed)
            speeds = np.abs(v)
            sizes = np.abs(jacobian).dot(speeds), np.abs(rows).dot(speeds) + np.abs(imposed)
            rounding = eliminated.rounding_of_held(still, half_contacts, *sizes)
            before, free = (np.where(np.abs(u) <= rounding, 0.0, u) for u in (before, free))
        problem = contacts.problem(left, before, free, touches)
        solution = contacts.solve(problem, touches)

        def borne(contact_impulse: np.ndarray) -> np.ndarray:
            """What the bilateral rows bear of the contacts' impulses."""
            across = left.dot(contact_impulse) - half_contacts.dot(contact_impulse)
            return eliminated.solve(half_rows.T.dot(across)).impulse

        multipliers = held_impulse + borne(solution.impulse)
        dv = factor.solve(impulse + multipliers.dot(rows) + solution.impulse.dot(jacobian))
        units = self._lacks(asked - rows.dot(dv), rows, dv, v, asked)
        if units is not None:
            multipliers, dv = _refined(factor, eliminated, rows, asked, multipliers, dv, units)

        def moved_by(change: np.ndarray) -> np.ndarray:
            return factor.solve(borne(change).dot(rows) + change.dot(jacobian))

        if not contacts.is_met(problem, solution, jacobian, dv):
            first, at_first = solution.impulse, multipliers

            def at(contact_impulse: np.ndarray) -> np.ndarray:
                return at_first + borne(contact_impulse - first)

            acting = impulse - factor.filled(np.zeros_like(impulse), asked)
            steps = steps_of(self._mass_matrix, acting, jacobian, rows, moved_by, at)
            solution, dv = contacts.refined(problem, solution, dv, steps)
            multipliers = at(solution.impulse)
        if contacts.acts_at_once:
            passive = self._rows_there.passive
            own, borne_by, pushed = rows[passive], multipliers[passive], solution.impulse

            def by_blows() -> tuple[float, float]:
                change = factor.solve(impulse)
                total = borne_by.dot(own) + pushed.dot(jacobian)
                sizes = (np.abs(r.dot(v + change)) for r in (own, jacobian))
                more = sum(
                    float(np.abs(p).dot(u)) for p, u in zip((borne_by, pushed), sizes, strict=True)
                )
                return 0.5 * float(total.dot(change)), more

            solution = with_work_of_rows(solution, borne_by, own.dot(v), own.dot(dv), by_blows)
        self._prescribe(dv, asked, held.unique)
        return dv, Outcome(multipliers, held.unique, tuple(touches), solution, doubt or held.nearly)

    def _with_contacts_alone(
        self,
        factor: Factor,
        impulse: np.ndarray,
        touches: list[Touch],
        jacobian: np.ndarray,
        before: np.ndarray,
        known: ContactSolution | None,
    ) -> tuple[np.ndarray, Outcome]:
        """Contacts without bilateral rows."""
        contacts, half_contacts, free = self.contacts, factor.half(jacobian), before
        if self._struck:
            free = before + factor.half(impulse[None])[:, 0].dot(half_contacts)
        problem = contacts.problem(half_contacts, before, free, touches)
        solution = contacts.solve(problem, touches) if known is None else known
        dv = factor.solve(impulse + solution.impulse.dot(jacobian))
        if not contacts.is_met(problem, solution, jacobian, dv):
            steps = steps_of(
                self._mass_matrix,
                impulse,
                jacobian,
                np.empty((0, len(impulse))),
                lambda change: factor.solve(change.dot(jacobian)),
                lambda contact_impulse: np.empty(0),
            )
            solution, dv = contacts.refined(problem, solution, dv, steps)
        return dv, Outcome(np.empty(0), None, tuple(touches), solution)

    def _prescribe(self, dv: np.ndarray, asked: np.ndarray, unique: np.ndarray | None) -> None:
        """Write the speeds that a row each prescribes: rounding has no say in these."""
        prescribed = self._rows_there.prescribed
        if prescribed and unique is None:
            dv[prescribed[0]] = asked[prescribed[1]]

    def _multipliers(
        self,
        eliminated: Elimination,
        start: np.ndarray,
        asked: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> BilateralSolution:
        """λ that brings the rows from where ``start`` (half-solved impulse) leaves them."""
        half_rows = eliminated.half

        def velocity_scale() -> np.ndarray:
            gross = self._rows_there.magnitude(self.data, q)
            return gross @ np.abs(v) + np.abs(half_rows.T @ start)

        return eliminated.solve(asked - start.dot(half_rows), velocity_scale)

    @property
    def _mass_matrix(self) -> np.ndarray:
        """(nv, nv) M as it is in the data."""
        return symmetric(np.atleast_2d(self.data.M))

    @property
    def _rows_there(self) -> ConstraintRows:
        if self._rows is None:
            raise InputError("no constraints")
        return self._rows


def _refined(
    factor: Factor,
    eliminated: Elimination,
    rows: np.ndarray,
    asked: np.ndarray,
    multipliers: np.ndarray,
    dv: np.ndarray,
    units: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """λ (m,) and Δv (nv,) once more from what A Δv still lacks, in units (m,)."""

    def change(missing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        filled, start = factor.filled(np.zeros_like(dv), missing), np.zeros(len(dv))
        if factor.is_filled:
            start = factor.half(filled[None])[:, 0]
        more = eliminated.solve(missing - start.dot(eliminated.half)).impulse
        return more, factor.solve(filled + more.dot(rows))

    return refined(multipliers, dv, lambda made: asked - rows.dot(made), change, units)
