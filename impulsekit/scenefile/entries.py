"""The entries of a scene file: from tables to frozen dataclasses, held against the robot."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import pydantic

from ..errors import ImpulsekitError, UnknownNameError, quoted
from ..robot import Robot
from ..scene.entry import Entry
from ..scene.materials import Material
from .faults import Faults
from .vocabulary import NESTED, Section, model_of

# Keys that a table cannot have by mistake but for standing below it.
MOVED = ("gravity", "gap_bound", "controlled")


def read_section(section: Section, raw: Any, robot: Robot | None, faults: Faults) -> Any:
    """Return the entries of a section, each checked alone against the robot."""

    def check(entry: Any, place: str) -> None:
        if robot is not None:
            _check_entry(robot, entry, place, faults)

    found = read_entries(section, raw if section.many else (raw,), check, faults)
    return found if section.many else next(iter(found), None)


def read_entries(
    section: Section, raw: Any, check: Callable[[Any, str], None], faults: Faults
) -> tuple[Any, ...]:
    """Return the entries that could be made; ``check`` gets each of them with its place."""
    if not isinstance(raw, tuple):
        faults.add(f"{section.name} must be a list of tables, [[{section.name}]]")
        return ()
    entries = []
    for i, table in enumerate(raw):
        place = f"{section.name}[{i}]" if section.many else section.name
        if not isinstance(table, dict):
            faults.add(f"{place} must be a table, got {quoted(table)}")
            continue
        entry = _read_entry(section, table, place, faults)
        if entry is not None:
            check(entry, place)
            entries.append(entry)
    return tuple(entries)


def _read_entry(section: Section, table: dict[str, Any], place: str, faults: Faults) -> Any:
    kind = _kind(section, table, place, faults)
    if kind is None:
        return None
    cls = section.kinds[kind]
    if len(section.kinds) > 1:
        table = {key: value for key, value in table.items() if key != "kind"}
    model = faults.validated(model_of(cls), table, place, MOVED)
    if model is None:
        return None
    return _made(cls, model, place, faults)


def _made(cls: type, model: pydantic.BaseModel, place: str, faults: Faults) -> Any:
    """The dataclass that a model stands for, or what is left of it without faulty fields."""
    values: dict[str, Any] = {}
    for key in [name for name in type(model).model_fields if name in model.model_fields_set]:
        value = getattr(model, key)
        if isinstance(value, pydantic.BaseModel):
            nested = next(one for one in NESTED if model_of(one) is type(value))
            value = _made(nested, value, f"{place}.{key}", faults)
            if value is None:
                continue
        values[key] = value
    while True:
        try:
            return cls(**values)
        except ImpulsekitError as error:
            field = faults.add_error(place, error)
            if field not in values or model_of(cls).model_fields[field].is_required():
                return None
            del values[field]


def _kind(section: Section, table: dict[str, Any], place: str, faults: Faults) -> str | None:
    kinds = section.kinds
    if len(kinds) == 1:
        return next(iter(kinds))
    if "kind" in table:
        kind = table["kind"]
        if not isinstance(kind, str) or kind not in kinds:
            faults.add(f"{place}.kind: {UnknownNameError.among('kind', str(kind), kinds)}")
            return None
        return kind
    if not section.needs_kind:
        # The kind with most keys of the entry, so that a misspelt key is told as such.
        shared = {
            kind: len(table.keys() & set(model_of(cls).model_fields)) for kind, cls in kinds.items()
        }
        best = [kind for kind, count in shared.items() if count == max(shared.values())]
        if len(best) == 1:
            return best[0]
    names = ", ".join(f'"{kind}"' for kind in kinds)
    faults.add(f"{place}.kind is missing, expected one of {names}")
    return None


def _check_entry(robot: Robot, entry: Any, place: str, faults: Faults) -> None:
    """Hold one entry against the robot.

    An unknown name is put right and the entry tried again, so that the next one shows.
    """
    put_right = False
    for _ in range(16):
        try:
            if isinstance(entry, Entry):
                entry.check_robot(robot, place)
            elif isinstance(entry, Material):
                for link in entry.links:
                    robot.frame_id(link, place)
            return
        except UnknownNameError as error:
            at, better = _with_name_put_right(entry, error)
            faults.add(f"{place}{at}: {str(error).removeprefix(f'{place}: ')}")
            if better is None:
                return
            entry, put_right = better, True
        except ImpulsekitError as error:
            # What follows from the name that was put in is no fault of the file.
            if not put_right:
                faults.add(str(error))
            return


def _with_name_put_right(entry: Any, error: UnknownNameError) -> tuple[str, Any]:
    """The place of an unknown name in an entry, and the entry with a known one instead."""
    right = next(iter((*error.nearest, *error.known)), None)
    for field in dataclasses.fields(entry):
        value = getattr(entry, field.name)
        if isinstance(value, tuple) and error.name in value:
            better: Any = tuple(right if x == error.name else x for x in value)
        elif value == error.name:
            better = right
        else:
            continue
        try:
            return f".{field.name}", dataclasses.replace(entry, **{field.name: better})
        except ImpulsekitError:
            return f".{field.name}", None
    return "", None
