"""The store of a study: a folder with ``study.json`` and one file for each chunk of rows.

A chunk is an uncompressed ``.npz``, in which each array has a checksum (CRC-32). It is written
under a temporary name and renamed when all of it is on the disk: it is there as a whole or not at
all. What a killed run did not write is drawn and written by the next one, bit for bit as it would
have been, and so is what was changed on disk, which is an error where it is read. Only one process
writes at a time.
"""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import re
import zipfile
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from ...errors import InputError, MissingExtraError
from ...errors.calls import public
from ...files import (
    as_file_error,
    open_plain_file,
    path_of,
    read_npz,
    reason_of,
    replaced_file,
    write_file,
)
from ...impact.status import Status
from ...motion.record.status import MotionStatus
from ...motion.simulate import chosen_settings
from ..result import shape_of
from .lock import LOCK, OWNER, lock_store, with_full_disk_error
from .study import IMPACTS, Study

RECORD, ROWS = "study.json", "rows"
# What a run that was stopped before it wrote the record may leave behind.
UNFINISHED = re.compile(rf"{re.escape(LOCK)}|{re.escape(OWNER)}|\..*\.partial")
FORMAT = 5
# The status of a row that was never written; no Status, and none of the core's codes.
UNWRITTEN = -128
# Dimensions of a row, and units. Arrays that are not listed count degrees of freedom.
_ARRAYS: dict[str, tuple[tuple[str, ...], str]] = {
    "status": ((), ""),
    "generalized_impulse": (("dof",), "N m s, N s"),
    "energy_change": ((), "J"),
    "contact_impulses": (("contact", "axis"), "N s"),
    "constraint_impulses": (("constraint_row",), "N s, N m s"),
    "normal_components": (("contact", "normal_component"), "m/s, rad/s, N s, N m s"),
    "gaps": (("contact",), "m, rad"),
    "reactions": (("joint", "wrench"), "N s, N m s"),
    "bodies": (("body", "twist"), "m/s, rad/s"),
    "uniqueness": ((), "1"),
    "outcome_bounds": (("bound", "dof"), "rad/s, m/s"),
    "end": ((), "s"),
    "impact_count": ((), "1"),
    "q": (("q_entry",), "rad, m"),
    "q_end": (("q_entry",), "rad, m"),
    "q_samples": (("time", "q_entry"), "rad, m"),
    "v_samples": (("time", "dof"), "rad/s, m/s"),
    "impulses": (("impulse_entry",), "N s, N m s"),
    "masses": (("link",), "1"),
    "restitution": (("contact",), "1"),
    "friction": (("contact",), "1"),
}
_OF_DOF = (("dof",), "rad/s, m/s")
_NOTES = {
    "status": {"meaning": "see the attribute status"},
    "impulses": {"order": "as in the scene, entry after entry"},
    "masses": {"meaning": "factors on mass and inertia of links"},
}


class StudyStore:
    """The folder of a study's rows.

    Attributes:
        path: the folder.
        study: the study it belongs to.
    """

    def __init__(self, path: str | os.PathLike[str], study: Study) -> None:
        self.path, self.study = pathlib.Path(path_of(path, "the store of a study")), study
        self._check: Callable[[], None] | None = None

    @contextlib.contextmanager
    def opened(self) -> Iterator[list[int]]:
        """Make the store, or open one of the same study, as its only writer.

        Yields:
            The chunks that are still to do.

        Raises:
            InputError: the folder holds something else, or the store of another study.
            StoreLockedError: another process writes to the store.
            FileError: the folder cannot be made or written to.
            StoreFullError: no space is left.
            MissingExtraError: xarray or dask is not installed.
        """
        _libraries()
        check_store(self.path)
        rows = self.path / ROWS
        with with_full_disk_error(self.path), as_file_error(self.path, writing=True):
            self.path.mkdir(parents=True, exist_ok=True)
        with lock_store(self.path) as self._check:
            try:
                if (self.path / RECORD).exists():
                    self._check_same()
                else:
                    with with_full_disk_error(self.path):
                        write_file(self.path / RECORD, _record_of(self.study))
                with with_full_disk_error(self.path), as_file_error(rows, writing=True):
                    rows.mkdir(exist_ok=True)
                    for left in self.path.rglob(".*.partial"):
                        left.unlink(missing_ok=True)
                yield [i for i in range(self.study.chunks) if not _is_whole(_file(rows, i))]
            finally:
                self._check = None

    def write(self, index: int, arrays: dict[str, np.ndarray]) -> None:
        """Write a chunk.

        Raises:
            StoreFullError: no space is left; what is written stays.
            StoreLockedError: the store was moved or deleted.
        """
        if self._check is None:
            raise InputError("a store is written to only while it is opened")
        self._check()
        with with_full_disk_error(self.path), replaced_file(_file(self.path / ROWS, index)) as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]
            # Once more: in a folder that took the place of this one there is nothing to rename.
            self._check()

    def _check_same(self) -> None:
        there = _record(self.path)
        if there["fingerprint"] != self.study.fingerprint:
            ours, theirs = self.study.describe(), there.get("study", {})
            changed = [key for key in ours if ours[key] != theirs.get(key)]
            raise InputError(
                f'"{self.path}" is the store of another study: {", ".join(changed)} differ. '
                "Name another folder, or delete this one"
            )


def check_store(path: str | os.PathLike[str]) -> None:
    """Check that a folder holds a study, or nothing of anybody else's.

    Raises:
        InputError: it is no folder, or holds something else.
    """
    folder = pathlib.Path(path)
    if (folder / RECORD).exists():
        return
    try:
        there = {entry.name for entry in os.scandir(folder)}
    except FileNotFoundError:
        return
    except OSError as error:
        reason = "it is no folder" if isinstance(error, NotADirectoryError) else reason_of(error)
        raise InputError(f'"{folder}" cannot hold a study: {reason}') from None
    if there and not (LOCK in there and all(map(UNFINISHED.fullmatch, there))):
        raise InputError(
            f'"{folder}" is a folder that holds something else; name one that is '
            "empty or does not exist"
        )


@public
def open_study(path: str | os.PathLike[str]) -> Any:
    """Open the rows of a study as an ``xarray.Dataset``, loaded when needed.

    Rows that are not written yet have the status ``UNWRITTEN`` (-128), which no solved row
    has, and NaN elsewhere. To load rows that were changed on disk raises an ``InputError``.

    Raises:
        InputError: the folder is not a store of a study.
        MissingExtraError: xarray or dask is not installed.

    Example:
        >>> import dataclasses, tempfile
        >>> from impulsekit.study import load_study, run_study
        >>> study = dataclasses.replace(load_study("examples/landing_study.toml"), samples=100)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     rows = open_study(run_study(study, folder + "/rows").path).load()
        >>> rows["v_after"].shape
        (100, 18)
    """
    xarray, da = _libraries()
    folder = pathlib.Path(path_of(path, "the store of a study"))
    record = _record(folder)
    count, chunk = record["rows"], record["chunk"]
    # Blocks of many small chunks: dask takes its time for each.
    step = chunk * max(1, IMPACTS // chunk)
    sizes = tuple(min(step, count - begin) for begin in range(0, count, step))
    data = {}
    for name, array in record["arrays"].items():
        kind, shape = (np.int8 if name == "status" else float), tuple(array["shape"])
        rows = da.map_blocks(
            partial(_block, folder, name, shape, (count, chunk, step)),
            chunks=(sizes, *((width,) for width in shape)),
            dtype=kind,
            meta=np.empty((0,) * (1 + len(shape)), dtype=kind),
        )
        data[name] = (("row", *array["dims"]), rows, array["attributes"])
    attributes = {"title": record["title"]}
    attributes.update({key: json.dumps(record[key], sort_keys=True) for key in ("study", "status")})
    return xarray.Dataset(data, record["coordinates"], attributes)


def _block(
    folder: pathlib.Path,
    name: str,
    shape: tuple[int, ...],
    sizes: tuple[int, int, int],
    block_id: tuple[int, ...],
) -> np.ndarray:
    """Return an array of some chunks; unwritten rows where there is no file of one.

    Args:
        sizes: rows in all, of a chunk, of a block.

    Raises:
        InputError: a file is not what was written.
    """
    count, chunk, step = sizes
    begin = block_id[0] * step
    fill = np.int8(UNWRITTEN) if name == "status" else np.nan
    found = np.full((min(step, count - begin), *shape), fill)
    for at in range(0, len(found), chunk):
        index = (begin + at) // chunk
        try:
            with open_plain_file(_file(folder / ROWS, index)) as file:
                found[at : at + chunk] = read_npz(file)[name]
        except FileNotFoundError:
            continue
        except _BROKEN as error:
            raise InputError(
                f'"{folder}" is damaged: chunk {index} of its rows is not what was written (its '
                "checksum differs); run the same study again to write it anew"
            ) from error
    return found


# Errors of numpy and zipfile on a file that is not whole.
_BROKEN = (zipfile.BadZipFile, ValueError, LookupError, EOFError, OSError, NotImplementedError)


def _is_whole(file: pathlib.Path) -> bool:
    """Return whether the file of a chunk is there, and all of it is what was written."""
    try:
        with zipfile.ZipFile(file) as arrays:
            return arrays.testzip() is None
    except _BROKEN:
        return False


def _file(rows: pathlib.Path, index: int) -> pathlib.Path:
    return rows / f"{index}.npz"


def _record_of(study: Study) -> str:
    """Return the text of ``study.json``: all that is needed to open the rows."""
    scene = study.scene
    robot = scene.robot
    coordinates = {
        "dof": _dof_names(robot),
        "axis": ["x", "y", "z"],
        "contact": list(scene.entry_names("contacts")),
        "link": list(study.scaled_links),
    }
    times: Any = () if study.motion is None else chosen_settings(study.motion, None, None, {})[1]
    sizes = {
        "q_entry": robot.nq,
        "normal_component": 3,
        "constraint_row": shape_of(scene, "constraint_impulses")[0],
        "joint": robot.model.njoints - 1,
        "wrench": 6,
        "body": len(robot.links),
        "twist": 6,
        "time": len(times),
        "impulse_entry": sum(len(entry.values) for entry in scene.impulses),
        **{name: len(names) for name, names in coordinates.items()},
    }
    arrays = {}
    for name in ("status", *study.names, *study.varied):
        dims, unit = _ARRAYS.get(name, _OF_DOF)
        arrays[name] = {
            "dims": dims,
            "shape": [sizes[dim] for dim in dims],
            "attributes": _NOTES.get(name, {}) | ({"units": unit} if unit else {}),
        }
    used = {dim for array in arrays.values() for dim in array["dims"]}
    statuses = Status if study.motion is None else MotionStatus
    record = {
        "format": FORMAT,
        "fingerprint": study.fingerprint,
        "study": study.describe(),
        "title": f"impulsekit study of {robot.name}",
        "rows": study.samples,
        "chunk": study.rows_of_chunk,
        "arrays": arrays,
        "coordinates": {dim: names for dim, names in coordinates.items() if dim in used},
        "status": {**{code.name: code.code for code in statuses}, "UNWRITTEN": UNWRITTEN},
    }
    return json.dumps(record, indent=1, sort_keys=True)


def _dof_names(robot: Any) -> list[str]:
    names = []
    for name, joint in zip(list(robot.model.names)[1:], list(robot.model.joints)[1:], strict=True):
        names.extend([name] if joint.nv == 1 else [f"{name}[{k}]" for k in range(joint.nv)])
    return names


def _record(folder: pathlib.Path) -> dict[str, Any]:
    """Read the record of a store.

    Raises:
        InputError: the folder is not the store of a study, or of another version; its record is
            damaged.
    """
    mark = folder / RECORD
    if not mark.is_file():
        raise InputError(f'"{folder}" is not the folder of a study')
    there: Any = None
    with as_file_error(mark), contextlib.suppress(ValueError):
        there = json.loads(mark.read_bytes())
    if not isinstance(there, dict) or "fingerprint" not in there:
        raise InputError(f'"{mark}" is damaged: the folder of no study')
    if there.get("format") != FORMAT:
        raise InputError(
            f'"{folder}" is a store that another version of impulsekit has made. Name another '
            "folder, or delete this one"
        )
    return there


def _libraries() -> tuple[Any, Any]:
    """Return xarray, and the arrays of dask."""
    with MissingExtraError.unless("xarray", "study", "the store of a study"):
        import xarray
    with MissingExtraError.unless("dask", "study", "the store of a study"):
        import dask.array
    return xarray, dask.array
