"""A digest of all that compiled code of a function depends on.

It is taken from the code objects that are loaded, not from files, which may have changed
since: the function's own, those of all that it calls, and the constants that they read; and from
the options that what it calls is compiled with.
"""

from __future__ import annotations

import enum
import hashlib
import types
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

__all__ = ["called_by", "fingerprint"]

_PACKAGE = __name__.partition(".")[0]


def fingerprint(function: Callable[..., Any], *more: str) -> str:
    """Hexadecimal digest (32 digits) of a function and of what it calls.

    Args:
        function: a Python function; numba's dispatchers are seen through.
        more: other text that the compiled code depends on.
    """
    digest = hashlib.sha256()
    for word in (*more, *_words(function, set())):
        digest.update(word.encode())
        digest.update(b"\0")
    return digest.hexdigest()[:32]


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


def _words(value: Any, seen: set[int]) -> Iterator[str]:
    """The value as text that is the same in every process."""
    options = getattr(value, "targetoptions", getattr(value, "compiled_with", None))
    if isinstance(options, dict):
        yield repr(sorted(options.items()))
    value = getattr(value, "py_func", value)
    if id(value) in seen:
        yield "seen"
    elif isinstance(value, types.FunctionType):
        seen.add(id(value))
        yield f"{value.__module__}.{value.__qualname__}"
        if value.__module__.partition(".")[0] == _PACKAGE:
            yield from _words_of_function(value, seen)
    elif isinstance(value, types.ModuleType):
        yield value.__name__
    elif isinstance(value, type):
        yield f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}"
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    elif isinstance(value, tuple | frozenset):
        parts = sorted(value, key=repr) if isinstance(value, frozenset) else value
        yield f"{type(value).__name__} {len(parts)}"
        for part in parts:
            yield from _words(part, seen)
    elif isinstance(value, types.CodeType):
        yield from _words_of_code(value, seen)
    elif isinstance(value, enum.Enum | bool | int | float | complex | str | bytes | None | range):
        yield repr(value)
    elif isinstance(value, np.generic):
        yield f"{value.dtype} {value.item()!r}"
    else:
        # numba's intrinsics and the like: by name, as a repr may hold an address.
        yield f"{type(value).__qualname__} {getattr(value, '__name__', '')}"
        own = getattr(value, "_defn", None)
        if own is not None:
            yield from _words(own, seen)


def _words_of_function(function: types.FunctionType, seen: set[int]) -> Iterator[str]:
    yield from _words(function.__code__, seen)
    yield from _words(function.__defaults__, seen)
    for cell in function.__closure__ or ():
        yield from _words(cell.cell_contents, seen)
    for name in sorted(_names(function.__code__)):
        if name not in function.__globals__:
            continue
        value = function.__globals__[name]
        yield name
        yield from _words(value, seen)
        if isinstance(value, types.ModuleType) and value.__name__.startswith(_PACKAGE):
            # What is read from a module of ours: any of its names that occur here.
            for inner in sorted(_names(function.__code__)):
                yield from _words(getattr(value, inner, None), seen)


def _names(code: types.CodeType) -> set[str]:
    """The global names and attributes in a code object and in those nested in it."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names |= _names(constant)
    return names


def _words_of_code(code: types.CodeType, seen: set[int]) -> Iterator[str]:
    yield code.co_code.hex()
    yield " ".join((*code.co_names, *code.co_varnames, *code.co_freevars, *code.co_cellvars))
    # A docstring is the first constant of some functions; it changes nothing.
    for i, constant in enumerate(code.co_consts):
        if i == 0 and isinstance(constant, str):
            continue
        yield from _words(constant, seen)
