"""Recordings out of files: npz, CSV, Parquet and ROS 2 bags."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError, InputError, MissingExtraError, ShapeError, quoted, shown
from ..errors.calls import public
from ..files import as_file_error, open_plain_file, path_of, read_npz
from ..robot import Robot
from .columns import RecordingFormat
from .csv_table import csv_columns, is_number, without_unit
from .recording import Recording

# A column of several numbers: position[0], or position.x.
_INDEXED = re.compile(r"(.+?)(?:\[(\d+)\]|\.([xyzw]))$")
_LETTERS = {"x": 0, "y": 1, "z": 2, "w": 3}
# Larger files are no tables of a motion [bytes].
LARGEST = 2_000_000_000
# Columns that distinguish the recordings of one file.
LABELS = ("recording", "toss_id", "toss", "trial")
# Arrays of an npz file that are about all samples.
_SCALARS = ("rate_hz", "length_scale")


@public
def load_recordings(
    path: str | os.PathLike[str],
    robot: Robot,
    format: RecordingFormat | None = None,
    *,
    repair: str | Sequence[str] = (),
) -> list[Recording]:
    """Load the recordings in a file.

    Columns, in a table with ``[i]`` or ``.x`` behind the name where there are several numbers:
    ``t``; ``q`` and ``v`` as Pinocchio orders them; or ``position`` and ``quaternion_xyzw`` or
    ``quaternion_wxyz`` of the free root (with ``.JOINT`` behind the name if there are several),
    ``velocity`` (world axes), ``omega_body`` or ``omega_world``; ``q.JOINT`` and ``v.JOINT`` of
    other joints. A column ``recording`` (or ``toss_id``) distinguishes several recordings. In npz
    the arrays have these names; ``offset`` (K + 1,) holds where each of K recordings begins, and
    ``rate_hz`` may stand for ``t``.

    Args:
        path: ``.npz``, ``.csv``, ``.tsv``, ``.txt``, ``.parquet``, or the folder of a ROS 2 bag.
        robot: the robot.
        format: units and orders that the names do not say.
        repair: which repairs may be made; each one made is noted in ``notes``: "gaps" leaves
            out samples that hold a NaN, "time" sorts samples by time, "norm" scales quaternions.

    Raises:
        FileError: the file cannot be read.
        MissingExtraError: pandas (Parquet) or rosbags (ROS 2) is not installed.
        InputError, ShapeError, NotFiniteError, RangeError, StateError, UnknownNameError: what
            is wrong in it, and which repair there is.

    Example:
        >>> cube = Robot.from_urdf("examples/tossed_cube.urdf", root="freeflyer")
        >>> tosses = load_recordings("examples/cube_tosses.npz", cube)
        >>> len(tosses), tosses[0].name
        (12, 'toss 3')
    """
    path = path_of(path, "a recording")
    label = shown(Path(path).name, 80)
    format = format or RecordingFormat()
    ending = Path(path).suffix.lower()
    with as_file_error(path):
        if os.path.isdir(path) or ending in (".db3", ".mcap", ".bag"):
            from .rosbag import columns_of_bag

            columns, notes = columns_of_bag(path, format, robot)
            found = Recording.from_columns(robot, columns, format, repair=repair, name=label)
            return [replace(found, notes=(*notes, *found.notes))]
        with open_plain_file(path) as file:
            if os.fstat(file.fileno()).st_size > LARGEST:
                raise InputError(f"{label}: the file is too large for a recording")
            if ending == ".npz":
                pieces = _of_npz(file, label)
            elif ending in (".parquet", ".pq"):
                pieces = _of_table(_parquet(path, label), label, format)
            elif ending in (".csv", ".txt", ".tsv"):
                pieces = _of_table(csv_columns(file.read(), label), label, format)
            else:
                raise InputError(
                    f"{label}: unknown ending {quoted(ending)}; choose .npz, .csv, .tsv, .parquet "
                    "or the folder of a ROS 2 bag"
                )
    several = []
    for name, columns, rate, note in pieces:
        own = replace(format, rate=rate) if rate is not None and format.rate is None else format
        recording = Recording.from_columns(robot, columns, own, repair=repair, name=name)
        several.append(replace(recording, notes=(*note, *recording.notes)) if note else recording)
    return several


def _of_npz(file: Any, label: str) -> list[tuple[str, dict[str, Any], float | None, list[str]]]:
    try:
        arrays = read_npz(file)
    except ValueError as error:
        raise FileError(f"{label}: no npz file of plain arrays ({error})", path=label) from None
    note = []
    scalars = {}
    for name in _SCALARS:
        if name in arrays:
            scalars[name] = _scalar(arrays.pop(name), f"{label}: {name}")
    if "length_scale" in scalars:
        note.append(
            f"length_scale = {scalars['length_scale']:g} stands in the file and was not applied; "
            "calibrate finds it from gravity"
        )
    offset = arrays.pop("offset", None)
    ids = next((arrays.pop(name) for name in LABELS if name in arrays), None)
    if offset is None:
        return [(label, arrays, scalars.get("rate_hz"), note)]
    offset = np.asarray(offset)
    count = {len(array) for array in arrays.values() if array.ndim}
    rises = offset.ndim == 1 and offset.size > 1 and (np.diff(offset) > 0).all()
    if offset.dtype.kind not in "iu" or not rises or offset[0] != 0 or {int(offset[-1])} != count:
        raise InputError(
            f"{label}: offset must rise from 0 to the number of samples {sorted(count)}, in whole "
            "numbers"
        )
    names = [f"toss {k}" for k in range(len(offset) - 1)]
    if ids is not None:
        if np.shape(ids) != (len(offset) - 1,):
            raise ShapeError.of(f"{label}: toss_id", (len(offset) - 1,), np.shape(ids))
        names = [f"toss {each}" for each in ids]
    return [
        (name, {key: array[start:end] for key, array in arrays.items()},
         scalars.get("rate_hz"), note)
        for name, start, end in zip(names, offset[:-1], offset[1:], strict=True)
    ]  # fmt: skip


def _scalar(value: np.ndarray, what: str) -> float:
    if value.shape not in ((), (1,)) or value.dtype.kind not in "iuf":
        raise ShapeError.of(what, (), value.shape, "one number")
    return float(value.reshape(-1)[0])


def _parquet(path: Any, label: str) -> dict[str, Any]:
    with MissingExtraError.unless("pandas with pyarrow", "record", "reading Parquet"):
        import pandas
    try:
        table = pandas.read_parquet(path)
    except ImportError:
        raise MissingExtraError.of("pyarrow", "record", "reading Parquet") from None
    except Exception as error:
        raise FileError(f"{label}: no Parquet table ({error})", path=str(path)) from None
    return {str(name): table[name].to_numpy() for name in table.columns}


def _of_table(
    table: Mapping[str, Any], label: str, format: RecordingFormat
) -> list[tuple[str, dict[str, Any], float | None, list[str]]]:
    """Put the columns of a table together, and cut them where its labels change."""
    stated = format.time, format.length, format.angle
    plain = [without_unit(name, stated, label) for name in table]
    twice = next((name for name in plain if plain.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{label}: two columns are called {quoted(twice)}; keep one")
    table = dict(zip(plain, table.values(), strict=True))
    if format.time != "s" and _are_dates(table.get("t")):
        raise InputError(f"{label}: t holds dates, which need no unit; leave time out")
    ids = next((list(table[name]) for name in LABELS if name in table), None)
    columns = _joined({k: v for k, v in table.items() if k not in LABELS}, label)
    if ids is None:
        return [(label, columns, None, [])]
    starts = [k for k in range(len(ids)) if k == 0 or ids[k] != ids[k - 1]]
    names = [str(ids[k]) for k in starts]
    if len(set(names)) != len(names):
        raise InputError(f"{label}: the rows of recording {quoted(names[0])} do not stand together")
    ends = [*starts[1:], len(ids)]
    return [
        (name, {k: v[start:end] for k, v in columns.items()}, None, [])
        for name, start, end in zip(names, starts, ends, strict=True)
    ]


def _joined(table: Mapping[str, Any], label: str) -> dict[str, np.ndarray]:
    """Return arrays (T,) or (T, k) of columns that may be called name[i]."""
    parts: dict[str, dict[int, np.ndarray]] = {}
    for name, values in table.items():
        numbers = _numbers(values, f'{label}: column "{shown(name)}"')
        found = _INDEXED.match(name)
        if found is None:
            parts.setdefault(name, {})[-1] = numbers
        else:
            index = int(found.group(2)) if found.group(2) else _LETTERS[found.group(3)]
            if found.group(3) and found.group(1).endswith("wxyz"):
                index = (index + 1) % 4
            parts.setdefault(found.group(1), {})[index] = numbers
    joined = {}
    for name, own in parts.items():
        if set(own) == {-1}:
            joined[name] = own[-1]
        elif set(own) == set(range(len(own))):
            joined[name] = np.stack([own[k] for k in range(len(own))], axis=1)
        else:
            raise InputError(f'{label}: columns of "{shown(name)}" are missing, got {sorted(own)}')
    return joined


def _numbers(values: Any, what: str) -> np.ndarray:
    """Return floats; an empty cell is a gap, dates are seconds after the first."""
    if _are_dates(values):
        since = values - values[:1] if values.dtype.kind == "M" else values
        return np.asarray(since / np.timedelta64(1, "s"), dtype=float)
    try:
        return np.array([np.nan if v in ("", None) else float(v) for v in values])
    except (TypeError, ValueError):
        bad = next(v for v in values if v not in ("", None) and not is_number(v))
        raise InputError(f"{what} must hold numbers, got {quoted(bad)}") from None


def _are_dates(values: Any) -> bool:
    """Return dates and spans of time, as tables have them."""
    return isinstance(values, np.ndarray) and values.dtype.kind in ("M", "m")
