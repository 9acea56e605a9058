"""``run_study``: chunk after chunk, here or on a Dask cluster, into the store."""

from __future__ import annotations

import functools
import itertools
import os
import pickle
import socket
from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any

import numpy as np

from ...errors import InputError, MissingExtraError, check_kind
from ...errors.calls import public
from ...motion.interrupts import Interrupts
from ...motion.record.status import MotionStatus
from ..motions.simulate import simulate_batch
from ..progress import shown
from ..remote import check_client
from ..solve import solve_batch
from .store import StudyStore
from .study import Study


@public
def run_study(
    study: Study,
    store: str | os.PathLike[str],
    *,
    progress: Any = None,
    threads: int | None = None,
    client: Any = None,
) -> StudyStore:
    """Run a study: draw, solve (or simulate) and write all rows that its store does not have yet.

    A stopped run resumes when called again; its store is then identical, bit for bit, to that
    of an uninterrupted run.

    Args:
        study: the study.
        store: the folder for the rows; created if it does not exist.
        progress: True for a progress bar, or a function of (rows done, rows in total).
        threads: of each process; by default as many as it may use cores.
        client: a ``distributed.Client``; its workers solve, this process writes. If a worker
            dies, another one solves its chunk.

    Raises:
        InputError: the folder holds something else, or the store of another study.
        StoreLockedError: another process writes to the store, or it was moved or deleted.
        StoreFullError: no space is left; written rows are kept.
        FileError: the folder cannot be made or written to.
        MissingExtraError: xarray or dask is not installed.

    Example:
        >>> import dataclasses, tempfile
        >>> from impulsekit.study import load_study, open_study
        >>> study = dataclasses.replace(load_study("examples/landing_study.toml"), samples=100)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     store = run_study(study, folder + "/rows")
        ...     rows = len(open_study(store.path)["status"])
        >>> rows
        100
    """
    check_kind(study, Study, "run_study")
    if client is not None:
        check_client(client)
    place = StudyStore(store, study)
    with place.opened() as todo:
        before = study.samples - sum(end - begin for begin, end in map(study.rows, todo))
        done = before
        # Motions heed Ctrl-C themselves, within a chunk.
        waits = nullcontext(None) if study.motion is not None else Interrupts()
        with shown(progress, study.samples, before) as tell, waits as interrupts:
            here = ((index, solved_chunk(study, index, threads)) for index in todo)
            results = here if client is None else _there(study, todo, client)
            for index, arrays in results:
                place.write(index, arrays)
                begin, end = study.rows(index)
                done += end - begin
                tell(done)
                if interrupts is not None:
                    interrupts.heed()
    return place


def solved_chunk(study: Study, index: int, threads: int | None = None) -> dict[str, np.ndarray]:
    """Return all arrays of a chunk: what was drawn, what came out."""
    given = study.drawn(index)
    begin, end = study.rows(index)
    found = _impacts if study.motion is None else _motions
    # Where nothing varies, the batch has one row.
    arrays = {
        name: np.repeat(array, (end - begin) // len(array), axis=0)
        for name, array in found(study, given, threads).items()
    }
    return {**arrays, **{name: study.stored(name, given, end - begin) for name in study.varied}}


def _impacts(study: Study, given: dict[str, Any], threads: int | None) -> dict[str, np.ndarray]:
    batch = solve_batch(study.scene, **given, outputs=study.names, threads=threads)
    return {**batch.arrays, "status": batch.status}


def _motions(study: Study, given: dict[str, Any], threads: int | None) -> dict[str, np.ndarray]:
    batch = simulate_batch(study.scene, **given, settings=study.motion, threads=threads)
    if (batch.status == MotionStatus.INTERRUPTED.code).any():
        # A row that was broken off is followed anew by the next run.
        raise KeyboardInterrupt
    impulses = np.zeros((len(batch), len(study.scene.contacts), 3))
    np.add.at(impulses, batch.impacts.row, batch.impacts.impulse)
    arrays = {
        "status": batch.status,
        "end": batch.end,
        "q_end": batch.q_end,
        "v_end": batch.v_end,
        "impact_count": np.bincount(batch.impacts.row, minlength=len(batch)).astype(float),
        "contact_impulses": impulses,
        "q_samples": batch.q,
        "v_samples": batch.v,
    }
    return {name: arrays[name] for name in ("status", *study.names)}


@functools.lru_cache(maxsize=1)
def _received(packed: bytes, fingerprint: str) -> Study:
    """Return the study of a worker, which unpacks it only once."""
    study: Study = pickle.loads(packed)
    if study.fingerprint != fingerprint:
        raise InputError(
            f"the worker on {socket.gethostname()} reads other files, or has other versions "
            "of packages, than the process that writes"
        )
    return study


def _sent_chunk(packed: bytes, fingerprint: str, index: int) -> dict[str, np.ndarray]:
    return solved_chunk(_received(packed, fingerprint), index, threads=1)


def _there(
    study: Study, todo: list[int], client: Any
) -> Iterator[tuple[int, dict[str, np.ndarray]]]:
    """Yield chunks as the workers of a cluster have them ready; never many at a time."""
    with MissingExtraError.unless("distributed", "study", "a study on a cluster"):
        from distributed import as_completed
    given = (pickle.dumps(study), study.fingerprint)
    waiting = iter(todo)
    submitted: dict[Any, int] = {}

    def submit(count: int) -> list[Any]:
        new = {
            client.submit(_sent_chunk, *given, index, pure=False): index
            for index in itertools.islice(waiting, count)
        }
        submitted.update(new)
        return list(new)

    queue = as_completed(submit(3 * len(client.scheduler_info()["workers"]) or 3), loop=client.loop)
    for future in queue:
        yield submitted.pop(future), future.result()
        future.release()
        for following in submit(1):
            queue.add(following)
