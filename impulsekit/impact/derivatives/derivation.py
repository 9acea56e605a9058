"""An impact made linear in its modes.

With M Δv = I + Aᵀλ + JᵀP differentiated as it stands,

    M d = −∂(M Δv)/∂q + ∂(I + Aᵀλ + JᵀP)/∂q + ∂I + Aᵀ dλ + Jᵀ dP,

and beside it the rows that hold in the modes found: A v⁺ = b, ξ_n = 0, ξ_t = 0 where it
sticks, P_t = −µ P_n ξ_t/|ξ_t| where it slips: one linear system at the answer (implicit function
theorem). The derivatives of M and of the rows are the core's.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._core import inertia_regressor
from ...errors import InputError
from ...scene import Law
from ..contact_law import ContactProblem, ContactSolution, solve_contacts
from ..outcome import Touch
from ..result import Impact
from .building import Builder
from .hits import UNMOVED, HitFound, follow_hits
from .linear import Columns, LinearStage, ModeStage, Touching, pass_through
from .modes import PARTED, ContactMode, coefficients_of, found_mode
from .path_stage import PathStage, change_of_block, path_derivative
from .result import Derivatives
from .shared_loads import is_split_open
from .stage import Loads
from .state_rows import RowBlock, StateRows
from .tables import told
from .workspace import Workspace

__all__ = ["Derivation", "acts_before"]


def acts_before(impact: Impact) -> bool:
    """Whether something changes the velocity before a sequence of hits begins.

    Then even one contact has two laws: e of its approach before the impact where all acts
    together, and of its approach behind the blow where it is hit after it.
    """
    scene = impact.scene
    struck = scene.law.order == "sequential" and bool(scene.impulses)
    return struck or bool(scene.held)


class Derivation:
    """One call of ``derivatives``."""

    def __init__(self, impact: Impact, workspace: Workspace) -> None:
        self.impact, self.workspace = impact, workspace
        self.scene, self.nv = impact.scene, workspace.model.nv
        self.v, self.after = impact.v_before, impact.v_after
        outcome = impact.outcome
        touches = () if outcome is None else outcome.touches
        contacts = None if outcome is None else outcome.contacts
        rows = StateRows(self.scene, workspace.flat, np.array(impact.q), touches)
        self.rows = rows
        self.multipliers = np.zeros(len(workspace.kept))
        if outcome is not None and len(outcome.constraint_impulses):
            self.multipliers = outcome.constraint_impulses
        redundant = outcome is not None and (
            outcome.unique is not None or (contacts is not None and contacts.unique is not None)
        )
        self.builder = Builder(workspace, rows, redundant=redundant)
        self.edges: list[str] = []
        self.touching: list[Touching] = []
        self.impulses: list[np.ndarray] = []
        self.scale = 0.0
        if contacts is not None:
            self._find_touching(touches, contacts)
        self.stages = self._stages()

    def _thrown(self, matrix: np.ndarray) -> np.ndarray:
        """(r,) what blows alone would add to the velocities of rows.

        What rests and is struck has no other that its modes can be told by.
        """
        if not self.scene.impulses:
            return np.zeros(0)
        mechanics = self.impact.mechanics
        blow = np.sum(list(mechanics.known_impulses().values()), axis=0)
        # Least squares, since M may be singular where constraints make up for it.
        change: np.ndarray = matrix.dot(np.linalg.lstsq(mechanics.mass_matrix, blow, rcond=None)[0])
        return change

    def _find_touching(self, touches: Sequence[Touch], solution: ContactSolution) -> None:
        names = self.workspace.contact_names
        matrix = np.concatenate([rows.matrix for rows in self.rows.points])
        before, after = matrix.dot(self.v).tolist(), matrix.dot(self.after).tolist()
        self.scale = max(map(abs, (*before, *after, *self._thrown(matrix))))
        self.impulses = list(solution.impulse.reshape(-1, 3))
        for touch, rows, normal, impulse in zip(
            touches, self.rows.points, before[2::3], self.impulses, strict=True
        ):
            name = names[touch.entry]
            own = coefficients_of(self.scene.contacts[touch.entry], normal, self.scale, name)
            if own.edge and impulse[2] > 0.0:
                self.edges.append(f"{name}: {own.edge}")
            by_q = by_v = None
            if own.slope and own.approach > 0.0:
                by_q = -own.slope * rows.change_of_velocity(self.v)[2]
                by_v = -own.slope * rows.matrix[2]
            self.touching.append(Touching(touch.entry, rows, own, by_q, by_v))

    def _stages(self) -> list[LinearStage]:
        v, after, law = self.v, self.after, self.scene.law
        in_turn = len(self.touching) > 1 or acts_before(self.impact)
        # Without friction the path of slip is of no matter, but for the work on the way.
        along = law.slip == "path" and (
            law.restitution == "stronge" or any(point.coefficients.mu for point in self.touching)
        )
        if self.touching and (along or (law.order == "sequential" and in_turn)):
            return self._hit_stages(along)
        if not self.touching or law.restitution == "newton":
            return [self._stage(v, after, self.multipliers, self.impulses)]
        entries = {point.entry for point in self.touching}
        pressed = self.workspace.compression.solve_touching(self.impact.q, v, entries)
        outcome = pressed.outcome
        if outcome is None or outcome.contacts is None or not pressed.status.obeys_law:
            raise InputError("derivatives: the compression of this impact has no solution")
        triples = list(outcome.contacts.impulse.reshape(-1, 3))
        held = outcome.constraint_impulses
        back = [all_of - share for all_of, share in zip(self.impulses, triples, strict=True)]
        compressed = [float(share[2]) for share in triples]
        middle = pressed.v_after.copy()
        first = self._stage(v, middle, held, triples)
        rest = self.multipliers - held if len(held) else held
        return [first, self._stage(middle, after, rest, back, compressed, first=False)]

    def _hit_stages(self, along_path: bool) -> list[LinearStage]:
        """What acts freely, then one contact after the other."""
        law, names = self.scene.law, self.workspace.contact_names
        nothing = [np.zeros(3)] * len(self.touching)
        hits = follow_hits(
            law,
            self.builder.held_mass,
            self.touching,
            [names[point.entry] for point in self.touching],
            self.v,
            self.after,
            self.multipliers,
            self.impulses,
            self.scale,
        )
        self.edges += hits.edges
        stages: list[LinearStage] = [
            self._stage(self.v, hits.free, hits.free_multipliers, nothing, acting=-1)
        ]
        for hit in hits.found:
            if along_path:
                stages.append(self._path_stage(hit))
                continue
            own = list(nothing)
            own[hit.point] = hit.impulse
            if law.restitution == "newton":
                way = [(hit.start, hit.end, hit.multipliers, own, None)]
            else:
                way = self._halves(hit, own)
            for start, end, multipliers, impulses, compressed in way:
                stages.append(
                    self._stage(
                        start,
                        end,
                        multipliers,
                        impulses,
                        compressed,
                        first=False,
                        acting=hit.point,
                    )
                )
        return stages

    def _path_stage(self, hit: HitFound) -> PathStage:
        """One contact along the path of its slip."""
        law, point = self.scene.law, self.touching[hit.point]
        own = point.coefficients
        free = point.rows.matrix @ hit.start
        # Along what bilateral rows hold, slip is rounding, and no friction ends it.
        held = hit.block.diagonal() == 0.0
        free[held & (np.abs(free) <= UNMOVED * self.scale)] = 0.0
        from_start = law.order == "sequential"
        before = float(free[2]) if from_start else float(point.rows.matrix[2] @ self.v)
        found = path_derivative(hit.block, free, before, own.e, own.mu, law.restitution)
        name = self.workspace.contact_names[point.entry]
        self.edges += [f"{name}: {edge}" for edge in found.edges]
        impulses = [np.zeros(3)] * len(self.touching)
        impulses[hit.point] = hit.impulse
        bare = self._stage(hit.start, hit.end, hit.multipliers, impulses, first=False, acting=-1)
        return PathStage(
            bare,
            hit,
            self.touching,
            found,
            change_of_block(self.builder, hit, point.rows),
            point.rows.change_of_velocity(hit.start),
            None if from_start else point.rows.change_of_velocity(self.v)[2],
        )

    def _halves(self, hit: HitFound, own: list[np.ndarray]) -> list[Any]:
        """Compression and expansion of one hit under Poisson's law."""
        point = self.touching[hit.point]
        u = point.rows.matrix @ hit.start
        none = np.zeros(1)
        pressed = ContactProblem(hit.block, u, u, none, np.array([point.coefficients.mu]), none)
        share = solve_contacts(pressed, Law()).impulse
        # Bilateral rows bear and bodies move in proportion to the impulse of one contact.
        held, middle = hit.at(share)
        first, back = list(own), list(own)
        first[hit.point], back[hit.point] = share, hit.impulse - share
        compressed = [0.0] * len(own)
        compressed[hit.point] = float(share[2])
        return [
            (hit.start, middle, held, first, None),
            (middle, hit.end, hit.multipliers - held, back, compressed),
        ]

    def _stage(
        self,
        start: np.ndarray,
        end: np.ndarray,
        multipliers: np.ndarray,
        impulses: Sequence[np.ndarray],
        compressed: list[float] | None = None,
        *,
        first: bool = True,
        acting: int | None = None,
    ) -> ModeStage:
        """A stage.

        Args:
            compressed: the P_n^c that an expansion starts from.
            first: whether known impulses and imposed velocities act in it.
            acting: the one touching point that takes part, −1 for none; None for all.
        """
        newton = self.scene.law.restitution == "newton"
        pulls: list[tuple[RowBlock, np.ndarray]] = [(self.builder.held, multipliers)]
        pulls += [(point.rows, p) for point, p in zip(self.touching, impulses, strict=True)]
        if first:
            pulls += zip(self.rows.blows, self.workspace.impulses, strict=True)
        loads: list[tuple[slice, np.ndarray]] = [
            (slice(0, self.nv), self.builder.load(end - start, pulls))
        ]
        if first:
            columns = self.workspace.blow_columns.values()
            loads += [
                (where, rows.matrix.T) for where, rows in zip(columns, self.rows.blows, strict=True)
            ]
        modes = self._modes(start, end, impulses, newton, compressed, acting)
        return self.builder.stage(
            loads, start, end, self.touching, modes, first=first, newton=newton
        )

    def _modes(
        self,
        start: np.ndarray,
        end: np.ndarray,
        impulses: Sequence[np.ndarray],
        newton: bool,
        compressed: list[float] | None,
        acting: int | None,
    ) -> list[ContactMode]:
        names = self.workspace.contact_names
        modes: list[ContactMode] = []
        if not self.touching:
            return modes
        per_mass = 1.0 / self.rows.masses.diagonal()
        for i, point in enumerate(self.touching):
            if acting is not None and i != acting:
                modes.append(PARTED)
                continue
            own, rows = point.coefficients, point.rows.matrix
            shifted = rows.dot(end)
            if newton and own.e_t and own.mu > 0.0:
                shifted[:2] += own.e_t * rows[:2].dot(start)
            if newton and own.e:
                shifted[2] += own.e * min(float(rows[2].dot(start)), 0.0)
            # Mobility without the coupling of joints: of the size of W, from below.
            mobility = (rows * rows).dot(per_mass)
            mode = found_mode(
                impulses[i],
                shifted,
                own.mu,
                mobility,
                self.scale,
                names[point.entry],
                own.e if compressed else 0.0,
                compressed[i] if compressed else 0.0,
            )
            self.edges += mode.edges
            modes.append(mode)
        return modes

    def result(self) -> Derivatives:
        """All derivatives."""
        passed = pass_through(
            self.stages,
            self.touching,
            self.workspace.columns(tuple(point.entry for point in self.touching)),
            len(self.multipliers),
        )
        if is_split_open(self.impact):
            passed.consistent = np.zeros(passed.columns.width, dtype=bool)
        elif passed.columns.q is not None and self._shares_change():
            if passed.consistent is None:
                passed.consistent = np.ones(passed.columns.width, dtype=bool)
            passed.consistent[passed.columns.q] = False
        return told(
            self.impact,
            self.workspace,
            passed,
            self.touching,
            self.stages[0].null,
            tuple(dict.fromkeys(self.edges)),
            self.by_inertia,
        )

    def _shares_change(self) -> bool:
        """Whether v⁺ hangs on shares of load that change with the configuration."""
        even = any(
            isinstance(one, ModeStage) and one.system.even is not None for one in self.stages
        )
        return even

    def by_inertia(self, joint_id: int) -> np.ndarray:
        """(nv, 10) ∂v⁺ by the dynamic parameters of a joint's body."""
        flat, q = self.workspace.flat.model, np.array(self.impact.q)
        body = flat.bodies[joint_id]

        def change(x: np.ndarray) -> tuple[slice, np.ndarray]:
            own = inertia_regressor(flat.core, q, np.ascontiguousarray(x), body)
            return slice(0, 10), -own.reshape(self.nv, 10)

        loads: list[Loads] = []
        for stage in self.stages:
            parts = [change(stage.velocity_change)]
            if isinstance(stage, PathStage):
                parts += [change(x) for x in stage.unit_changes]
            loads.append(parts)
        count = len(self.multipliers)
        passed = pass_through(self.stages, self.touching, Columns(10, loads=loads), count)
        if passed.velocity is None:
            raise InputError("derivatives: no stage")
        return passed.velocity
