"""One process compiles a function; others that need it wait for the result on disk.

A process locks one byte of a file in the cache's folder, by the digest of what it compiles; the
system releases the lock when the process ends. Where files cannot be locked no process waits.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pathlib
import time

__all__ = ["begin_compiling", "end_compiling"]

# No function takes so long to compile; a lock held longer is not waited for [s].
PATIENCE = 300.0
# Between two attempts to lock [s].
PAUSE = 0.02

# Closing a file releases all locks of the process on it: each is opened once.
_files: dict[pathlib.Path, int] = {}


def begin_compiling(path: pathlib.Path) -> None:
    """Return when no other process compiles what is to be kept at ``path``.

    Others wait from then on until ``end_compiling``.
    """
    try:
        import fcntl
    except ImportError:
        return
    end = time.monotonic() + PATIENCE
    with contextlib.suppress(OSError):
        descriptor = _file(path.parent)
        while time.monotonic() < end:
            try:
                fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _place(path))
                return
            except (BlockingIOError, PermissionError):
                time.sleep(PAUSE)


def end_compiling(path: pathlib.Path) -> None:
    """Release the lock: others go on."""
    try:
        import fcntl
    except ImportError:
        return
    with contextlib.suppress(OSError):
        fcntl.lockf(_file(path.parent), fcntl.LOCK_UN, 1, _place(path))


def _file(folder: pathlib.Path) -> int:
    if folder not in _files:
        folder.mkdir(parents=True, exist_ok=True)
        _files[folder] = os.open(folder / "compiling", os.O_RDWR | os.O_CREAT, 0o666)
    return _files[folder]


def _place(path: pathlib.Path) -> int:
    """Offset of the byte that stands for a path."""
    return int.from_bytes(hashlib.sha256(path.name.encode()).digest()[:4], "big") >> 1
