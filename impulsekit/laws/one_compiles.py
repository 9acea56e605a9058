"""One process compiles a function, and others that want it wait for what that one keeps.

A process holds one byte of a file in the cache's folder, by the digest of what it compiles; the
system lets go of it when the process ends. Where files cannot be locked nobody waits.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pathlib
import time

__all__ = ["begin_compiling", "end_compiling"]

# Nothing takes so long to compile; a lock held longer is one that nobody lets go of [s].
PATIENCE = 300.0
# Between two looks at a lock [s].
PAUSE = 0.02

# Closing a file lets go of all that the process holds of it: each is opened once.
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
    """Let others go on."""
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
    """Of the byte that stands for it."""
    return int.from_bytes(hashlib.sha256(path.name.encode()).digest()[:4], "big") >> 1
