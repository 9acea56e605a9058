"""An impact as a chain of linear stages, ready for any parameter.

One stage for Newton's law, two for Poisson's: compression and expansion. Columns of
derivatives pass through the stages one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from .factor import Factor
from .modes import Coefficients, ContactMode
from .motion import Motion, Twists
from .pairs import FixedRows, PlacedPair
from .stage import Stage
from .workspace import Workspace

__all__ = ["Columns", "LinearStage", "Passed", "Touching", "linear_stage", "pass_through"]

Rows = PlacedPair | FixedRows


@dataclass(frozen=True, eq=False)
class Touching:
    """A touching point: its place among the contacts of the scene, rows, coefficients."""

    entry: int
    rows: Rows
    coefficients: Coefficients
    normal_before: float


@dataclass(frozen=True, eq=False)
class LinearStage:
    """One stage with all that its rows are given.

    Attributes:
        system: the linear system.
        carrying: which touching points have rows in it.
        modes: theirs.
        velocity_change: (nv,) Δ of the stage.
        force: (nv, nv) what M d is given by the configuration.
        rates: (r, nv) what the rows are given by the configuration.
        entering: (r,) how much of G dv, of the velocity at the start, the rows are given.
        newton: whether restitution shifts velocities here.
    """

    system: Stage
    carrying: tuple[int, ...]
    modes: tuple[ContactMode, ...]
    velocity_change: np.ndarray
    force: np.ndarray
    rates: np.ndarray
    entering: np.ndarray
    newton: bool


@dataclass(eq=False)
class Columns:
    """Parameters in columns. Slices and indices say which column is which.

    Attributes:
        width: how many.
        q, v: the columns of the configuration and of the velocity before, or None.
        forces: by stage, (nv, w) what M d is given beside; None for zero.
        restitution, friction: by contact of the scene, its column.
    """

    width: int
    q: slice | None = None
    v: slice | None = None
    forces: Sequence[np.ndarray | None] = ()
    restitution: dict[int, int] = field(default_factory=dict)
    friction: dict[int, int] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Passed:
    """Derivatives at the end: velocity (nv, w), λ (m, w), P (3, w) by touching point.

    ``consistent`` (w,) tells whether redundant rows agree on them.
    """

    velocity: np.ndarray
    multipliers: np.ndarray
    contacts: list[np.ndarray]
    consistent: np.ndarray


def linear_stage(
    workspace: Workspace,
    motion: Motion,
    factor: Factor | None,
    q: np.ndarray,
    start: np.ndarray,
    end: np.ndarray,
    blows: Sequence[Rows],
    bilateral: Sequence[Rows],
    multipliers: np.ndarray,
    touching: Sequence[Touching],
    modes: Sequence[ContactMode],
    impulses: Sequence[np.ndarray],
    *,
    first: bool,
    newton: bool,
    redundant: bool,
) -> LinearStage:
    """A stage from velocity ``start`` to ``end`` under the impulses found.

    Args:
        blows: the known impulses, where they act in this stage.
        multipliers: (m,) λ of the stage.
        impulses: by touching point, (3,) P of the stage.
        first: whether bilateral rows get their prescribed velocity in this stage.
        newton: whether restitution shifts velocities.
        redundant: whether rows repeat each other.
    """
    model, data = workspace.model, workspace.data
    carrying = tuple(i for i, mode in enumerate(modes) if not mode.parted)
    pulls: list[tuple[Rows, np.ndarray]] = list(zip(blows, workspace.impulses, strict=False))
    at = 0
    for rows in bilateral:
        count = len(rows.matrix)
        pulls.append((rows, multipliers[at : at + count]))
        at += count
    pulls += [(touching[i].rows, impulses[i]) for i in carrying]
    forces = workspace.no_forces()
    for rows, impulse in pulls:
        rows.add_wrenches(forces, impulse)
    change = end - start
    by_q, _, mass_matrix = pin.computeRNEADerivatives(
        model, data, q, workspace.zero, change, forces
    )
    force = -np.asarray(by_q).reshape(model.nv, model.nv)
    for rows, impulse in pulls:
        part = rows.change_of_pull(impulse)
        if part is not None:
            force += part
    stacked = [rows.matrix for rows in bilateral] + [touching[i].rows.matrix for i in carrying]
    matrix = np.concatenate(stacked) if stacked else np.zeros((0, model.nv))
    rates = np.zeros_like(matrix)
    entering = np.ones(len(matrix))
    if stacked:
        after = motion.at_speed(end)
        known: list[Twists] = []

        def before() -> Twists:
            """The twists at the start; most scenes do not ask for them."""
            if not known:
                known.append(motion.at_speed(start))
            return known[0]

        at = 0
        for rows in bilateral:
            where = slice(at, at + len(rows.matrix))
            kept = workspace.kept[where] if first else np.ones(len(rows.matrix), dtype=bool)
            rates[where] = -rows.change_of_velocity(after)
            if kept.any():
                rates[where] += np.where(kept[:, None], rows.change_of_velocity(before()), 0.0)
                entering[where] = np.where(kept, 0.0, 1.0)
            at = where.stop
        for i in carrying:
            where = slice(at, at + 3)
            rates[where] = -touching[i].rows.change_of_velocity(after)
            shift = _shift(touching[i].coefficients, touching[i].normal_before)
            if newton and shift.any():
                rates[where] -= shift[:, None] * touching[i].rows.change_of_velocity(before())
                entering[where] += shift
            at += 3
    if factor is None:
        factor = Factor(
            np.asarray(mass_matrix).reshape(model.nv, model.nv), matrix[: len(multipliers)]
        )
    system = Stage(
        factor,
        matrix,
        len(multipliers),
        [modes[i] for i in carrying],
        redundant=redundant,
        speed=float(max(np.abs(start).max(), np.abs(end).max())),
    )
    return LinearStage(
        system,
        carrying,
        tuple(modes[i] for i in carrying),
        change,
        force,
        rates,
        entering,
        newton,
    )


def _shift(own: Coefficients, normal_before: float) -> np.ndarray:
    """(3,) ∂ξ/∂u⁻ of Newton's law: e_t, e_t, and d(e u_n)/du_n while it approaches."""
    by_normal = own.e + own.slope * own.approach if normal_before < 0.0 else 0.0
    by_tangent = own.e_t if own.mu > 0.0 else 0.0
    return np.array([by_tangent, by_tangent, by_normal])


def pass_through(
    stages: Sequence[LinearStage],
    touching: Sequence[Touching],
    normal_rates: Sequence[np.ndarray],
    columns: Columns,
    count: int,
    nv: int,
) -> Passed:
    """Parameters through all stages.

    Args:
        normal_rates: by touching point, (nv,) ∂(J_n v⁻)/∂q; used where an expansion holds P_n.
        count: of bilateral rows.
        nv: of the robot.
    """
    width = columns.width
    velocity = np.zeros((nv, width))
    if columns.v is not None:
        velocity[:, columns.v] = np.eye(nv)
    initial = velocity
    multipliers = np.zeros((count, width))
    contacts = [np.zeros((3, width)) for _ in touching]
    consistent = np.ones(width, dtype=bool)
    for number, stage in enumerate(stages):
        rows = stage.system.rows
        given = -(stage.entering[:, None] * (rows @ velocity))
        if columns.q is not None:
            given[:, columns.q] += stage.rates
        at = count
        for i, mode in zip(stage.carrying, stage.modes, strict=True):
            point = touching[i]
            own, normal = point.coefficients, at + 2
            column = columns.restitution.get(point.entry)
            if stage.newton and column is not None and point.normal_before < 0.0:
                given[normal, column] -= point.normal_before
            if mode.held:
                change = np.zeros(width)
                if own.slope and point.normal_before < 0.0:
                    change = -own.slope * (point.rows.matrix[2] @ initial)
                    if columns.q is not None:
                        change[columns.q] -= own.slope * normal_rates[i]
                if column is not None:
                    change[column] += 1.0
                given[normal] = change * mode.compressed + own.e * contacts[i][2]
            if not mode.sticking:
                across = np.eye(2) - np.outer(mode.slip, mode.slip)
                given[at:normal] = mode.resistance * (across @ given[at:normal])
                column = columns.friction.get(point.entry)
                if column is not None:
                    given[at:normal, column] -= mode.normal_impulse * mode.slip
            at += 3
        force = columns.forces[number] if columns.forces else None
        if columns.q is not None:
            force = np.zeros((nv, width)) if force is None else force.copy()
            force[:, columns.q] += stage.force
        response = stage.system.respond(force, given)
        consistent &= response.consistent
        velocity = velocity + response.velocity
        multipliers = multipliers + response.impulse[:count]
        contacts = list(contacts)
        for place, i in enumerate(stage.carrying):
            first = count + 3 * place
            contacts[i] = contacts[i] + response.impulse[first : first + 3]
    return Passed(velocity, multipliers, contacts, consistent)
