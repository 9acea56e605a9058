"""The error that says that the disk of a store is full."""

from __future__ import annotations

import contextlib
import errno
import pathlib
from collections.abc import Iterator

from ...errors import ImpulsekitError

__all__ = ["StoreFullError", "full_disk_told"]


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
