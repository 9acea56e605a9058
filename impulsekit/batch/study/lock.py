"""One writer at a time, and a full disk."""

from __future__ import annotations

import contextlib
import datetime
import errno
import json
import os
import pathlib
import socket
from collections.abc import Callable, Iterator
from typing import Any

from ...errors import ImpulsekitError
from ...files import file_told

LOCK = "writer.lock"


class StoreFullError(ImpulsekitError):
    """The disk of a store is full. Attributes: path."""

    path: str


class StoreLockedError(ImpulsekitError):
    """Another process writes to a store. Attributes: path, process, host, since."""

    path: str
    process: int | None
    host: str | None
    since: str | None


@contextlib.contextmanager
def with_full_disk_error(path: pathlib.Path) -> Iterator[None]:
    """Turn the system's error for a full disk into a ``StoreFullError``."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            raise StoreFullError(
                f'no space left for "{path}" ({os.strerror(error.errno)}); free some space and run '
                "the same command again: rows already written are kept",
                path=str(path),
            ) from None
        raise


@contextlib.contextmanager
def lock_store(folder: pathlib.Path) -> Iterator[Callable[[], None]]:
    """Be the only writer of a store, in this process and among all others.

    The system holds the lock (flock) and releases it when its process ends, killed or not. A
    paused process keeps it. The file names its owner.

    Yields:
        A function that raises ``StoreLockedError`` if the store was moved or deleted since.

    Raises:
        StoreLockedError: another process, or another run in this one, writes to the store.
        FileError: the file cannot be made, or its file system cannot lock.
    """
    import fcntl

    path = folder / LOCK
    with contextlib.ExitStack() as held:
        with file_told(path, writing=True):
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
            held.callback(os.close, descriptor)
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise _locked_by(folder, os.pread(descriptor, 4096, 0)) from None
        now = datetime.datetime.now(datetime.UTC).isoformat(" ", "seconds")
        owner = {"process": os.getpid(), "host": socket.gethostname(), "since": now}
        # A full disk does not prevent locking.
        with contextlib.suppress(OSError):
            os.ftruncate(descriptor, 0)
            held.callback(os.ftruncate, descriptor, 0)
            os.pwrite(descriptor, json.dumps(owner).encode(), 0)

        def check() -> None:
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.stat(path), os.fstat(descriptor)):
                    return
            why = "was moved or deleted while it was written to; nothing more is written"
            raise _error(folder, why, {})

        check()
        yield check


def _locked_by(folder: pathlib.Path, written: bytes) -> StoreLockedError:
    """The error that names the owner of the lock, as far as the lock's file does."""
    owner: Any = {}
    with contextlib.suppress(ValueError):
        owner = json.loads(written)
    who = "another process"
    if isinstance(owner, dict) and "process" in owner:
        who = "process {process} on {host} since {since}".format(**owner)
        if owner["host"] == socket.gethostname() and _is_paused(owner["process"]):
            who += f", which is paused (kill -CONT {owner['process']} lets it go on)"
    why = f"is being written to by {who}; wait until it has ended, or name another folder"
    return _error(folder, why, owner)


def _is_paused(process: int) -> bool:
    with contextlib.suppress(OSError, IndexError):
        stat = pathlib.Path(f"/proc/{process}/stat").read_text()
        return stat.rpartition(")")[2].split()[0] in "Tt"
    return False


def _error(folder: pathlib.Path, why: str, owner: dict[str, Any]) -> StoreLockedError:
    names = ("process", "host", "since")
    of_owner = {name: owner.get(name) for name in names}
    return StoreLockedError(f'"{folder}" {why}', path=str(folder), **of_owner)
