"""HTML of results for a notebook: tables of the main numbers, the replay as it moves."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Sequence
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np

from ..formatting import Table, table
from .forms import pieces_of

Blocks = Sequence[Sequence[str]]

# A longer table pushes the next cell out of sight.
MOST_ROWS = 20
FRAME_HEIGHT = 480  # px
# Blocks of a report that are open; the others unfold.
OPEN_BLOCKS = 2
# Letters of the fields of a scene's entry.
LONGEST_FIELDS = 160


def html_of(thing: Any) -> str:
    """Return the HTML of a result in a notebook: valid, every name in it escaped.

    Raises:
        StopIteration: a class without HTML.

    Example:
        >>> from impulsekit import Robot
        >>> html_of(Robot.from_example("panda")).startswith("<div")
        True
    """
    kind = next(c.__name__ for c in type(thing).__mro__ if c.__name__ in (*SHOWN, "Replay"))
    return _frame(thing) if kind == "Replay" else as_html(SHOWN[kind](thing))


def as_html(blocks: Blocks) -> str:
    """Return sections of lines, the first of each its title, with tables; further ones fold.

    Example:
        >>> as_html([["ball: 1 impulse", "solved: <good>"]])
        '<div class="impulsekit"><p><b>ball: 1 impulse</b><br>solved: &lt;good&gt;</p></div>'
    """
    parts = []
    for number, block in enumerate(blocks):
        title, *rest = pieces_of(list(block))
        words = f"<b>{html.escape(str(title))}</b>"
        if number == 0:
            lines = [html.escape(piece.strip()) for piece in rest if not isinstance(piece, Table)]
            tables = "".join(_piece(piece) for piece in rest if isinstance(piece, Table))
            parts.append(f"<p>{'<br>'.join([words, *lines])}</p>{tables}")
        elif not rest:
            parts.append(f"<p>{words}</p>")
        else:
            shown = " open" if number < OPEN_BLOCKS else ""
            inside = "".join(map(_piece, rest))
            parts.append(f"<details{shown}><summary>{words}</summary>{inside}</details>")
    return f'<div class="impulsekit">{"".join(parts)}</div>'


def _piece(piece: str | Table) -> str:
    if not isinstance(piece, Table):
        return f"<div>{html.escape(piece.strip())}</div>"
    sides = ["right" if piece.is_number_column(i) else "left" for i in range(len(piece.head))]

    def row(cells: Iterable[str], kind: str) -> str:
        inside = "".join(
            f'<{kind} style="text-align:{side}">{html.escape(cell)}</{kind}>'
            for cell, side in zip(cells, sides, strict=True)
        )
        return f"<tr>{inside}</tr>"

    body = "".join(row(cells, "td") for cells in piece.rows)
    return f"<table><thead>{row(piece.head, 'th')}</thead><tbody>{body}</tbody></table>"


def _frame(replay: Any) -> str:
    # A frame of its own keeps the page's style, keys and script apart from the notebook's.
    return (
        f'<iframe title="{html.escape(repr(replay))}" sandbox="allow-scripts allow-downloads" '
        f'width="100%" height="{FRAME_HEIGHT}" style="border:1px solid #ccd4da" '
        f'srcdoc="{html.escape(replay.html)}"></iframe>'
    )


def _some(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table, at most so many that it can be looked over."""
    lines = table(head, rows[:MOST_ROWS]) if rows else []
    more = len(rows) - MOST_ROWS
    return [*lines, f"and {more} more"] if more > 0 else lines


def _impact(impact: Any) -> Blocks:
    from .report import report_blocks

    return report_blocks(impact, rows=MOST_ROWS)


def _trajectory(motion: Any) -> Blocks:
    head = [f"{motion.status.name}: {motion.scene.robot.name}, 0 to {motion.duration:g} s"]
    many = len(motion.impacts)
    head += [
        str(motion.status.value),
        f"{len(motion.t)} instants, {many} impact{'' if many == 1 else 's'}",
    ]
    rows: list[list[str]] = []
    for time, impact in motion.impacts:
        struck = [c.name for c in impact.contacts if any(p.impulse.any() for p in c.points)]
        change = f"{impact.energy.change:.4g}" if len(rows) < MOST_ROWS else ""
        rows.append([f"{time:.6g}", impact.status.name, ", ".join(struck) or "-", change])
    columns = ["time [s]", "status", "contacts with an impulse", "energy change [J]"]
    return [head, ["Impacts", *_some(columns, rows)]] if rows else [head]


def _scene(scene: Any) -> Blocks:
    law = scene.law
    gravity = ", ".join(f"{g:g}" for g in scene.gravity)
    head = [
        repr(scene),
        f"law: {law.restitution}, slip {law.slip}, {law.order}; gravity ({gravity}) m/s²",
    ]
    rows = [
        [kind, name, type(entry).__name__, _fields(entry)]
        for kind in ("impulses", "constraints", "contacts", "forces")
        for name, entry in zip(_names(scene, kind), getattr(scene, kind), strict=True)
    ]
    return [[*head, *_some(["entry of", "name", "kind", "what"], rows)]]


def _names(scene: Any, kind: str) -> Sequence[str]:
    try:
        return scene.entry_names(kind)
    except (KeyError, AttributeError):
        return [f"{kind}[{i}]" for i in range(len(getattr(scene, kind)))]


def _fields(entry: Any) -> str:
    """Return the fields of an entry as text, without its class and its name."""
    if not is_dataclass(entry):
        return str(entry)
    shown = []
    for field in fields(entry):
        value = getattr(entry, field.name)
        same = field.default is not MISSING and repr(field.default) == repr(value)
        if field.name != "name" and not same:
            shown.append(f"{field.name} {_value(value)}")
    text = ", ".join(shown)
    return text if len(text) <= LONGEST_FIELDS else text[: LONGEST_FIELDS - 3] + "..."


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, tuple) and all(isinstance(x, int | float) for x in value):
        return "(" + ", ".join(f"{x:g}" for x in value) + ")"
    return repr(value) if isinstance(value, str) else " ".join(str(value).split())


def _robot(robot: Any) -> Blocks:
    rows = [
        [name, joint.shortname().removeprefix("JointModel"), str(joint.nv)]
        for name in robot.joint_names
        for joint in (robot.model.joints[robot.joint_id(name)],)
    ]
    head = [repr(robot), f"{len(robot.links)} links, {robot.mass:.6g} kg"]
    return [head, ["Joints", *_some(["joint", "kind", "speeds"], rows)]]


def _fit(fit: Any) -> Blocks:
    rows = [
        [name, f"{value:.6g}", f"{sigma:.2g}", f"{low:.6g} to {high:.6g}"]
        for name, value, sigma, (low, high) in zip(
            fit.names, fit.values, fit.sigma, fit.intervals(), strict=True
        )
    ]
    columns = ["parameter", "value", "standard deviation", "95 % interval"]
    return [[repr(fit), fit.message, *fit.notes, *_some(columns, rows)]]


def _laws(found: Any) -> Blocks:
    head, rows = found.table()
    notes = [*(f"left out: {name}: {why}" for name, why in found.left_out), *found.notes]
    return [[repr(found), *notes, *_some(list(head), rows)]]


def _contact(contact: Any) -> Blocks:
    rows = [
        ["impulse", _vector(contact.impulse), "N s"],
        ["velocity before", _vector(contact.velocity_before), "m/s"],
        ["velocity after", _vector(contact.velocity_after), "m/s"],
        ["gap", f"{contact.gap:.4g}", "m"],
        ["work", f"{contact.work:.4g}", "J"],
    ]
    head = [f"{contact.name}: {contact.mode}", f"{len(contact.points)} touching points"]
    if not contact.unique:
        head.append("only the resultant over its redundant points counts")
    return [[*head, *_some(["of the contact", "value", "unit"], rows)]]


def _energy(energy: Any) -> Blocks:
    works = [[f"work of {name}", f"{work:.6g}"] for name, work in energy.work.items()]
    rows = [["before", f"{energy.before:.6g}"], *works, ["after", f"{energy.after:.6g}"]]
    return [[f"energy change {energy.change:.6g} J", *_some(["kinetic", "J"], rows)]]


def _joint_load(load: Any) -> Blocks:
    rows = [["force", _vector(load.force), "N s"], ["moment", _vector(load.moment), "N m s"]]
    if load.axis is not None:
        rows += [
            ["torque about its axis", f"{load.torque:.4g}", "N m s"],
            ["bending across it", f"{load.bending:.4g}", "N m s"],
            ["force along its axis", f"{load.axial:.4g}", "N s"],
            ["shear across it", f"{load.shear:.4g}", "N s"],
        ]
    return [[f"{load.joint}: reaction", *_some(["in its own axes", "value", "unit"], rows)]]


def _transient(hit: Any) -> Blocks:
    verdict = "within the limits" if hit.within_limits else "over the limits"
    rows = [
        ["force", f"{hit.force:.4g}", f"{hit.force_limit:.4g}", "N"],
        ["speed", f"{hit.speed:.4g}", f"{hit.permitted_speed:.4g}", "m/s"],
    ]
    if hit.pressure is not None:
        rows.append(["pressure", f"{hit.pressure:.4g}", f"{hit.pressure_limit:.4g}", "Pa"])
    head = [f"{hit.frame} on {hit.region.name}: {verdict}", f"{hit.energy:.4g} J transferred"]
    return [[*head, *_some(["of the contact", "value", "limit", "unit"], rows)]]


def _force_history(history: Any) -> Blocks:
    rows = [
        ["peak force", f"{history.peak_force:.4g}", "N"],
        ["duration", f"{1e3 * history.duration:.4g}", "ms"],
        ["impulse", f"{history.impulse:.4g}", "N s"],
        ["indentation", f"{1e3 * history.indentation:.4g}", "mm"],
    ]
    return [[f"{history.contact}: force over time", *_some(["", "value", "unit"], rows)]]


def _uniqueness(found: Any) -> Blocks:
    lines = [f"uniqueness of v⁺: {found.verdict}", found.reason]
    if found.rule:
        lines.append(f"load split: {found.rule}")
    if found.others:
        lines.append(f"{len(found.others)} more v⁺ in others")
    return [lines]


def _touching(found: Any) -> Blocks:
    count = sum(item.touching for item in found.contacts)
    return [[f"{count} of {len(found.contacts)} contacts touch", *found.lines()]]


def _simulation(sim: Any) -> Blocks:
    rows = [[name, _vector(force), "N"] for name, force in sim.forces.items()]
    return [[repr(sim), *_some(["at rest", "force", "unit"], rows)]]


def _plain(thing: Any) -> Blocks:
    """Return the fields of a small dataclass."""
    names = thing.answer or [item.name for item in fields(thing)]
    rows = [[name, _value(getattr(thing, name))] for name in names]
    return [[type(thing).__name__, *_some(["", "value"], rows)]]


def _derivatives(found: Any) -> Blocks:
    arrays = [("q", found["v_after", "q"]), ("v", found["v_after", "v"])]
    for kind in ("impulses", "restitution", "friction", "at"):
        arrays += [(f"{kind} of {name}", each) for name, each in found["v_after", kind].items()]
    rows = [
        [name, " × ".join(map(str, each.shape)), f"{np.abs(each).max(initial=0.0):.4g}"]
        for name, each in arrays
    ]
    head = [f"derivatives of v⁺: {found.status.name}", str(found.status.value), *found.edges]
    return [[*head, *_some(["by", "shape", "largest entry"], rows)]]


def _vector(numbers: Any) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in numbers) + ")"


def _check(check: Any) -> Blocks:
    return [[repr(check)], check.lines()]


def _batch(batch: Any) -> Blocks:
    rows = []
    if hasattr(batch.status, "tolist"):
        rows = [[status.name, str(n), status.value] for status, n in batch.count().items()]
    outputs = [
        [name, " × ".join(map(str, getattr(array, "shape", ())))]
        for name, array in batch.arrays.items()
    ]
    head = [repr(batch), *_some(["status", "rows", "meaning"], rows)]
    return [head, ["Outputs", *_some(["output", "shape"], outputs)]]


SHOWN: dict[str, Callable[[Any], Blocks]] = {
    "Impact": _impact,
    "Trajectory": _trajectory,
    "Scene": _scene,
    "Robot": _robot,
    "Fit": _fit,
    "LawComparison": _laws,
    "Check": _check,
    "ImpactBatch": _batch,
    "ContactResult": _contact,
    "Energy": _energy,
    "JointLoad": _joint_load,
    "Derivatives": _derivatives,
    "TransientContact": _transient,
    "ForceHistory": _force_history,
    "GearPeak": _plain,
    "Uniqueness": _uniqueness,
    "Residuals": _plain,
    "Touching": _touching,
    "Simulation": _simulation,
    "Entry": _plain,
}
