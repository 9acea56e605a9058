"""All faults, committed, as a table in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from . import calls, commands, files, robots, scenes, solving, urdfs
from .fault import Fault, Told, commit, workshop

_HEAD = """# What users get wrong, and the words they get

{count} faults, each committed and its error written down by `python -m tests.faults`.
A line break in an error is shown as ` / `.
"""


def faults_by_room() -> dict[str, Sequence[Fault]]:
    """The faults, in the order of the design."""
    return {
        "URDF files": urdfs.FAULTS,
        "Robots and states": robots.FAULTS,
        "Scenes": scenes.FAULTS,
        "Solving, following, batches, checks, pictures, design": solving.FAULTS,
        "Scene files and studies": files.FAULTS,
        "Calls": calls.FAULTS,
        "The command line": commands.FAULTS,
    }


def told_by_room() -> dict[str, list[Told]]:
    """What each fault brings, room by room."""
    found = {}
    for room, faults in faults_by_room().items():
        with workshop():
            found[room] = commit(faults)
    return found


def written(told: Mapping[str, Sequence[Told]]) -> str:
    """The table."""
    count = sum(map(len, told.values()))
    parts = [_HEAD.format(count=count)]
    for room, rows in told.items():
        parts.append(f"\n## {room}\n\n| the user | gets | in these words |\n|---|---|---|\n")
        parts += [f"| {_cell(one.what)} | {one.kind} | {_cell(one.words)} |\n" for one in rows]
    return "".join(parts)


def _cell(text: str) -> str:
    escaped = "".join(f"\\{c}" if c in "|<>*_[]\\" else c for c in text.replace("&", "&amp;"))
    return escaped.replace("\n", " / ")
