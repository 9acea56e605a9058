"""Tensors that torch saved, read without torch."""

from __future__ import annotations

import os
import pickle
import zipfile
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from impulsekit.errors import FileError, shown
from impulsekit.files import as_file_error, open_plain_file

# [bytes] A toss has some 20 kB.
LARGEST = 100_000_000


class _Plain(pickle.Unpickler):
    """Reads what a saved tensor consists of, and calls nothing that a file names."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("torch._utils", "_rebuild_tensor_v2"):
            return lambda storage, offset, shape, stride, *_: (storage, offset, shape, stride)
        if (module, name) in (("torch", "DoubleStorage"), ("collections", "OrderedDict")):
            return dict
        raise pickle.UnpicklingError(f"{module}.{name} has no place in a tensor")

    def persistent_load(self, pid: Any) -> Any:
        return pid


def read_tensor(path: str | os.PathLike[str]) -> np.ndarray:
    """A tensor of doubles as ``torch.save`` writes it, before version 1.6 (pickles) or since (zip).

    Raises:
        FileError: the file is none.
    """
    label = shown(Path(path).name, 80)
    with as_file_error(path), open_plain_file(path) as file:
        try:
            if os.fstat(file.fileno()).st_size > LARGEST:
                raise ValueError("too large for a toss")
            parts, numbers = (_zipped if zipfile.is_zipfile(file) else _pickled)(file)
            _, offset, shape, stride = parts
            strides = tuple(8 * step for step in stride)
            last = offset + sum((n - 1) * s for n, s in zip(shape, stride, strict=True))
            if min((offset, *shape, *stride), default=0) < 0 or last >= len(numbers):
                raise ValueError("numbers are missing")
            view = np.lib.stride_tricks.as_strided(numbers[offset:], shape, strides)
        except Exception as error:  # whatever a pickle that is none raises
            raise FileError(
                f"{label}: no tensor of doubles ({type(error).__name__}: {error})", path=label
            ) from None
        return np.array(view)


def _pickled(file: BinaryIO) -> tuple[Any, np.ndarray]:
    file.seek(0)
    parts = [_Plain(file).load() for _ in range(5)]
    count = int.from_bytes(file.read(8), "little")
    return parts[3], np.frombuffer(file.read(8 * count), dtype="<f8")


def _zipped(file: BinaryIO) -> tuple[Any, np.ndarray]:
    with zipfile.ZipFile(file) as whole:
        name = next(each for each in whole.namelist() if each.endswith("data.pkl"))
        folder = name.removesuffix("data.pkl")
        order = f"{folder}byteorder"
        if order in whole.namelist() and whole.read(order) != b"little":
            raise ValueError("numbers in big-endian order")
        if whole.getinfo(name).file_size > LARGEST:
            raise ValueError("too large for a toss")
        with whole.open(name) as pickled:
            parts = _Plain(pickled).load()
        _, _, key, _, count = parts[0]
        if not 0 <= count <= LARGEST // 8:
            raise ValueError("too large for a toss")
        with whole.open(f"{folder}data/{key}") as stored:
            return parts, np.frombuffer(stored.read(8 * count), dtype="<f8")
