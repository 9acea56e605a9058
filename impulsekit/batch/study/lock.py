"""One writer at a time, and what a full disk says."""

from __future__ import annotations

import contextlib
import datetime
import errno
import json
import os
import pathlib
import socket
from collections.abc import Iterator

from ...errors import ImpulsekitError
from ...files import file_told


@contextlib.contextmanager
def full_disk_told(path: pathlib.Path) -> Iterator[None]:
    """Turn the system's error for a full disk into a ``StoreFullError``."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            raise StoreFullError(
                f'no space left for "{path}" ({error.strerror}); free some space and run the '
                "same command again: rows already written are kept",
                path=str(path),
            ) from None
        raise


class StoreFullError(ImpulsekitError):
    """The disk of a store is full. Attributes: path."""

    path: str


NAME = "writer.lock"
_HELD = (errno.EWOULDBLOCK, errno.EACCES)


class StoreLockedError(ImpulsekitError):
    """Another process writes to a store. Attributes: path, process, host, since."""

    path: str
    process: int | None
    host: str | None
    since: str | None


class StoreLock:
    """A lock that is held; see ``lock_store``."""

    def __init__(self, path: pathlib.Path, descriptor: int) -> None:
        self._path, self._descriptor = path, descriptor

    def check(self) -> None:
        """Prove that the store is still the one that was locked.

        Raises:
            StoreLockedError: it was moved or deleted meanwhile; another may stand there.
        """
        try:
            there = os.stat(self._path)
            if os.path.samestat(there, os.fstat(self._descriptor)):
                return
        except FileNotFoundError:
            pass
        folder = self._path.parent
        raise StoreLockedError(
            f'"{folder}" was moved or deleted while it was written to; nothing more is written',
            path=str(folder),
            process=None,
            host=None,
            since=None,
        )


@contextlib.contextmanager
def lock_store(folder: pathlib.Path) -> Iterator[StoreLock]:
    """Be the only writer of a store, in this process and among all others.

    The system holds the lock (flock) and gives it up when its process ends, killed or not: a
    lock that was left behind cannot be. A paused process keeps it. The file tells who.

    Raises:
        StoreLockedError: another process, or another run in this one, writes to the store.
        FileError: the file cannot be made, or its file system cannot lock.
    """
    import fcntl

    path = folder / NAME
    with file_told(path, writing=True):
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
    try:
        with file_told(path, writing=True):
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                if error.errno not in _HELD:
                    raise
                raise _locked(folder, descriptor) from None
        _write_owner(descriptor)
        lock = StoreLock(path, descriptor)
        lock.check()
        try:
            yield lock
        finally:
            with contextlib.suppress(OSError):
                os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _write_owner(descriptor: int) -> None:
    now = datetime.datetime.now(datetime.UTC).isoformat(" ", "seconds")
    owner = {"process": os.getpid(), "host": socket.gethostname(), "since": now}
    # A full disk must not keep anybody from locking.
    with contextlib.suppress(OSError):
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, json.dumps(owner).encode(), 0)


def _locked(folder: pathlib.Path, descriptor: int) -> StoreLockedError:
    """The error that says who holds the lock."""
    owner: dict = {}
    with contextlib.suppress(OSError, ValueError):
        read = json.loads(os.pread(descriptor, 4096, 0))
        owner = read if isinstance(read, dict) else {}
    process, host, since = (owner.get(key) for key in ("process", "host", "since"))
    who = "another process"
    if process is not None:
        who = f"process {process} on {host} since {since}"
        if host == socket.gethostname():
            who += _state_of(process)
    return StoreLockedError(
        f'"{folder}" is being written to by {who}; wait until it has ended, or name another folder',
        path=str(folder),
        process=process,
        host=host,
        since=since,
    )


def _state_of(process: int) -> str:
    """Whether a process of this machine is paused, where the system tells."""
    with contextlib.suppress(OSError, IndexError):
        state = pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
        if state in "Tt":
            return f", which is paused (kill -CONT {process} lets it go on)"
    return ""
