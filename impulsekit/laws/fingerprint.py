"""A digest of all that compiled code of a function depends on.

It is taken from the code objects that are loaded, not from files, which may have changed
since: the function's own, those of all that it calls, and the constants that they read; and from
the options that what it calls is compiled with.
"""

from __future__ import annotations

import enum
import hashlib
import types
import weakref
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

__all__ = ["called_by", "fingerprint"]

_PACKAGE = __name__.partition(".")[0]


class _Own(NamedTuple):
    """What compiled code of a function depends on, beside what the functions that it names do.

    Attributes:
        read: where a global was found, by what name, and what was there.
        digest: of its code and of the values that it reads.
        functions: of this package that it names, in the order in which they occur.
    """

    read: tuple[tuple[dict[str, Any], str, Any], ...]
    digest: bytes
    functions: tuple[types.FunctionType, ...]


_owns: weakref.WeakKeyDictionary[types.FunctionType, _Own] = weakref.WeakKeyDictionary()


def fingerprint(function: Callable[..., Any], *more: str) -> str:
    """Hexadecimal digest (32 digits) of a function and of what it calls.

    Args:
        function: a Python function; numba's dispatchers are seen through.
        more: other text that the compiled code depends on.
    """
    digest = hashlib.sha256("\0".join(more).encode())
    first: Any = getattr(function, "py_func", function)
    seen, found = {first}, [first]
    for inner in found:
        own = _own(inner)
        digest.update(own.digest)
        for each in own.functions:
            if each not in seen:
                seen.add(each)
                found.append(each)
    return digest.hexdigest()[:32]


def _own(function: types.FunctionType) -> _Own:
    """Of one function; what was found is kept until another value stands where it was read."""
    known = _owns.get(function)
    if known is None or any(names.get(name) is not value for names, name, value in known.read):
        words = _Words(function)
        known = _Own(tuple(words.read), words.digest.digest(), tuple(words.functions))
        _owns[function] = known
    return known


def called_by(function: Callable[..., Any]) -> Iterator[Any]:
    """What a function of this package calls, and what that calls, each once; not itself.

    Args:
        function: a Python function.
    """
    seen, found = {id(function)}, [function]
    while found:
        inner = found.pop()
        inner = getattr(inner, "py_func", inner)
        for name in _names(inner.__code__):
            value = inner.__globals__.get(name)
            code = getattr(value, "py_func", value)
            if not isinstance(code, types.FunctionType) or id(code) in seen:
                continue
            if code.__module__.partition(".")[0] == _PACKAGE:
                seen.add(id(code))
                found.append(code)
                yield value


class _Words:
    """Values as text that is the same in every process, taken in one after the other."""

    def __init__(self, function: types.FunctionType) -> None:
        self.digest = hashlib.sha256()
        self.read: list[tuple[dict[str, Any], str, Any]] = []
        self.functions: list[types.FunctionType] = []
        self._take_function(function)

    def _add(self, word: str) -> None:
        self.digest.update(word.encode())
        self.digest.update(b"\0")

    def _take_function(self, function: types.FunctionType) -> None:
        self._add(f"{function.__module__}.{function.__qualname__}")
        names = sorted(_names(function.__code__))
        self._take(function.__code__)
        self._take(function.__defaults__)
        for cell in function.__closure__ or ():
            self._take(cell.cell_contents)
        for name in names:
            if name not in function.__globals__:
                continue
            value = self._look_up(function.__globals__, name)
            if isinstance(value, types.ModuleType) and value.__name__.startswith(_PACKAGE):
                # What is read from a module of ours: any of its names that occur here.
                for inner in names:
                    self._look_up(vars(value), inner)

    def _look_up(self, names: dict[str, Any], name: str) -> Any:
        value = names.get(name)
        self.read.append((names, name, value))
        self._add(name)
        self._take(value)
        return value

    def _take(self, value: Any) -> None:
        options = getattr(value, "targetoptions", getattr(value, "compiled_with", None))
        if isinstance(options, dict):
            self._add(repr(sorted(options.items())))
        value = getattr(value, "py_func", value)
        if isinstance(value, types.FunctionType):
            self._add(f"{value.__module__}.{value.__qualname__}")
            if value.__module__.partition(".")[0] == _PACKAGE:
                self.functions.append(value)
        elif isinstance(value, types.ModuleType):
            self._add(value.__name__)
        elif isinstance(value, type):
            self._add(f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}")
        elif isinstance(value, np.ndarray):
            self._add(f"{value.dtype} {value.shape} {value.tobytes().hex()}")
        elif isinstance(value, tuple | frozenset):
            parts = sorted(value, key=repr) if isinstance(value, frozenset) else value
            self._add(f"{type(value).__name__} {len(parts)}")
            for part in parts:
                self._take(part)
        elif isinstance(value, types.CodeType):
            self._take_code(value)
        elif isinstance(
            value, enum.Enum | bool | int | float | complex | str | bytes | None | range
        ):
            self._add(repr(value))
        elif isinstance(value, np.generic):
            self._add(f"{value.dtype} {value.item()!r}")
        else:
            # numba's intrinsics and the like: by name, as a repr may hold an address.
            self._add(f"{type(value).__qualname__} {getattr(value, '__name__', '')}")
            own = getattr(value, "_defn", None)
            if own is not None:
                self._take(own)

    def _take_code(self, code: types.CodeType) -> None:
        self._add(code.co_code.hex())
        self._add(
            " ".join((*code.co_names, *code.co_varnames, *code.co_freevars, *code.co_cellvars))
        )
        # A docstring is the first constant of some functions; it changes nothing.
        for i, constant in enumerate(code.co_consts):
            if not (i == 0 and isinstance(constant, str)):
                self._take(constant)


def _names(code: types.CodeType) -> set[str]:
    """The global names and attributes in a code object and in those nested in it."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names |= _names(constant)
    return names
