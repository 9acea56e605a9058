"""``derivatives``: an impact made linear in its modes.

With M Δv = I + Aᵀλ + JᵀP differentiated as it stands,

    M d = −∂(M Δv)/∂q + ∂(I + Aᵀλ + JᵀP)/∂q + ∂I + Aᵀ dλ + Jᵀ dP,

and beside it the rows that hold in the modes found: A v⁺ = b, ξ_n = 0, ξ_t = 0 where it
sticks, P_t = −µ P_n ξ_t/|ξ_t| where it slips. Σ of the first terms is Pinocchio's
derivative of inverse dynamics at rest, with Δv for the acceleration and impulses for
outside forces (Carpentier & Mansard 2018).
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...scene import Contact
from ..constrained import Outcome
from ..laws import ContactSolution
from ..result import Impact
from .known_blows import of_known_blows
from .linear import Columns, LinearStage, Rows, Touching, linear_stage, pass_through
from .modes import ContactMode, coefficients_of, found_mode
from .motion import Motion
from .pairs import FixedRows, contact_rows
from .refusals import has_no_answer, refuse_what_has_none
from .result import Derivatives, ImpulseDerivatives
from .status import DerivativeStatus
from .tables import constraint_tables, contact_tables
from .workspace import Workspace, workspace_of

__all__ = ["derivatives"]


def derivatives(impact: Impact) -> Derivatives:
    """How v⁺ and every impulse change with q, v⁻, blows, restitution and friction.

    Analytic, in the modes in which the contacts were found. Newton's and Poisson's laws
    with slip at the end; points of contacts are points of their frame, which move with it.

    Args:
        impact: a solved impact.

    Raises:
        InputError: an impact that has no answer; a law along the path or a sequence of
            contacts, whose answer has modes of its own; a ``Collision``, whose points
            move with the geometry; a restitution given as a function; joints whose axes
            turn with their own coordinates, or that mimic others.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, pendulum_urdf, solve
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> blow = AppliedImpulse("link_1", linear=[3, 0, 0], at=[0, 0, -1], name="blow")
        >>> impact = solve(Scene(rod, [blow]), rod.neutral(), rod.velocity())
        >>> found = derivatives(impact)
        >>> found.status.exists, found.dv_after_dimpulse["blow"].shape
        (True, (1, 6))
    """
    if not isinstance(impact, Impact):
        raise InputError(f"derivatives takes an Impact, not a {type(impact).__name__}")
    refuse_what_has_none(impact)
    workspace = workspace_of(impact.scene)
    outcome = impact.outcome
    if outcome is None or not (outcome.touches or len(outcome.constraint_impulses)):
        return of_known_blows(impact, workspace)
    return _Derivation(impact, workspace).result()


class _Derivation:
    """One call of ``derivatives``."""

    def __init__(self, impact: Impact, workspace: Workspace) -> None:
        self.impact, self.workspace = impact, workspace
        self.scene = impact.scene
        model, data = workspace.model, workspace.data
        self.nv = model.nv
        self.q = workspace.configuration(impact.q)
        pin.computeJointJacobians(model, data, self.q)
        self.motion = Motion(workspace.tree, data)
        self.blows: list[Rows] = [rows.placed(self.motion) for rows in workspace.blows]
        self.bilateral: list[Rows] = [rows.placed(self.motion) for rows in workspace.bilateral]
        outcome = impact.outcome
        self.multipliers = np.zeros(len(workspace.kept))
        self.redundant = False
        if outcome is not None:
            if len(self.multipliers):
                self.multipliers = outcome.constraint_impulses
            contacts = outcome.contacts
            self.redundant = outcome.unique is not None or (
                contacts is not None and contacts.unique is not None
            )
        self.edges: list[str] = []
        self.touching: list[Touching] = []
        self.impulses: list[np.ndarray] = []
        self.scale = 0.0
        if outcome is not None and outcome.contacts is not None:
            self._find_touching(outcome, outcome.contacts)
        self.stages = self._stages()

    def _find_touching(self, outcome: Outcome, solution: ContactSolution) -> None:
        names = self.scene.entry_names("contacts")
        placed: list[Rows] = []
        for touch in outcome.touches:
            entry = self.scene.contacts[touch.entry]
            if isinstance(entry, Contact) and touch.axes is not None:
                placement = self.motion.placements[touch.joint_ids[1]]
                pair = contact_rows(self.scene.robot, entry, touch.axes, placement)
                placed.append(pair.placed(self.motion))
            else:
                placed.append(FixedRows(touch.jacobian))
        befores = [rows.matrix @ self.impact.v_before for rows in placed]
        afters = [rows.matrix @ self.impact.v_after for rows in placed]
        self.scale = max(float(np.abs(u).max()) for u in (*befores, *afters))
        triples = solution.impulse.reshape(-1, 3)
        for touch, rows, before, impulse in zip(
            outcome.touches, placed, befores, triples, strict=True
        ):
            normal = float(before[2])
            own = coefficients_of(
                self.scene.contacts[touch.entry], normal, self.scale, names[touch.entry]
            )
            if own.edge and impulse[2] > 0.0:
                self.edges.append(f"{names[touch.entry]}: {own.edge}")
            self.touching.append(Touching(touch.entry, rows, own, normal))
            self.impulses.append(impulse)

    def _stages(self) -> list[LinearStage]:
        v, after = self.impact.v_before, self.impact.v_after
        if not self.touching or self.scene.law.restitution == "newton":
            return [self._stage(v, after, self.multipliers, self.impulses, None)]
        entries = {point.entry for point in self.touching}
        pressed = self.workspace.compression.solve_touching(self.impact.q, v, entries)
        outcome = pressed.outcome
        if outcome is None or outcome.contacts is None or has_no_answer(outcome.contacts.status):
            raise InputError("derivatives: the compression of this impact has no answer")
        triples = list(outcome.contacts.impulse.reshape(-1, 3))
        held = outcome.constraint_impulses
        back = [all_of - share for all_of, share in zip(self.impulses, triples, strict=True)]
        compressed = [float(share[2]) for share in triples]
        first = self._stage(v, pressed.v_after, held, triples, None)
        rest = self.multipliers - held if len(held) else held
        return [first, self._stage(pressed.v_after, after, rest, back, compressed)]

    def _stage(
        self,
        start: np.ndarray,
        end: np.ndarray,
        multipliers: np.ndarray,
        impulses: list[np.ndarray],
        compressed: list[float] | None,
    ) -> LinearStage:
        """A stage; ``compressed`` are the P_n^c that an expansion starts from."""
        newton = self.scene.law.restitution == "newton"
        modes = self._modes(start, end, impulses, newton, compressed)
        first = compressed is None
        return linear_stage(
            self.workspace,
            self.motion,
            None,
            self.q,
            start,
            end,
            self.blows if first else [],
            self.bilateral,
            multipliers,
            self.touching,
            modes,
            impulses,
            first=first,
            newton=newton,
            redundant=self.redundant,
        )

    def _modes(
        self,
        start: np.ndarray,
        end: np.ndarray,
        impulses: list[np.ndarray],
        newton: bool,
        compressed: list[float] | None,
    ) -> list[ContactMode]:
        names = self.scene.entry_names("contacts")
        workspace = self.workspace
        masses = self.workspace.zero
        if self.touching:
            pin.crba(workspace.model, workspace.data, self.q)
            masses = np.atleast_2d(workspace.data.M).diagonal()
        modes = []
        for i, point in enumerate(self.touching):
            own, rows = point.coefficients, point.rows.matrix
            shifted = rows @ end
            if newton:
                before = rows @ start
                shifted[:2] += own.e_t * before[:2] if own.mu > 0.0 else 0.0
                shifted[2] -= own.e * own.approach
            # Mobility without the coupling of joints: of the size of W, from below.
            mobility = np.einsum("ij,ij->i", rows / masses, rows)
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

    def _pass(self, columns: Columns) -> Any:
        rates = [np.zeros(self.nv)] * len(self.touching)
        if columns.q is not None and any(point.coefficients.slope for point in self.touching):
            before = self.motion.at_speed(self.impact.v_before)
            rates = [point.rows.change_of_velocity(before)[2] for point in self.touching]
        count = len(self.multipliers)
        return pass_through(self.stages, self.touching, rates, columns, count, self.nv)

    def result(self) -> Derivatives:
        """All derivatives."""
        nv = self.nv
        at = 2 * nv
        blows: dict[str, slice] = {}
        names = self.scene.entry_names("impulses")
        for name, rows in zip(names, self.blows, strict=True):
            blows[name] = slice(at, at + len(rows.matrix))
            at += len(rows.matrix)
        entries = sorted({point.entry for point in self.touching})
        restitution = {entry: at + i for i, entry in enumerate(entries)}
        at += len(entries)
        friction = {entry: at + i for i, entry in enumerate(entries)}
        at += len(entries)
        force = np.zeros((nv, at))
        for where, rows in zip(blows.values(), self.blows, strict=True):
            force[:, where] = rows.matrix.T
        columns = Columns(
            at,
            slice(0, nv),
            slice(nv, 2 * nv),
            [force, None][: len(self.stages)],
            restitution,
            friction,
        )
        passed = self._pass(columns)
        contradictory = np.flatnonzero(~passed.consistent)
        for table in (passed.velocity, passed.multipliers, *passed.contacts):
            table[:, contradictory] = np.nan
        passed.velocity.setflags(write=False)
        contact_names = self.scene.entry_names("contacts")

        def parts(table: np.ndarray) -> ImpulseDerivatives:
            table.setflags(write=False)
            return ImpulseDerivatives(
                table[:, :nv],
                table[:, nv : 2 * nv],
                MappingProxyType({name: table[:, where] for name, where in blows.items()}),
                MappingProxyType({contact_names[i]: table[:, c] for i, c in restitution.items()}),
                MappingProxyType({contact_names[i]: table[:, c] for i, c in friction.items()}),
            )

        whole = parts(passed.velocity)
        null = self.stages[0].system.null
        of_constraints = constraint_tables(self.impact, self.bilateral, passed.multipliers, null)
        of_contacts = contact_tables(self.impact, self.touching, passed.contacts, nv)
        status = DerivativeStatus.EXISTS
        if not passed.consistent[: force.shape[1] - 2 * len(entries)].all():
            status = DerivativeStatus.RANK_CHANGES
        elif self.edges:
            status = DerivativeStatus.MODE_EDGE
        return Derivatives(
            self.impact,
            status,
            tuple(dict.fromkeys(self.edges)),
            whole.dq,
            whole.dv,
            whole.dimpulse,
            whole.drestitution,
            whole.dfriction,
            MappingProxyType({name: parts(table) for name, table in of_constraints.items()}),
            MappingProxyType({name: parts(table) for name, table in of_contacts.items()}),
            self._by_inertia,
        )

    def _by_inertia(self, joint_id: int) -> np.ndarray:
        """(nv, 10) ∂v⁺ by the dynamic parameters of a joint's body."""
        workspace = self.workspace
        where = slice(10 * (joint_id - 1), 10 * joint_id)
        forces = []
        for stage in self.stages:
            regressor = pin.computeJointTorqueRegressor(
                workspace.model, workspace.data, self.q, workspace.zero, stage.velocity_change
            )
            forces.append(-np.asarray(regressor).reshape(self.nv, -1)[:, where])
        return self._pass(Columns(10, forces=forces)).velocity
