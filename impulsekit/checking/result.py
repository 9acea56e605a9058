"""``Check``: each quantity of an impact beside the reference's, and the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..display import Displayed, one_line
from ..reference import KaneImpact, Load, Rows
from ..reference.kinematics import Kinematics
from ..robot.arrays import lock
from .sizes import Conditions, Sizes, sizes_of
from .system import ReferenceRobot

if TYPE_CHECKING:
    from ..impact import Impact


@dataclass(frozen=True, eq=False)
class CheckRow:
    """One quantity by both programs.

    Attributes:
        name: what it is.
        unit: of the entries; several where they differ from entry to entry.
        entries: (k,) the name of each entry.
        ours, reference: (k,) the numbers, read-only.
        difference: the largest difference of an entry, relative to ``scale``.
        scale: in words, what the difference is relative to.
        tolerance: what the difference may be.
        worst: the index of the entry that is furthest apart.
    """

    name: str
    unit: str
    entries: tuple[str, ...]
    ours: np.ndarray
    reference: np.ndarray
    difference: float
    scale: str
    tolerance: float
    worst: int

    @property
    def agrees(self) -> bool:
        """Return whether the difference is within the tolerance; NaN is not."""
        return bool(self.difference <= self.tolerance)

    def __repr__(self) -> str:
        verdict = "agrees" if self.agrees else "DISAGREES"
        return f"CheckRow({self.name!r}, {self.difference:.1e} of {self.tolerance:.1e}: {verdict})"


@dataclass(frozen=True, eq=False, repr=False)
class Check(Displayed):
    """An impact beside its reference.

    Attributes:
        rows: the quantities, in the order of a report.
        tolerance: what their differences may be; see :func:`impulsekit.check`.
        condition: of the generalized masses, scaled to unit diagonal.
        condition_of_rows: the same of the Delassus matrix of the independent constraint
            rows; 1 without any.
        numbers: what the reference computed in, such as "double".
        notes: what has to be known of how it was compared.
    """

    rows: tuple[CheckRow, ...]
    tolerance: float
    condition: float
    condition_of_rows: float
    numbers: str
    notes: tuple[str, ...] = ()

    @property
    def agrees(self) -> bool:
        """Return whether every row agrees."""
        return all(row.agrees for row in self.rows)

    def row(self, name: str) -> CheckRow:
        """The row of this name.

        Raises:
            UnknownNameError: there is none.
        """
        for row in self.rows:
            if row.name == name:
                return row
        from ..errors import UnknownNameError

        raise UnknownNameError.among("row of a check", name, (row.name for row in self.rows))

    def report(self) -> str:
        """The comparison as a table: each quantity at the entry that is furthest apart."""
        return "\n".join(self.lines()) + "\n"

    def lines(self) -> list[str]:
        """The lines of the report; those of the table know its cells."""
        from ..display.table import table

        lines = [
            f"Check against Kane's equations ({self.numbers}), furthest entry of each quantity"
        ]
        head = ["quantity", "entry", "ours", "reference", "unit", "difference", "agrees"]
        lines += table(head, [_cells(row) for row in self.rows])
        lines += [f"  {note}" for note in self.notes]
        conditions = f"condition of M {self.condition:.1e}"
        if self.condition_of_rows > 1.0:
            conditions += f", of the constraint rows {self.condition_of_rows:.1e}"
        lines.append(f"  {conditions}: differences up to {self.tolerance:.1e} are rounding")
        failed = [row.name for row in self.rows if not row.agrees]
        verdict = f"NO, in {_listed(failed)}" if failed else "yes"
        lines.append(f"Agrees: {verdict}")
        return lines

    def __repr__(self) -> str:
        verdict = "AGREES" if self.agrees else "DISAGREES"
        worst = max(self.rows, key=lambda row: row.difference / row.tolerance, default=None)
        furthest = [] if worst is None else [f"furthest {worst.name}: {worst.difference:.1e}"]
        count = f"{len(self.rows)} quantities to {self.tolerance:.1e}"
        return one_line("Check", verdict, count, *furthest, numbers=self.numbers)

    def __str__(self) -> str:
        return self.report()

    def __bool__(self) -> bool:
        return self.agrees


def _cells(row: CheckRow) -> list[str]:
    entry, ours, reference = "-", "-", "-"
    if row.entries:
        entry = row.entries[row.worst]
        ours, reference = f"{row.ours[row.worst]:.9g}", f"{row.reference[row.worst]:.9g}"
    verdict = "yes" if row.agrees else "NO"
    return [row.name, entry, ours, reference, row.unit, f"{row.difference:.1e}", verdict]


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


_ENERGY_METRIC = "√(2 T), each entry over √M_ll"


def compared(
    impact: Impact,
    reference: ReferenceRobot,
    at: Kinematics,
    truth: KaneImpact,
    carried: KaneImpact,
    demands: Rows,
    conditions: Conditions,
    loads: Sequence[Load],
) -> tuple[CheckRow, ...]:
    """The rows of a check.

    Args:
        at: the reference's kinematics.
        truth: the reference's impact, made with the independent rows.
        carried: the same, by which joints are judged.
        demands: all constraint rows.
        loads: the known impulses on links.
    """
    joints = reference.joints(impact.reactions)
    reactions = {name: _floats(carried.joint_reaction(inner)) for name, inner in joints.items()}
    sizes = sizes_of(truth, at, conditions, impact, loads, reactions)
    make = _Maker(conditions.tolerance)
    rows = _of_speeds(make, impact, reference, truth, conditions, sizes)
    rows += _of_links(make, impact, reference, truth, sizes)
    rows.append(
        make.row(
            "energy",
            "J",
            ("before", "after"),
            [impact.energy.before, impact.energy.after],
            [truth.energy_before, truth.energy_after],
            sizes.energy,
            "the largest kinetic energy",
        )
    )
    rows += _of_joints(make, impact.reactions, reactions, sizes)
    if impact.constraints:
        rows += _of_constraints(make, impact, truth, demands, conditions, sizes)
    return tuple(rows)


class _Maker:
    """Makes rows of one tolerance."""

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance

    def row(
        self,
        name: str,
        unit: str,
        entries: Sequence[str],
        ours: Any,
        reference: Any,
        size: float,
        scale: str,
        weights: np.ndarray | float = 1.0,
    ) -> CheckRow:
        """A row; the difference of an entry is weighed, then taken relative to ``size``."""
        mine, theirs = _floats(ours).ravel(), _floats(reference).ravel()
        gaps = np.abs(mine - theirs) * weights
        difference, worst = 0.0, 0
        if len(gaps):
            worst = int(np.argmax(gaps))  # a NaN counts as the largest
            if gaps[worst] != 0.0:
                difference = float(gaps[worst] / size) if size > 0.0 else float("inf")
        lock(mine, theirs)
        return CheckRow(
            name, unit, tuple(entries), mine, theirs, difference, scale, self._tolerance, worst
        )


def _of_speeds(
    make: _Maker,
    impact: Impact,
    reference: ReferenceRobot,
    truth: KaneImpact,
    conditions: Conditions,
    sizes: Sizes,
) -> list[CheckRow]:
    root = np.sqrt(np.diagonal(conditions.masses))
    names = tuple(name.removeprefix(reference.prefix) for name in truth.tree.speed_names)
    scale = "the largest √M_ll |v_l|, each entry times √M_ll"
    rows = [make.row("Δv", "m/s, rad/s", names, impact.dv, truth.dy, sizes.speed, scale, root)]
    for name, ours, theirs, size in (
        ("I", impact.generalized_impulse, truth.generalized_impulse, sizes.energy_norm),
        ("P before", impact.momentum_before, truth.momentum_before, sizes.energy_norm),
        ("P after", impact.momentum_after, truth.momentum_after, sizes.energy_norm),
    ):
        size = max(size, (2.0 * sizes.energy) ** 0.5)
        rows.append(
            make.row(name, "N s, N m s", names, ours, theirs, size, _ENERGY_METRIC, 1 / root)
        )
    return rows


def _of_links(
    make: _Maker, impact: Impact, reference: ReferenceRobot, truth: KaneImpact, sizes: Sizes
) -> list[CheckRow]:
    bodies = {name: truth.body(reference.own_link(name)) for name in impact.bodies}
    jumps = impact.bodies.values()
    linear = "the fastest mass centre, or rotation times the robot's reach"
    angular = "the fastest mass centre over the robot's reach, or rotation"
    return [
        make.row(
            "mass centres",
            "m/s",
            _with_axes(bodies),
            [jump.dv_com for jump in jumps],
            [_floats(velocity) for velocity, _ in bodies.values()],
            sizes.velocity,
            linear,
        ),
        make.row(
            "rotations",
            "rad/s",
            _with_axes(bodies),
            [jump.domega for jump in jumps],
            [_floats(spin) for _, spin in bodies.values()],
            sizes.velocity / sizes.reach,
            angular,
        ),
    ]


def _of_joints(
    make: _Maker,
    ours: Mapping[str, np.ndarray],
    theirs: Mapping[str, np.ndarray],
    sizes: Sizes,
) -> list[CheckRow]:
    names = _with_axes(theirs)
    scale = "the largest impulse on or between links"
    return [
        make.row(
            "joint impulses",
            "N s",
            names,
            [ours[name][:3] for name in theirs],
            [wrench[:3] for wrench in theirs.values()],
            sizes.impulse,
            scale,
        ),
        make.row(
            "joint couples",
            "N m s",
            names,
            [ours[name][3:] for name in theirs],
            [wrench[3:] for wrench in theirs.values()],
            sizes.impulse * sizes.reach,
            f"{scale}, times the robot's reach",
        ),
    ]


def _of_constraints(
    make: _Maker,
    impact: Impact,
    truth: KaneImpact,
    demands: Rows,
    conditions: Conditions,
    sizes: Sizes,
) -> list[CheckRow]:
    results = impact.constraints
    names = tuple(f"{result.name}.{row}" for result in results for row in result.rows)
    unique = [flag for result in results for flag in result.unique_rows]
    ours = np.concatenate([result.impulse for result in results])
    # What rows left out would carry is not unique anyway.
    theirs = dict(zip(conditions.independent, _floats(truth.row_impulses), strict=True))
    shown = [i for i in range(len(names)) if unique[i] and i in theirs]
    weights = np.sqrt(conditions.mobilities)
    largest = max((weights[i] * abs(theirs[i]) for i in shown), default=0.0)
    # |A_i v| is at most √W_ii √(2 T); a row that moves nothing is judged beside the others.
    lengths = np.where(weights > 0.0, weights, weights.max() or 1.0)
    wanted = _floats(demands.target)
    met = [i for i in range(len(names)) if i not in conditions.faint]
    return [
        make.row(
            "constraint impulses",
            "N s, N m s",
            tuple(names[i] for i in shown),
            ours[shown],
            [theirs[i] for i in shown],
            max(largest, sizes.energy_norm),
            "√(2 T), each entry times √W_ii",
            weights[shown],
        ),
        make.row(
            "constraint velocities",
            "m/s, rad/s",
            tuple(names[i] for i in met),
            (conditions.rows @ impact.v_after)[met],
            wanted[met],
            max(float((np.abs(wanted) / lengths).max()), sizes.energy_norm),
            "√(2 T), each entry over √W_ii",
            1.0 / lengths[met],
        ),
    ]


def _with_axes(names: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(f"{name} {axis}" for name in names for axis in "xyz")


def _floats(values: Any) -> np.ndarray:
    return np.array(values).astype(float)
