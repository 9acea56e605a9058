"""Measured jumps out of a file: a table (CSV) or a list (JSON), by joint.

A row is one impact. In a table its columns are ``q.JOINT``, ``before.JOINT``,
``after.JOINT`` and ``sigma``, with ``[i]`` behind the joint where it has several numbers;
an empty cell after was not measured. In JSON each impact is
``{"q": {JOINT: …}, "before": {…}, "after": {…}, "sigma": …}``.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..design.parameters import Measurement
from ..errors import InputError, ShapeError, UnknownNameError, quoted, shown
from ..errors.calls import public
from ..files import as_file_error, read_text_file
from ..scene import Scene
from .csv_table import csv_columns

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

PARTS = ("q", "before", "after")
_COLUMN = re.compile(r"(q|before|after)\.(.+?)(?:\[(\d+)\])?$")


@public
def load_measurements(
    path: str | os.PathLike[str], scene: Scene, q: ArrayLike, v: ArrayLike
) -> list[Measurement]:
    """Load measured impacts from a file, CSV or JSON.

    Args:
        path: the file; ``.json`` is read as JSON, all else as CSV.
        scene: the scene of all impacts.
        q, v: (nq,) and (nv,) the state before, for rows without their own.

    Raises:
        FileError: the file cannot be read.
        InputError: the file holds no valid measurements; the error names the place.
        UnknownNameError, ShapeError: a joint is unknown, or has another size.

    Example:
        >>> from impulsekit import load_scene
        >>> file = load_scene("examples/bounced_ball.toml")
        >>> seen = load_measurements("examples/bounced_ball.csv", file.scene, file.q, file.v)
        >>> len(seen), seen[0].v_after.shape
        (12, (6,))
    """
    label = shown(os.fspath(path), 200)
    with as_file_error(path):
        data = read_text_file(path)
    rows = _of_json(data, label) if os.fspath(path).endswith(".json") else _of_table(data, label)
    if not rows:
        raise InputError(f"{label}: there are no measured impacts in it")
    return [_measurement(row, where, scene, q, v) for where, row in rows]


def _of_json(data: bytes, label: str) -> list[tuple[str, Mapping[str, Any]]]:
    try:
        items = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{label}: {error}") from None
    if not isinstance(items, list):
        raise InputError(f"{label} must be a list of impacts")
    rows: list[tuple[str, Mapping[str, Any]]] = []
    for i, item in enumerate(items):
        where = f"{label}: impact {i}"
        if not isinstance(item, dict):
            raise InputError(f"{where} must be a table with q, before and after")
        for key, value in item.items():
            if key not in (*PARTS, "sigma"):
                raise UnknownNameError.among("part", str(key), (*PARTS, "sigma"), where)
            if key in PARTS and not isinstance(value, dict):
                raise InputError(f"{where}: {key} must be values by joint, got {quoted(value)}")
        rows.append((where, item))
    return rows


def _of_table(data: bytes, label: str) -> list[tuple[str, Mapping[str, Any]]]:
    table = csv_columns(data, label)
    columns = [(*_column(name, label), cells) for name, cells in table.items()]
    rows: list[tuple[str, Mapping[str, Any]]] = []
    for k in range(len(columns[0][-1])):
        where, row = f"{label}: row {k + 2}", dict[str, Any]()
        for part, joint, index, cells in columns:
            if part == "sigma":
                row["sigma"] = _number(cells[k], where, "sigma")
            elif cells[k]:
                own = row.setdefault(part, {}).setdefault(joint, {})
                own[index] = _number(cells[k], where, f"{part}.{joint}")
        rows.append((where, row))
    return rows


def _column(name: str, label: str) -> tuple[str, str, int]:
    if name == "sigma":
        return name, "", 0
    found = _COLUMN.match(name)
    if found is None:
        raise InputError(
            f"{label}: column {quoted(name)} is none of q.JOINT, before.JOINT, after.JOINT (with "
            "[i] behind a joint that has several numbers) and sigma"
        )
    part, joint, index = found.groups()
    return part, joint, int(index or 0)


def _number(cell: str, where: str, what: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {what} must be a number, got {quoted(cell)}")
    return value


def _measurement(row: Mapping[str, Any], where: str, scene: Scene, q: Any, v: Any) -> Measurement:
    model = scene.robot.model
    unmeasured = np.full(model.nv, np.nan)
    after = _put(row.get("after", {}), unmeasured, model, "nv", f"{where}: after")
    if np.isnan(after).all():
        raise InputError(f"{where}: no speed after the impact was measured")
    return Measurement(
        scene,
        _put(row.get("q", {}), np.array(q, dtype=float), model, "nq", f"{where}: q"),
        _put(row.get("before", {}), np.array(v, dtype=float), model, "nv", f"{where}: before"),
        after,
        row.get("sigma"),
    )


def _put(
    given: Mapping[str, Any], into: np.ndarray, model: pin.Model, size: str, where: str
) -> np.ndarray:
    """Put values by joint into a vector."""
    names = list(model.names)
    for name, value in given.items():
        if name not in names[1:]:
            raise UnknownNameError.among("joint", name, names[1:], where)
        joint = model.joints[names.index(name)]
        count, start = getattr(joint, size), joint.idx_q if size == "nq" else joint.idx_v
        entries = _entries(value, where, name)
        if size == "nq" and (joint.nq, joint.nv) == (2, 1) and [i for i, _ in entries] == [0]:
            # An angle, where the coordinates are its cosine and sine.
            angle = entries[0][1]
            into[start : start + 2] = math.cos(angle), math.sin(angle)
            continue
        if not isinstance(value, dict) and len(entries) != count:
            raise ShapeError.of(f"{where}: {name}", (count,), (len(entries),))
        for index, number in entries:
            if index >= count:
                raise ShapeError.of(f"{where}: {name}", (count,), (index + 1,))
            into[start + index] = number
    return into


def _entries(value: Any, where: str, name: str) -> list[tuple[int, float]]:
    """Return index and number; None in a list was not measured."""
    if isinstance(value, dict):
        return list(value.items())
    found = []
    for index, number in enumerate(value if isinstance(value, list) else [value]):
        if number is None:
            found.append((index, math.nan))
        elif isinstance(number, bool) or not isinstance(number, int | float):
            raise InputError(f"{where}: {name} must be a number, got {quoted(number)}")
        else:
            found.append((index, float(number)))
    return found
