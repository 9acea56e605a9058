"""Compiled code on disk: one file per function, signature, machine and digest of the sources.

Code of other sources is never found, as it has other names, whatever folder is set and
whichever installations share it. Files are written whole and put in place at once, so
processes and threads may compile side by side; the same function is compiled by one of them.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import pathlib
import pickle
import time
from collections.abc import Callable
from typing import Any

from .fingerprint import fingerprint
from .one_compiles import begin_compiling, end_compiling
from .parts import give_environments, rebuilt

__all__ = ["Store", "cache_folder", "is_stored"]

# Compiled code of other sources that nobody has loaded for so long is deleted [s].
FORGOTTEN = 14 * 86400.0


def cache_folder() -> pathlib.Path:
    """Where compiled code is kept: NUMBA_CACHE_DIR, beside the package, or the user's cache.

    Example:
        >>> cache_folder().is_absolute()
        True
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given:
        return pathlib.Path(given).absolute() / "impulsekit"
    package = pathlib.Path(__file__).resolve().parent.parent
    beside = package / "__pycache__"
    if os.access(beside if beside.exists() else package, os.W_OK):
        return beside / "compiled"
    users = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    return pathlib.Path(users or pathlib.Path.home() / ".cache").absolute() / "impulsekit"


def is_stored(function: Callable[..., Any], *more: str) -> bool:
    """Whether there is compiled code of a function, for this machine or another."""
    name = _name_of(function)
    with contextlib.suppress(OSError):
        return any(cache_folder().glob(f"{name}-{fingerprint(function, *more)}-*.code"))
    return False


class Store:
    """The cache of one dispatcher, as numba calls it.

    Args:
        function: that is compiled.
        more: options of the compiler, and other text that the code depends on.
    """

    def __init__(self, function: Callable[..., Any], *more: str) -> None:
        self._function, self._more = function, more
        # What this process compiles now, the innermost last.
        self._begun: list[pathlib.Path] = []

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(cache_folder())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled code for a signature; None if this process has to compile it."""
        target_context.refresh()
        path = self._path(sig, target_context)
        found = _read(path, target_context)
        if found is None:
            begin_compiling(path)
            # Another process may have compiled it meanwhile.
            found = _read(path, target_context)
            if found is not None:
                end_compiling(path)
            else:
                self._begun.append(path)
        return found

    def holds(self, sig: Any, target_context: Any) -> bool:
        """Whether the compiled code for a signature is on disk, made for this machine."""
        return self._path(sig, target_context).exists()

    def give_up(self) -> None:
        """What was begun last was not compiled: other processes go on."""
        if self._begun:
            end_compiling(self._begun.pop())

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep compiled code, if a folder can be written; what is older and unused goes."""
        from numba.core.serialize import dumps

        path = self._path(sig, data.target_context)
        if path in self._begun:
            self._begun.remove(path)
        give_environments(data)
        if data.library.has_dynamic_globals or data.lifted:
            end_compiling(path)
            return
        packed = dumps(data._reduce())
        partial = path.with_name(f"{path.stem}.{os.getpid()}.{time.monotonic_ns()}.partial")
        with contextlib.suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            partial.write_bytes(hashlib.sha256(packed).digest() + packed)
            os.replace(partial, path)
        end_compiling(path)
        with contextlib.suppress(OSError):
            for other in path.parent.glob(f"{_name_of(self._function)}-*"):
                if time.time() - other.stat().st_mtime > FORGOTTEN:
                    other.unlink(missing_ok=True)

    @functools.cached_property
    def _own(self) -> str:
        return fingerprint(self._function, *self._more)

    def _path(self, sig: Any, target_context: Any) -> pathlib.Path:
        import llvmlite
        import numba

        versions = f"{numba.__version__} {llvmlite.__version__}"
        key = f"{versions} {sig} {target_context.codegen().magic_tuple()}"
        kind = hashlib.sha256(key.encode()).hexdigest()[:16]
        return cache_folder() / f"{_name_of(self._function)}-{self._own}-{kind}.code"


def _read(path: pathlib.Path, target_context: Any) -> Any:
    """The compiled code in a file; None where there is none, or none that can be read."""
    try:
        data = path.read_bytes()
        if hashlib.sha256(data[32:]).digest() != data[:32]:
            return None
        found = rebuilt(target_context, pickle.loads(data[32:]))
    except Exception:
        # What cannot be read is compiled anew.
        return None
    with contextlib.suppress(OSError):
        os.utime(path)
    return found


def _name_of(function: Callable[..., Any]) -> str:
    return f"{function.__module__}.{function.__name__}".partition(".")[2]
