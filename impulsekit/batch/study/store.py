"""The store of a study: a Zarr group, written chunk by chunk through xarray.

The store comes into being whole: its arrays are laid out in a folder of another name, which is
renamed, and ``study.json`` is created last, by exclusive creation. Until a row is written its
status is ``UNWRITTEN``, which is no status, and its numbers are NaN. Of each chunk the statuses
are written last, after all else is on the disk: a row that has a status has its numbers too.
Chunks that a killed run has left without statuses are drawn and written again, bit for bit as
they would have been. Each chunk carries a checksum: those that were changed on disk are an error
where they are read, and written again by the next run. Only one process writes at a time.
"""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import re
import shutil
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...errors import InputError, MissingExtraError, shown
from ...files import file_told, flush_to_disk, path_of, reason_of, write_file
from .chunks import changed_files, chunk_name, held_folder, lost_chunks, written_chunks
from .layout import arrays_of, unwritten_rows
from .lock import NAME as LOCK
from .lock import StoreLock, full_disk_told, lock_store
from .study import Study

RECORD, ROWS = "study.json", "rows.zarr"
# What a run that was stopped while it made the store may leave behind.
UNFINISHED = re.compile(rf"{re.escape(LOCK)}|{re.escape(ROWS)}|rows\.partial|\..*\.partial")
FORMAT = 3


class StudyStore:
    """Where a study's rows go.

    Attributes:
        path: the folder.
        study: the study it belongs to.
    """

    def __init__(self, path: str | os.PathLike[str], study: Study) -> None:
        self.path, self.study = pathlib.Path(path_of(path, "the store of a study")), study
        self._lock: StoreLock | None = None
        self._rows = self.path / ROWS

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
            MissingExtraError: xarray or zarr is not installed.
        """
        _xarray()
        check_store(self.path)
        with full_disk_told(self.path), file_told(self.path, writing=True):
            self.path.mkdir(parents=True, exist_ok=True)
        with lock_store(self.path) as self._lock:
            try:
                if (self.path / RECORD).exists():
                    self._check_same()
                else:
                    _check_folder(self.path)
                    with full_disk_told(self.path):
                        self._create()
                with held_folder(self.path / ROWS) as self._rows:
                    self._lock.check()
                    for left in (*self.path.glob(".*.partial"), *self._rows.rglob("*.partial")):
                        left.unlink(missing_ok=True)
                    yield self._unwritten_chunks()
            finally:
                self._lock = None

    def write(self, index: int, arrays: dict[str, np.ndarray]) -> None:
        """Write a chunk, its statuses last.

        Raises:
            StoreFullError: no space is left; what is done stays done.
            StoreLockedError: the store was moved or deleted.
        """
        if self._lock is None:
            raise InputError("a store is written to only while it is opened")
        numbers = {name: array for name, array in arrays.items() if name != "status"}
        with full_disk_told(self.path):
            for part in (numbers, {"status": arrays["status"]}):
                self._lock.check()
                self._write_part(index, part)

    def _write_part(self, index: int, arrays: dict[str, np.ndarray]) -> None:
        """Write some arrays of a chunk, and wait until they are on the disk."""
        import xarray as xr

        layout = arrays_of(self.study)
        data = {name: (layout[name][0], array) for name, array in arrays.items()}
        region = {"row": slice(*self.study.rows(index))}
        # A chunk of nothing but NaN is written too: what is missing is lost.
        xr.Dataset(data).to_zarr(
            self._rows, region=region, consolidated=False, write_empty_chunks=True
        )
        for name, array in arrays.items():
            flush_to_disk(self._rows / name / chunk_name(index, array.ndim))

    def _unwritten_chunks(self) -> list[int]:
        """The chunks without statuses, or whose numbers are lost or not those written."""
        dataset = _dataset(self.path)
        try:
            for file in changed_files(self._rows, dataset):
                file.unlink()
            done = written_chunks(self._rows, dataset) - set(lost_chunks(self._rows, dataset))
        except (OSError, LookupError) as error:
            raise _damaged(self.path, error) from None
        return [i for i in range(self.study.chunks) if i not in done]

    def _check_same(self) -> None:
        mark = self.path / RECORD
        try:
            there = json.loads(mark.read_bytes())
        except ValueError:
            there = None
        if not isinstance(there, dict) or "fingerprint" not in there:
            raise InputError(f'"{mark}" is damaged; it is no store of a study')
        if there.get("format") != FORMAT:
            raise InputError(
                f'"{self.path}" is a store that another version of impulsekit has made. Name '
                "another folder, or delete this one"
            )
        if there["fingerprint"] != self.study.fingerprint:
            ours, theirs = self.study.describe(), there.get("study", {})
            changed = [key for key in ours if ours[key] != theirs.get(key)]
            raise InputError(
                f'"{self.path}" is the store of another study: {", ".join(changed)} differ. '
                "Name another folder, or delete this one"
            )

    def _create(self) -> None:
        """Lay out the arrays, all rows unwritten; the study's record comes last."""
        dataset, encoding = unwritten_rows(self.study)
        partial, rows = self.path / "rows.partial", self.path / ROWS
        for left in (partial, rows):
            # Without its record a store has no row.
            shutil.rmtree(left, ignore_errors=True)
        dataset.to_zarr(
            partial,
            mode="w-",
            compute=False,
            consolidated=False,
            zarr_format=2,
            encoding=encoding,
        )
        partial.rename(rows)
        record = {
            "format": FORMAT,
            "fingerprint": self.study.fingerprint,
            "study": self.study.describe(),
            "arrays": sorted(map(str, dataset.variables)),
        }
        write_file(self.path / RECORD, json.dumps(record, indent=1, sort_keys=True))


def check_store(path: str | os.PathLike[str]) -> None:
    """Prove that a folder can be the store of a study, as far as that is known at once.

    Raises:
        InputError: it is no folder, or holds something else.
        FileError: it cannot be made or written to.
    """
    folder = pathlib.Path(path)
    if folder.is_symlink() and not folder.exists():
        raise InputError(
            f'"{folder}" cannot hold a study: it is a link to "{shown(os.readlink(folder), 200)}", '
            "which does not exist"
        )
    _check_folder(folder)
    with file_told(folder, writing=True):
        there = folder.absolute()
        while not there.exists() and there != there.parent:
            there = there.parent
        if not there.is_dir():
            raise NotADirectoryError
        if not os.access(there, os.W_OK | os.X_OK):
            raise PermissionError


def _check_folder(folder: pathlib.Path) -> None:
    """Prove that a folder without a study in it holds nothing of anybody else's."""
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


def open_study(path: str | os.PathLike[str]) -> Any:
    """Open the rows of a study as an ``xarray.Dataset``, loaded when needed.

    Rows that are not written yet have the status ``UNWRITTEN`` (-128), which no solved row
    has, and NaN elsewhere. To load a chunk that was changed on disk raises zarr's error on its
    checksum.

    Raises:
        InputError: the folder is not a store of a study, or some of its rows are lost.
        MissingExtraError: xarray or zarr is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> from impulsekit.models import pendulum_urdf
        >>> from impulsekit.study import Study, Variation, run_study
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> scene = Scene(rod, [AppliedImpulse("link_1", linear=[1, 0, 0])])
        >>> pushed = Variation("velocity", low=0.0, high=0.1)
        >>> study = Study(scene, [0.0], [0.0], samples=100, vary=[pushed])
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = run_study(study, folder + "/rows")
        ...     rows = open_study(folder + "/rows").load()
        >>> rows["v_after"].shape
        (100, 1)
    """
    folder = pathlib.Path(path_of(path, "the store of a study"))
    dataset = _dataset(folder)
    try:
        lost = lost_chunks(folder / ROWS, dataset)
    except (OSError, LookupError) as error:
        raise _damaged(folder, error) from None
    if lost:
        index, name = min(lost.items())
        raise InputError(
            f'"{folder}" is damaged: {len(lost)} of its chunks of rows are missing or cut off, '
            f"first number {index} of {name}; run the same study again to write them"
        )
    return dataset


def _dataset(folder: pathlib.Path) -> Any:
    """As ``open_study``; rows may be lost.

    Raises:
        InputError: no store, or one that has lost an array with all its rows.
    """
    xarray = _xarray()
    record = folder / RECORD
    if not record.is_file():
        raise InputError(f'"{folder}" is no store of a study')
    try:
        # Masked, statuses would be floats.
        dataset = xarray.open_zarr(folder / ROWS, consolidated=False, mask_and_scale=False)
        wanted = json.loads(record.read_bytes())["arrays"]
    except Exception as error:  # whatever zarr raises on a damaged group
        raise _damaged(folder, error) from None
    lost = sorted(set(wanted) - set(dataset.variables))
    # A coordinate is one chunk.
    lost += [name for name in dataset.coords if not (folder / ROWS / str(name) / "0").is_file()]
    if lost:
        raise InputError(
            f'"{folder}" is damaged: {", ".join(lost)} missing in {ROWS}; copy it whole, or '
            "delete the folder and run the study again"
        )
    return dataset


def _damaged(folder: pathlib.Path, error: Exception) -> InputError:
    return InputError(f'"{folder}" is damaged: {type(error).__name__}: {error}')


def _xarray() -> Any:
    try:
        import dask  # noqa: F401
        import xarray
        import zarr  # noqa: F401
    except ImportError as error:
        package = str(error.name).partition(".")[0]
        raise MissingExtraError.of(package, "study", "the store of a study") from None
    return xarray
