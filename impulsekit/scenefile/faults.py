"""Faults of a file, collected: each with its place, and the nearest name."""

from __future__ import annotations

import typing
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

import pydantic

from ..errors import (
    ImpulsekitError,
    SceneFileError,
    UnknownNameError,
    nearest_names,
    quoted,
    shown,
)

Model = TypeVar("Model", bound=pydantic.BaseModel)

# What pydantic calls a fault, in words that follow "must be".
_WANTED = {
    "bool_type": "true or false",
    "dict_type": "a table",
    "finite_number": "a finite number",
    "float_type": "a number",
    "int_type": "a whole number",
    "model_type": "a table",
    "string_type": "text",
    "tuple_type": "a list",
}


def tuples_of(value: Any) -> Any:
    """Return TOML data with tuples for lists, as the frozen dataclasses have them."""
    if isinstance(value, dict):
        return {key: tuples_of(entry) for key, entry in value.items()}
    return tuple(map(tuples_of, value)) if isinstance(value, list) else value


class Faults(list[str]):
    """The faults found so far, one sentence each, in the order they were found."""

    def add(self, sentence: str) -> None:
        """Note a fault, once."""
        if sentence not in self:
            self.append(sentence)

    def error(self, path: str) -> SceneFileError:
        """Return all of them as the error of a file."""
        if len(self) == 1:
            message = f"{path}: {self[0]}"
        else:
            message = f"{path}: {len(self)} errors:" + "".join(f"\n  {fault}" for fault in self)
        return SceneFileError(message, path=path, faults=tuple(self))

    def add_error(self, place: str, error: ImpulsekitError) -> str | None:
        """Note an error of the library at a place of the file; gives the field at fault.

        Errors of the vocabulary say ``what`` is wrong as 'Class on "name": field'; of
        this only the field matters, for the place says the rest.
        """
        message, what = str(error).removeprefix(f"{place}: "), error.__dict__.get("what", "")
        if isinstance(what, str) and ": " in what and str(error).startswith(what):
            field = what.rsplit(": ", 1)[1]
            self.add(f"{place}.{field}{str(error)[len(what) :]}")
            return field.split("[")[0]
        self.add(f"{place}: {message}")
        return None

    def validated(
        self, model: type[Model], raw: Any, place: str, moved: Iterable[str] = ()
    ) -> Model | None:
        """Return ``raw`` as a ``model``, with every fault noted.

        Where a key is at fault the rest is returned if it can stand alone, so that
        faults further on are found in the same pass.

        Args:
            moved: keys that belong to the top of the file; a hint says so.
        """
        try:
            return model.model_validate(raw)
        except pydantic.ValidationError as error:
            self._add_validation(error, model, place, moved)
            bad = {part["loc"][0] for part in error.errors() if part["loc"]}
        if not isinstance(raw, dict) or not bad:
            return None
        try:
            return model.model_validate({k: v for k, v in raw.items() if k not in bad})
        except pydantic.ValidationError:
            return None

    def _add_validation(
        self,
        error: pydantic.ValidationError,
        model: type[pydantic.BaseModel],
        place: str,
        moved: Iterable[str],
    ) -> None:
        parts = error.errors()
        for part in parts:
            # The tag of a union's option is no key of the file.
            part["loc"] = tuple(k for k in part["loc"] if not str(k).startswith("<"))
        strangers = [p["loc"] for p in parts if p["type"] == "extra_forbidden"]
        # A key that is misspelt is not missing as well.
        meant = {
            (*loc[:-1], near)
            for loc in strangers
            for near in nearest_names(str(loc[-1]), _fields_at(model, loc[:-1]))
        }
        for part in parts:
            loc, kind = part["loc"], part["type"]
            where = _joined(place, loc)
            if kind == "extra_forbidden":
                known = _fields_at(model, loc[:-1])
                self.add(no_such_key(where, str(loc[-1]), known, moved))
            elif kind == "missing" and isinstance(loc[-1], int):
                siblings = [p["loc"][-1] for p in parts if p["loc"][:-1] == loc[:-1]]
                wanted = 1 + max(i for i in siblings if isinstance(i, int))
                self.add(_wrong_length(_joined(place, loc[:-1]), part["input"], wanted))
            elif kind == "too_long":
                self.add(_wrong_length(where, part["input"], part["ctx"]["max_length"]))
            elif kind == "missing":
                if loc not in meant:
                    self.add(f"{where} is missing")
            elif kind == "literal_error":
                choice = UnknownNameError.among(str(loc[-1]), str(part["input"]), _choices(part))
                self.add(f"{where}: {choice}")
            else:
                wanted_words = _WANTED.get(kind, part["msg"])
                self.add(f"{where} must be {wanted_words}, got {_shown(part['input'])}")


def no_such_key(where: str, key: str, known: Iterable[str], moved: Iterable[str] = ()) -> str:
    """Return the sentence for a key that does not exist."""
    if key in moved:
        return f"{where}: no such key here; it belongs to the file, above the first [table]"
    names = tuple(known)
    nearest = nearest_names(key, names)
    if nearest:
        return f"{where}: no such key; did you mean " + " or ".join(f'"{n}"' for n in nearest) + "?"
    return f"{where}: no such key; choose from {', '.join(names)}"


def _joined(place: str, loc: Sequence[Any]) -> str:
    for key in loc:
        place += f"[{key}]" if isinstance(key, int) else f".{key}" if place else str(key)
    return place


def _fields_at(model: Any, loc: Sequence[Any]) -> tuple[str, ...]:
    """The keys that a model has at a place within it."""
    found = [model]
    for key in loc:
        annotations = [m.model_fields[key].annotation for m in found if key in m.model_fields]
        options = [o for a in annotations for o in (a, *typing.get_args(a))]
        options += [o for a in options for o in typing.get_args(a)]
        found = [o for o in options if hasattr(o, "model_fields")] or found
    return tuple(dict.fromkeys(name for m in found for name in m.model_fields))


def _choices(part: Any) -> tuple[str, ...]:
    words = part["ctx"]["expected"].replace(" or ", ", ").split(", ")
    return tuple(word.strip("'") for word in words)


def _wrong_length(where: str, value: Any, wanted: int) -> str:
    return f"{where} must have {wanted} entries, got {len(value)}"


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, tuple):
        if any(isinstance(entry, dict) for entry in value):
            return "a list of tables"
        return shown("[" + ", ".join(map(_shown, value)) + "]")
    return str(value).lower() if isinstance(value, bool) else quoted(value)
