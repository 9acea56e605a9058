"""``Check``: each quantity of an impact beside the reference's, and the verdict."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UnknownNameError
from ..errors.calls import public
from ..formatting import Displayed, one_line
from ..reference import KaneImpact, Load, Rows
from ..reference.kinematics import Kinematics
from ..robot.arrays import lock
from .sizes import Conditions, Sizes, sizes_of
from .system import ReferenceRobot

if TYPE_CHECKING:
    from ..impact import Impact


@public
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


@public
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
        """Return the row of this name.

        Raises:
            UnknownNameError: there is none.
        """
        for row in self.rows:
            if row.name == name:
                return row
        raise UnknownNameError.among("row of a check", name, (row.name for row in self.rows))

    def report(self) -> str:
        """Return the comparison as a table: each quantity at the entry that is furthest apart."""
        return "\n".join(self.lines()) + "\n"

    def lines(self) -> list[str]:
        """Return the lines of the report; those of the table know its cells."""
        from ..formatting import table

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


# Name, unit, entries, ours, the reference's, size, what the size is in words, weights of entries.
_Quantity = tuple[str, str, Sequence[str], Any, Any, float, str, Any]
_SPEEDS = "the largest √M_ll |v_l|, each entry times √M_ll"
_MOMENTA = "√(2 T), each entry over √M_ll"
_CENTRES = "the fastest mass centre, or rotation times the robot's reach"
_TURNS = "the fastest mass centre over the robot's reach, or rotation"
_IMPULSES = "the largest impulse on or between links"
_COUPLES = f"{_IMPULSES}, times the robot's reach"


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
    """Return the rows of a check.

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
    quantities = _of_motion(impact, reference, truth, conditions, sizes)
    names, ours = _with_axes(reactions), [impact.reactions[name] for name in reactions]
    for name, unit, part, size, scale in (
        ("joint impulses", "N s", slice(0, 3), sizes.impulse, _IMPULSES),
        ("joint couples", "N m s", slice(3, 6), sizes.impulse * sizes.reach, _COUPLES),
    ):
        mine, theirs = ([each[part] for each in own] for own in (ours, reactions.values()))
        quantities.append((name, unit, names, mine, theirs, size, scale, 1.0))
    if impact.constraints:
        quantities += _of_constraints(impact, truth, demands, conditions, sizes)
    return tuple(_row(quantity, conditions.tolerance) for quantity in quantities)


def _row(quantity: _Quantity, tolerance: float) -> CheckRow:
    """Return a row; the difference of an entry is weighed, then taken relative to the size."""
    name, unit, entries, ours, reference, size, scale, weights = quantity
    mine, theirs = _floats(ours).ravel(), _floats(reference).ravel()
    gaps = np.abs(mine - theirs) * weights
    difference, worst = 0.0, 0
    if len(gaps):
        worst = int(np.argmax(gaps))  # a NaN counts as the largest
        if gaps[worst] != 0.0:
            difference = float(gaps[worst] / size) if size > 0.0 else float("inf")
    lock(mine, theirs)
    return CheckRow(name, unit, tuple(entries), mine, theirs, difference, scale, tolerance, worst)


def _of_motion(
    impact: Impact,
    reference: ReferenceRobot,
    truth: KaneImpact,
    conditions: Conditions,
    sizes: Sizes,
) -> list[_Quantity]:
    root = np.sqrt(np.diagonal(conditions.masses))
    names = tuple(name.removeprefix(reference.prefix) for name in truth.tree.speed_names)
    found: list[_Quantity] = [
        ("Δv", "m/s, rad/s", names, impact.dv, truth.dy, sizes.speed, _SPEEDS, root)
    ]
    norm = max(sizes.energy_norm, (2.0 * sizes.energy) ** 0.5)
    for name, mine, theirs in (
        ("I", impact.generalized_impulse, truth.generalized_impulse),
        ("P before", impact.momentum_before, truth.momentum_before),
        ("P after", impact.momentum_after, truth.momentum_after),
    ):
        found.append((name, "N s, N m s", names, mine, theirs, norm, _MOMENTA, 1.0 / root))
    bodies = {name: truth.body(reference.own_link(name)) for name in impact.bodies}
    axes, jumps, velocity = _with_axes(bodies), impact.bodies.values(), sizes.velocity
    linear, angular = zip(*bodies.values(), strict=True) if bodies else ((), ())
    ours = [jump.dv_com for jump in jumps], [jump.domega for jump in jumps]
    found.append(("mass centres", "m/s", axes, ours[0], linear, velocity, _CENTRES, 1.0))
    turning = velocity / sizes.reach
    found.append(("rotations", "rad/s", axes, ours[1], angular, turning, _TURNS, 1.0))
    energies = impact.energy.before, impact.energy.after
    reached = truth.energy_before, truth.energy_after
    scale = "the largest kinetic energy"
    found.append(("energy", "J", ("before", "after"), energies, reached, sizes.energy, scale, 1.0))
    return found


def _of_constraints(
    impact: Impact, truth: KaneImpact, demands: Rows, conditions: Conditions, sizes: Sizes
) -> list[_Quantity]:
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
    carried, speeds = tuple(names[i] for i in shown), tuple(names[i] for i in met)
    after = (conditions.rows @ impact.v_after)[met]
    impulse = max(largest, sizes.energy_norm)
    speed = max(float((np.abs(wanted) / lengths).max()), sizes.energy_norm)
    scale = "√(2 T), each entry {} √W_ii".format
    return [
        ("constraint impulses", "N s, N m s", carried, ours[shown], [theirs[i] for i in shown],
         impulse, scale("times"), weights[shown]),
        ("constraint velocities", "m/s, rad/s", speeds, after, wanted[met],
         speed, scale("over"), 1.0 / lengths[met]),
    ]  # fmt: skip


def _with_axes(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"{name} {axis}" for name in names for axis in "xyz")


def _floats(values: Any) -> np.ndarray:
    return np.array(values).astype(float)
