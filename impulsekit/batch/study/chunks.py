"""The files of a store: which chunks are whole, each as long as what it holds and its checksum."""

from __future__ import annotations

import contextlib
import math
import os
import pathlib
import zlib
from collections.abc import Iterator
from typing import Any

from ...errors import InputError
from ...files import file_told

# [bytes] of numcodecs' CRC32, little-endian, before what a chunk holds.
CHECKSUM = 4


def chunk_name(index: int, dimensions: int) -> str:
    """The name of the file of a chunk of rows, in the folder of its array."""
    return ".".join(map(str, (index, *[0] * (dimensions - 1))))


def written_chunks(rows: pathlib.Path, dataset: Any) -> set[int]:
    """The chunks that have statuses, which are written after all else."""
    return _whole(rows, "status", dataset["status"])


def lost_chunks(rows: pathlib.Path, dataset: Any) -> dict[int, str]:
    """By chunk with statuses, an array whose part of it is missing or cut off.

    A file that was deleted, or not copied, reads as NaN, beside a status that says solved.
    """
    written, lost = written_chunks(rows, dataset), dict[int, str]()
    for name, array in dataset.data_vars.items():
        for index in written - _whole(rows, name, array):
            lost.setdefault(index, name)
    return lost


def changed_files(rows: pathlib.Path, dataset: Any) -> list[pathlib.Path]:
    """The files of whole chunks whose content is not the one that was written: all are read."""
    changed = []
    for name, array in dataset.data_vars.items():
        for index in sorted(_whole(rows, name, array)):
            file = rows / name / chunk_name(index, array.ndim)
            content = memoryview(file.read_bytes())
            if int.from_bytes(content[:CHECKSUM], "little") != zlib.crc32(content[CHECKSUM:]):
                changed.append(file)
    return changed


@contextlib.contextmanager
def checksums_told() -> Iterator[None]:
    """Turn numcodecs' error on a chunk that was changed on disk into an ``InputError``."""
    try:
        yield
    except RuntimeError as error:
        if "checksum" not in str(error):
            raise
        raise InputError(
            "the store is damaged: a chunk of its rows is not what was written (its checksum "
            "differs); run the same study again to write it anew"
        ) from error


def _whole(rows: pathlib.Path, name: str, array: Any) -> set[int]:
    """The chunks of an array with a file of the right length: they are not compressed."""
    width = math.prod(array.encoding["chunks"]) * array.dtype.itemsize + CHECKSUM
    with os.scandir(rows / name) as files:
        sizes = {file.name: file.stat().st_size for file in files}
    return {
        int(file.partition(".")[0])
        for file, size in sizes.items()
        if size == width and file[:1].isdigit()
    }


@contextlib.contextmanager
def held_folder(folder: pathlib.Path) -> Iterator[pathlib.Path]:
    """A path to a folder that leads there, or nowhere, whatever becomes of its name.

    Where the system has no such paths, the folder itself.
    """
    with file_told(folder):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        held = pathlib.Path(f"/proc/self/fd/{descriptor}")
        yield held if held.is_dir() else folder
    finally:
        os.close(descriptor)
