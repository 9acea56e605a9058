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

from ...errors import ImpulsekitError, MissingExtraError
from ...files import as_file_error, write_file

LOCK, OWNER = "writer.lock", "writer.json"


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

    The system holds the lock and releases it when its process ends, killed or not. A paused
    process keeps it. The file beside it names its owner.

    Yields:
        A function that raises ``StoreLockedError`` if the store was moved or deleted since.

    Raises:
        StoreLockedError: another process, or another run in this one, writes to the store.
        FileError: the files cannot be made, or their file system cannot lock.
    """
    with MissingExtraError.unless("filelock", "study", "the store of a study"):
        import filelock
    lock = filelock.FileLock(folder / LOCK, blocking=False, thread_local=False)
    with as_file_error(folder / LOCK, writing=True):
        try:
            lock.acquire()
        except filelock.Timeout:
            raise _locked_by(folder) from None
    now = datetime.datetime.now(datetime.UTC).isoformat(" ")
    owner = json.dumps({"process": os.getpid(), "host": socket.gethostname(), "since": now})

    def check() -> None:
        with contextlib.suppress(OSError):
            if (folder / OWNER).read_text() == owner:
                return
        why = "was moved or deleted while it was written to; nothing more is written"
        raise _error(folder, why, {})

    try:
        with with_full_disk_error(folder):
            write_file(folder / OWNER, owner)
        yield check
    finally:
        with contextlib.suppress(StoreLockedError, OSError):
            check()
            (folder / OWNER).unlink()
        lock.release()


def _locked_by(folder: pathlib.Path) -> StoreLockedError:
    """Return the error that names the owner of the lock, as far as its file does."""
    owner: Any = {}
    with contextlib.suppress(ValueError, OSError):
        owner = json.loads((folder / OWNER).read_bytes())
    who = "another process"
    if owner:
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
