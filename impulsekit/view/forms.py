"""The forms of a report: plain text, Markdown, JSON, and tables drawn by rich."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..display.table import Table, TableLine
from ..robot import Robot
from ..robot.placing import Posture

if TYPE_CHECKING:
    from rich.console import Group

# [rad] of a unit of speed: a joint whose axis turns by less slides; axes are unit vectors or zero.
TURNS = 1e-12


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
        """The joint, with the component where it has several."""
        return f"{self.joint} {self.component}".rstrip()


def speeds_of(robot: Robot, q: np.ndarray) -> tuple[Speed, ...]:
    """The generalized speeds of a robot, in the order of v.

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


Blocks = list[list[str]]


def as_text(blocks: Blocks) -> str:
    """Plain text, a blank line between sections.

    Example:
        >>> as_text([["Speeds", "  none"], ["Energy"]])
        'Speeds\\n  none\\n\\nEnergy\\n'
    """
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def as_markdown(blocks: Blocks) -> str:
    """Markdown with tables, numbers to the right; names are never read as markup.

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
    """JSON: sections with their title, tables and notes; numbers are numbers.

    Example:
        >>> json.loads(as_json([["Energy", "  balanced"]]))["sections"][0]["notes"]
        ['balanced']
    """
    sections: list[dict[str, Any]] = []
    for block in blocks:
        pieces = list(pieces_of(block))
        section: dict[str, Any] = {"title": pieces[0], "tables": [], "notes": []}
        for piece in pieces[1:]:
            if isinstance(piece, Table):
                section["tables"].append(
                    {
                        "columns": list(piece.head),
                        "rows": [
                            [
                                _number(cell) if piece.is_number_column(i) else cell
                                for i, cell in enumerate(row)
                            ]
                            for row in piece.rows
                        ],
                    }
                )
            else:
                section["notes"].append(piece.strip())
        sections.append(section)
    return json.dumps({"sections": sections}, indent=2, ensure_ascii=False) + "\n"


def as_rich(blocks: Blocks) -> Group:
    """The same for a terminal, as something that rich can print."""
    from rich import box
    from rich.console import Group
    from rich.table import Table as RichTable
    from rich.text import Text

    parts: list[Any] = []
    for number, block in enumerate(blocks):
        if number > 0:
            parts.append(Text())
        for i, piece in enumerate(pieces_of(block)):
            if isinstance(piece, Table):
                drawn = RichTable(box=box.SIMPLE_HEAD, pad_edge=False, header_style="dim")
                for column, title in enumerate(piece.head):
                    numeric = piece.is_number_column(column)
                    drawn.add_column(Text(title), justify="right" if numeric else "left")
                for row in piece.rows:
                    # Text objects: a name such as "[red]" stays what it is.
                    drawn.add_row(*(Text(cell) for cell in row))
                parts.append(drawn)
            else:
                parts.append(Text(piece, style="bold" if i == 0 else ""))
    return Group(*parts)


FORMS: dict[str, Callable[[Blocks], str]] = {
    "text": as_text,
    "markdown": as_markdown,
    "json": as_json,
}


def pieces_of(block: list[str]) -> Iterator[str | Table]:
    """The lines of a block, but each table once and whole."""
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
