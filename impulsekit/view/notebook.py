"""HTML of results for a notebook: tables of what matters, the replay as it moves."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from ..display.table import Table, table

if TYPE_CHECKING:
    from ..batch.result import ImpactBatch
    from ..checking import Check
    from ..design.fit import Fit
    from ..impact import Impact
    from ..impact.contact_results import ContactResult
    from ..impact.derivatives.result import Derivatives
    from ..impact.energy import Energy
    from ..impact.joint_loads import JointLoad
    from ..measured.comparison import LawComparison
    from ..motion import Trajectory
    from ..robot import Robot
    from ..scene import Scene
    from .replay import Replay

Blocks = Sequence[Sequence[str]]

# A table longer than this pushes what was asked next out of sight.
MOST_ROWS = 20
FRAME_HEIGHT = 480  # px
# Blocks of a report that stand open; the others unfold.
OPEN_BLOCKS = 2


def html_of(thing: Any) -> str:
    """The HTML of a result in a notebook: valid, every name in it escaped.

    Raises:
        KeyError: nothing is known of how to show it.

    Example:
        >>> from impulsekit import Robot
        >>> html_of(Robot.from_example("panda")).startswith("<div")
        True
    """
    return next(SHOWN[c.__name__] for c in type(thing).__mro__ if c.__name__ in SHOWN)(thing)


def as_html(blocks: Blocks) -> str:
    """Sections of lines, the first of each its title, with tables; further ones fold.

    Example:
        >>> as_html([["ball: 1 impulse", "solved: <good>"]])
        '<div class="impulsekit"><p><b>ball: 1 impulse</b><br>solved: &lt;good&gt;</p></div>'
    """
    from .forms import pieces_of

    parts = []
    for number, block in enumerate(blocks):
        title, *rest = pieces_of(list(block))
        inside = "".join(_piece(piece) for piece in rest)
        words = f"<b>{html.escape(str(title))}</b>"
        if number == 0:
            lines = [html.escape(str(p).strip()) for p in rest if not isinstance(p, Table)]
            tables = "".join(_piece(p) for p in rest if isinstance(p, Table))
            parts.append(f"<p>{'<br>'.join([words, *lines])}</p>{tables}")
        elif not rest:
            parts.append(f"<p>{words}</p>")
        else:
            shown = " open" if number < OPEN_BLOCKS else ""
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


def _some(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table, at most so many that it can be looked over."""
    if not rows:
        return []
    lines = table(head, rows[:MOST_ROWS])
    more = len(rows) - MOST_ROWS
    return [*lines, f"and {more} more"] if more > 0 else lines


def _impact(impact: Impact) -> str:
    from .report import report_blocks

    return as_html(report_blocks(impact, rows=MOST_ROWS))


def _trajectory(motion: Trajectory) -> str:
    head = [f"{motion.status.name}: {motion.scene.robot.name}, 0 to {motion.duration:g} s"]
    head += [str(motion.status.value), f"{len(motion.t)} instants, {len(motion.impacts)} impacts"]
    rows = []
    for time, impact in motion.impacts[:MOST_ROWS]:
        struck = [c.name for c in impact.contacts if any(p.impulse.any() for p in c.points)]
        change = f"{impact.energy.change:.4g}"
        rows.append([f"{time:.6g}", impact.status.name, ", ".join(struck) or "-", change])
    left = len(motion.impacts) - MOST_ROWS
    more = [f"and {left} more"] if left > 0 else []
    columns = ["time [s]", "status", "contacts with an impulse", "energy change [J]"]
    impacts = ["Impacts", *table(columns, rows), *more] if rows else []
    return as_html([block for block in (head, impacts) if block])


def _scene(scene: Scene) -> str:
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
    return as_html([[*head, *_some(["entry of", "name", "kind", "what"], rows)]])


def _names(scene: Scene, kind: str) -> Sequence[str]:
    try:
        return scene.entry_names(kind)
    except (KeyError, AttributeError):
        return [f"{kind}[{i}]" for i in range(len(getattr(scene, kind)))]


def _fields(entry: Any) -> str:
    """The fields of an entry as text, without its class and its name."""
    from dataclasses import MISSING, fields, is_dataclass

    if not is_dataclass(entry):
        return str(entry)
    told = []
    for field in fields(entry):
        value = getattr(entry, field.name)
        same = field.default is not MISSING and repr(field.default) == repr(value)
        if field.name != "name" and not same:
            told.append(f"{field.name} {value!r}" if isinstance(value, str) else
                        f"{field.name} {_number_words(value)}")  # fmt: skip
    text = ", ".join(told)
    return text if len(text) <= 160 else text[:157] + "..."


def _number_words(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, tuple) and all(isinstance(x, int | float) for x in value):
        return "(" + ", ".join(f"{x:g}" for x in value) + ")"
    return " ".join(str(value).split())


def _robot(robot: Robot) -> str:
    model = robot.model
    head = [repr(robot), f"{len(robot.links)} links, {robot.mass:.6g} kg"]
    rows = [
        [name, model.joints[i].shortname().removeprefix("JointModel"), str(model.joints[i].nv)]
        for name in robot.joint_names
        for i in (robot.joint_id(name),)
    ]
    return as_html([head, ["Joints", *_some(["joint", "kind", "speeds"], rows)]])


def _fit(fit: Fit) -> str:
    rows = [
        [name, f"{value:.6g}", f"{sigma:.2g}", f"{low:.6g} to {high:.6g}"]
        for name, value, sigma, (low, high) in zip(
            fit.names, fit.values, fit.sigma, fit.intervals(), strict=True
        )
    ]
    head = [repr(fit), fit.message, *fit.notes]
    columns = ["parameter", "value", "standard deviation", "95 % interval"]
    return as_html([[*head, *_some(columns, rows)]])


def _laws(found: LawComparison) -> str:
    head, rows = found.table()
    notes = [*(f"left out: {name}: {why}" for name, why in found.left_out), *found.notes]
    return as_html([[repr(found), *notes, *_some(list(head), rows)]])


def _contact(contact: ContactResult) -> str:
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
    return as_html([[*head, *_some(["of the contact", "value", "unit"], rows)]])


def _energy(energy: Energy) -> str:
    rows = [["before", f"{energy.before:.6g}"]]
    rows += [[f"work of {name}", f"{work:.6g}"] for name, work in energy.work.items()]
    rows.append(["after", f"{energy.after:.6g}"])
    return as_html([[f"energy change {energy.change:.6g} J", *_some(["kinetic", "J"], rows)]])


def _joint_load(load: JointLoad) -> str:
    rows = [["force", _vector(load.force), "N s"], ["moment", _vector(load.moment), "N m s"]]
    if load.axis is not None:
        rows += [
            ["torque about its axis", f"{load.torque:.4g}", "N m s"],
            ["bending across it", f"{load.bending:.4g}", "N m s"],
            ["force along its axis", f"{load.axial:.4g}", "N s"],
            ["shear across it", f"{load.shear:.4g}", "N s"],
        ]
    return as_html(
        [[f"{load.joint}: reaction", *_some(["in its own axes", "value", "unit"], rows)]]
    )


def _derivatives(found: Derivatives) -> str:
    rows = [["q", *_largest(found["v_after", "q"])], ["v", *_largest(found["v_after", "v"])]]
    for kind in ("impulses", "restitution", "friction", "at"):
        own = found["v_after", kind]
        rows += [[f"{kind} of {name}", *_largest(array)] for name, array in own.items()]
    head = [f"derivatives of v⁺: {found.status.name}", str(found.status.value), *found.edges]
    return as_html([[*head, *_some(["by", "shape", "largest entry"], rows)]])


def _largest(array: Any) -> list[str]:
    return [" × ".join(map(str, array.shape)), f"{abs(array).max(initial=0.0):.4g}"]


def _vector(numbers: Any) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in numbers) + ")"


def _check(check: Check) -> str:
    return as_html([[repr(check)], check.lines()])


def _batch(batch: ImpactBatch) -> str:
    rows = []
    if hasattr(batch.status, "tolist"):
        rows = [[status.name, str(n), status.value] for status, n in batch.count().items()]
    outputs = [
        [name, " × ".join(map(str, getattr(array, "shape", ())))]
        for name, array in batch.arrays.items()
    ]
    blocks = [[repr(batch), *_some(["status", "rows", "meaning"], rows)]]
    return as_html([*blocks, ["Outputs", *_some(["output", "shape"], outputs)]])


def _replay(replay: Replay) -> str:
    # A frame of its own keeps the page's style, keys and script apart from the notebook's.
    return (
        f'<iframe title="{html.escape(repr(replay))}" sandbox="allow-scripts allow-downloads" '
        f'width="100%" height="{FRAME_HEIGHT}" style="border:1px solid #ccd4da" '
        f'srcdoc="{html.escape(replay.html)}"></iframe>'
    )


SHOWN: dict[str, Callable[[Any], str]] = {
    "Impact": _impact,
    "Trajectory": _trajectory,
    "Scene": _scene,
    "Robot": _robot,
    "Fit": _fit,
    "LawComparison": _laws,
    "Check": _check,
    "ImpactBatch": _batch,
    "Replay": _replay,
    "ContactResult": _contact,
    "Energy": _energy,
    "JointLoad": _joint_load,
    "Derivatives": _derivatives,
}
