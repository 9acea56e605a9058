"""The forms of a report: plain text, Markdown, JSON, HTML, and what rich prints."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..formatting import Table, TableLine
from ..robot import Robot
from ..robot.placing import Posture

if TYPE_CHECKING:
    from rich.markdown import Markdown

    from ..impact import Impact

# [rad] of a unit of speed: a joint whose axis turns by less slides; axes are unit vectors or zero.
TURNS = 1e-12
# Of a row that shifts, and of one that turns.
IMPULSE_UNITS = ("N s, m/s", "N m s, rad/s")


@dataclass(frozen=True)
class Speed:
    """One entry of v.

    Attributes:
        joint: the joint's name.
        component: "" in a joint with one degree of freedom; else the direction in the
            joint's own axes, such as "vx" or "wz".
        unit: "m/s" or "rad/s".
    """

    joint: str
    component: str
    unit: str

    @property
    def title(self) -> str:
        """Return the joint, with the component where it has several."""
        return f"{self.joint} {self.component}".rstrip()


def speeds_of(robot: Robot, q: np.ndarray) -> tuple[Speed, ...]:
    """Return the generalized speeds of a robot, in the order of v.

    A speed whose column of the motion subspace at ``q`` turns the child is in rad/s, one
    that only shifts it in m/s.
    """
    model = robot.model
    posture = Posture(robot, q)
    speeds: list[Speed] = []
    for joint_id in range(1, model.njoints):
        joint = model.joints[joint_id]
        for column in posture.motion_subspace(joint_id).T:
            turns = np.abs(column[3:]).max() > TURNS
            axis = "xyz"[int(np.argmax(np.abs(column[3:] if turns else column[:3])))]
            component = "" if joint.nv == 1 else ("w" if turns else "v") + axis
            unit = "rad/s" if turns else "m/s"
            speeds.append(Speed(model.names[joint_id], component, unit))
    return tuple(speeds)


def turns_of(impact: Impact) -> dict[str, list[bool]]:
    """Return by joint, for each of its speeds, True for rad/s and False for m/s."""
    found: dict[str, list[bool]] = {}
    for speed in speeds_of(impact.scene.robot, impact.q):
        found.setdefault(speed.joint, []).append(speed.unit == "rad/s")
    return found


Blocks = list[list[str]]


def as_text(blocks: Blocks) -> str:
    """Return plain text, with a blank line between sections.

    Example:
        >>> as_text([["Speeds", "  none"], ["Energy"]])
        'Speeds\\n  none\\n\\nEnergy\\n'
    """
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def as_markdown(blocks: Blocks) -> str:
    """Return Markdown with tables, numbers to the right; names are never read as markup.

    Example:
        >>> print(as_markdown([["ball: 1 impulse", "solved: *good*"]]), end="")
        # ball: 1 impulse
        <BLANKLINE>
        solved: \\*good\\*
    """
    parts = []
    for number, block in enumerate(blocks):
        for i, piece in enumerate(pieces_of(block)):
            if isinstance(piece, Table):
                parts.append(_markdown_table(piece))
            elif i == 0:
                parts.append(f"{'#' if number == 0 else '##'} {_escaped(piece)}")
            else:
                parts.append(_escaped(piece.strip()))
    return "\n\n".join(parts) + "\n"


def as_json(blocks: Blocks) -> str:
    """Return JSON: sections with title, tables and notes; numbers are numbers.

    Example:
        >>> json.loads(as_json([["Energy", "  balanced"]]))["sections"][0]["notes"]
        ['balanced']
    """
    sections: list[dict[str, Any]] = []
    for title, *pieces in (list(pieces_of(block)) for block in blocks):
        tables = [piece for piece in pieces if isinstance(piece, Table)]
        section = {
            "title": title,
            "tables": [{"columns": list(each.head), "rows": _cells(each)} for each in tables],
            "notes": [piece.strip() for piece in pieces if not isinstance(piece, Table)],
        }
        sections.append(section)
    return json.dumps({"sections": sections}, indent=2, ensure_ascii=False) + "\n"


def _cells(table: Table) -> list[list[Any]]:
    """Return the rows of a table, with numbers in the columns that hold them alone."""
    numeric = [table.is_number_column(i) for i in range(len(table.head))]
    return [
        [_number(cell) if one else cell for cell, one in zip(row, numeric, strict=True)]
        for row in table.rows
    ]


def as_rich(blocks: Blocks) -> Markdown:
    """Return the same for a terminal, as something that rich can print."""
    from rich.markdown import Markdown

    return Markdown(as_markdown(blocks))


FORMS: dict[str, Callable[[Blocks], str]] = {
    "text": as_text,
    "markdown": as_markdown,
    "json": as_json,
}


def pieces_of(block: list[str]) -> Iterator[str | Table]:
    """Return the lines of a block, but each table once and whole."""
    last: Table | None = None
    for line in block:
        if not isinstance(line, TableLine):
            last = None
            yield line
        elif line.table is not last:
            last = line.table
            yield last


def _markdown_table(table: Table) -> str:
    rule = ["---:" if table.is_number_column(i) else "---" for i in range(len(table.head))]
    lines = [[_escaped(cell) for cell in table.head], rule]
    lines += [[_escaped(cell) for cell in row] for row in table.rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _escaped(text: str) -> str:
    return re.sub(r"([\\`*_\[\]<>|#~])", r"\\\1", text)


def _number(cell: str) -> float | int | None:
    if not cell:
        return None
    value = float(cell)
    return int(value) if value.is_integer() and "." not in cell and "e" not in cell else value
