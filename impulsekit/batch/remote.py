"""Batches on Dask: dask arrays in, dask arrays out, or numpy arrays over a client."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ..errors import InputError, MissingExtraError, a_thing
from ..robot.arrays import floats
from ..scene import Scene
from .result import ImpactBatch, shape_of

__all__ = ["check_client", "computed", "is_lazy", "solve_lazily"]

# Rows of one task where the arrays that are given have no chunks of their own.
ROWS = 65536


def is_lazy(*values: Any) -> bool:
    """Return whether any of these, or of the entries of a mapping, is a dask array."""
    entries = (v for x in values for v in (x.values() if isinstance(x, Mapping) else (x,)))
    return any(hasattr(entry, "__dask_graph__") for entry in entries)


def solve_lazily(
    solve_batch: Callable[..., ImpactBatch],
    scene: Scene,
    given: dict[str, Any],
    outputs: Sequence[str],
    threads: int | None = None,
) -> dict[str, Any]:
    """Dask arrays of all outputs and of the status, chunked along the rows.

    Args:
        solve_batch: what each task calls.
        given: the arguments of ``solve_batch`` that may vary, by name.
        outputs: what to compute.
        threads: of each task.

    Raises:
        InputError: arrays whose leading axes do not agree.
        MissingExtraError: dask is not installed.
    """
    with MissingExtraError.unless("dask", "study", "a batch of dask arrays"):
        import dask
        import dask.array as da

    contacts = len(scene.contacts)
    chunks = _chunks(given, contacts)
    packed = pickle.dumps(scene)
    parts: dict[str, list[Any]] = {name: [] for name in (*outputs, "status")}
    solve = dask.delayed(partial(_sent_rows, solve_batch), pure=False)
    begin = 0
    for size in chunks:
        cut = {name: _cut(name, value, begin, size, contacts) for name, value in given.items()}
        answer = solve(packed, cut, tuple(outputs), threads)
        for name in outputs:
            shape = (size, *shape_of(scene, name))
            parts[name].append(da.from_delayed(answer[name], shape, float))
        parts["status"].append(da.from_delayed(answer["status"], (size,), np.int8))
        begin += size
    return {name: da.concatenate(own) for name, own in parts.items()}


def computed(lazy: dict[str, Any], client: Any) -> dict[str, np.ndarray]:
    """The arrays that the workers of a client compute.

    Raises:
        InputError: it is no client.
    """
    check_client(client)
    return dict(zip(lazy, client.gather(client.compute(list(lazy.values()))), strict=True))


def check_client(client: Any) -> None:
    """Check that something is a client of dask.

    Raises:
        InputError.
    """
    if not all(hasattr(client, name) for name in ("compute", "gather", "run", "submit")):
        raise InputError(f"client must be a distributed.Client, got {a_thing(client)}")


def _chunks(given: Mapping[str, Any], contacts: int) -> tuple[int, ...]:
    """The number of rows of each task."""
    sizes: dict[str, int] = {}
    chunks: tuple[int, ...] | None = None
    for name, value in given.items():
        if value is None:
            continue
        mapped = isinstance(value, Mapping)
        for label, entry in value.items() if mapped else ((name, value),):
            array = _array(entry, label)
            if _varies(name, mapped, array, contacts):
                if array.shape[0] != array.shape[0]:
                    raise InputError(
                        f"{label}: how many rows its chunks have is not known; call its "
                        "compute_chunk_sizes() before"
                    )
                sizes[label] = int(array.shape[0])
                if chunks is None and hasattr(array, "__dask_graph__"):
                    chunks = tuple(int(size) for size in array.chunks[0])
    rows = max(sizes.values(), default=1)
    if not set(sizes.values()) <= {1, rows}:
        raise InputError(f"the arrays of a batch must have one number of rows, got {sizes}")
    if chunks is None or sum(chunks) != rows:
        chunks = tuple(min(ROWS, rows - begin) for begin in range(0, rows, ROWS))
    return chunks


def _array(entry: Any, what: str) -> Any:
    return entry if hasattr(entry, "ndim") else floats(entry, what, copied=False)


def _varies(name: str, mapped: bool, array: Any, contacts: int) -> bool:
    """Return whether the leading axis of an argument of ``solve_batch`` counts the rows."""
    of_numbers = mapped or contacts == 1
    scalar = name == "masses" or (name in ("restitution", "friction") and of_numbers)
    return bool(array.ndim == 2 or (scalar and array.ndim == 1))


def _cut(name: str, value: Any, begin: int, size: int, contacts: int, mapped: bool = False) -> Any:
    """The rows of a task from ``begin``; all of what does not vary."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        return {key: _cut(name, one, begin, size, contacts, True) for key, one in value.items()}
    array = _array(value, name)
    varies = _varies(name, mapped, array, contacts) and array.shape[0] > 1
    return array[begin : begin + size] if varies else array


@lru_cache(maxsize=1)
def _unpacked(packed: bytes) -> Scene:
    """The scene of a worker, which unpacks it only once."""
    scene: Scene = pickle.loads(packed)
    return scene


def _sent_rows(
    solve_batch: Callable[..., ImpactBatch],
    packed: bytes,
    given: dict[str, Any],
    outputs: tuple[str, ...],
    threads: int | None,
) -> dict[str, np.ndarray]:
    """``solve_batch`` in a worker."""
    batch = solve_batch(_unpacked(packed), **given, outputs=outputs, threads=threads)
    return {**batch.arrays, "status": batch.status}
