"""``run_study``: chunk after chunk, here or on a Dask cluster, into the store."""

from __future__ import annotations

import os
import pickle
import socket
from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any

import numpy as np

from ...errors import InputError, MissingExtraError, check_kind
from ...motion.interrupts import Interrupts
from ...motion.record.status import MotionStatus
from ..motions.simulate import simulate_batch
from ..progress import shown
from ..remote import check_client
from ..solve import solve_batch
from .store import StudyStore
from .study import Study


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
        MissingExtraError: xarray or zarr is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> from impulsekit.models import pendulum_urdf
        >>> from impulsekit.study import Study, Variation, open_study
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> scene = Scene(rod, [AppliedImpulse("link_1", linear=[1, 0, 0])])
        >>> pushed = Variation("velocity", low=0.0, high=0.1)
        >>> study = Study(scene, [0.0], [0.0], samples=100, vary=[pushed])
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = run_study(study, folder + "/rows")
        ...     rows = len(open_study(folder + "/rows")["status"])
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
            results = _here(study, todo, threads) if client is None else _there(study, todo, client)
            for index, arrays in results:
                place.write(index, arrays)
                begin, end = study.rows(index)
                done += end - begin
                tell(done)
                if interrupts is not None:
                    interrupts.heed()
    return place


def solved_chunk(study: Study, index: int, threads: int | None = None) -> dict[str, np.ndarray]:
    """All arrays of a chunk: what was drawn, what came out."""
    given = study.drawn(index)
    begin, end = study.rows(index)
    found = _impacts if study.motion is None else _motions
    arrays = {
        name: _of_all_rows(array, end - begin)
        for name, array in found(study, given, threads).items()
    }
    whats = {one.what for one in study.vary}
    if "configuration" in whats:
        arrays["q"] = given["q"]
    if "velocity" in whats:
        arrays["v"] = given["v"]
    if "impulses" in given:
        names = study.scene.entry_names("impulses")
        arrays["impulses"] = np.hstack([given["impulses"][name] for name in names])
    if "masses" in given:
        arrays["masses"] = np.column_stack([given["masses"][name] for name in study.scaled_links])
    for what in ("restitution", "friction"):
        if what in given:
            arrays[what] = _coefficients(study, what, given[what], end - begin)
    return arrays


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


def _of_all_rows(array: np.ndarray, rows: int) -> np.ndarray:
    """A batch of one row, where nothing varied, as many."""
    return array if len(array) == rows else np.repeat(array, rows, axis=0)


def _coefficients(study: Study, what: str, drawn: dict[str, np.ndarray], rows: int) -> np.ndarray:
    """(rows, contacts) as they were drawn, the scene's own elsewhere."""
    names = study.scene.entry_names("contacts")
    table = np.empty((rows, len(names)))
    for i, (name, entry) in enumerate(zip(names, study.scene.contacts, strict=True)):
        own = getattr(entry, what, 0.0)
        table[:, i] = drawn.get(name, np.nan if callable(own) else own)
    return table


def _here(
    study: Study, todo: list[int], threads: int | None
) -> Iterator[tuple[int, dict[str, np.ndarray]]]:
    for index in todo:
        yield index, solved_chunk(study, index, threads)


_received: dict[str, Study] = {}


def _sent_chunk(packed: bytes, fingerprint: str, index: int) -> dict[str, np.ndarray]:
    """``solved_chunk`` in a worker, which unpacks a study only once."""
    if fingerprint not in _received:
        _received.clear()
        study = pickle.loads(packed)
        if study.fingerprint != fingerprint:
            raise InputError(
                f"the worker on {socket.gethostname()} reads other files, or has other versions "
                "of packages, than the process that writes"
            )
        _received[fingerprint] = study
    return solved_chunk(_received[fingerprint], index, threads=1)


def _there(
    study: Study, todo: list[int], client: Any
) -> Iterator[tuple[int, dict[str, np.ndarray]]]:
    """Chunks as the workers of a cluster have them ready; never many at a time."""
    with MissingExtraError.unless("distributed", "study", "a study on a cluster"):
        from distributed import as_completed
    packed = pickle.dumps(study)
    workers = max(1, len(client.scheduler_info()["workers"]))
    waiting = iter(todo)

    def submit(index: int) -> Any:
        return client.submit(_sent_chunk, packed, study.fingerprint, index, pure=False)

    running = {}
    for _ in range(3 * workers):
        index = next(waiting, None)
        if index is not None:
            running[submit(index)] = index
    queue = as_completed(list(running), loop=client.loop)
    for future in queue:
        index = running.pop(future)
        yield index, future.result()
        future.release()
        following = next(waiting, None)
        if following is not None:
            new = submit(following)
            running[new] = following
            queue.add(new)
