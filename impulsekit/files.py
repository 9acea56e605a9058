"""Files of a user: what cannot be read or written is told with the path and the reason."""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator

from .errors import FileError, shown

__all__ = ["file_told", "reason_of", "refuse_device"]

_REASONS: dict[type[OSError], str] = {
    FileNotFoundError: "there is no such file",
    NotADirectoryError: "there is no such file",
    IsADirectoryError: "that is a folder, not a file",
    PermissionError: "that is not permitted",
}


def reason_of(error: OSError) -> str:
    """Why the system refused, in words."""
    return _REASONS.get(type(error)) or error.strerror or str(error)


def refuse_device(path: str | os.PathLike[str]) -> None:
    """Prove that a path is no device: one such as /dev/zero never ends.

    Raises:
        OSError: it is, or there is nothing.
    """
    mode = os.stat(path).st_mode
    if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
        raise OSError(None, "that is a device, not a file")


@contextlib.contextmanager
def file_told(path: str | os.PathLike[str], *, writing: bool = False) -> Iterator[None]:
    """Turn an ``OSError`` on a path into a ``FileError`` that tells it.

    Raises:
        FileError: what is within raised an ``OSError``.
    """
    try:
        yield
    except FileError:
        raise
    except OSError as error:
        reason = reason_of(error)
        if writing and isinstance(error, FileNotFoundError | NotADirectoryError):
            reason = "there is no folder to write it into"
        told = FileError(f"{shown(os.fspath(path), 200)}: {reason}", path=os.fspath(path))
        told.errno = error.errno
        raise told from error
