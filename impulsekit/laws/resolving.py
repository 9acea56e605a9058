"""What numba makes of operators and of its options, remembered from one function to the next.

For every ``a * b`` or ``a[i]`` numba asks whatever could be meant, up to a hundred overloads, once
for the types and up to four times for the code. For numbers and arrays the answer is the same in
all functions. And each time it looks for an overload that it has compiled, it makes tables of all
options to compare.
"""

from __future__ import annotations

import contextlib
import functools
import types as python_types
from collections.abc import Iterator
from typing import Any

from .parts import pipeline

__all__ = ["KNOWN", "quick_compiler"]

# What is remembered is private to numba: releases that this was not tried with compile as they do.
KNOWN = ("0.68.",)


@functools.cache
def quick_compiler() -> Any:
    """numba's compiler, with the operators and options remembered."""
    import numba
    from numba.core.compiler import Compiler

    if not numba.__version__.startswith(KNOWN):
        return Compiler
    from numba.core.targetconfig import _FlagsStack
    from numba.core.untyped_passes import InlineClosureLikes

    class QuickCompiler(Compiler):
        def __init__(self, typingctx: Any, *args: Any, **kwargs: Any) -> None:
            super().__init__(_remembering(typingctx), *args, **kwargs)
            # A context of this compilation alone.
            self.state.targetctx.typing_context = self.state.typingctx

        def define_pipelines(self) -> Any:
            # numba has just put a copy of the options there, and will take off what is there.
            stack = _FlagsStack()
            stack.pop()
            stack.push(_shared(self.state.flags))
            pipelines = super().define_pipelines()
            code = self.state.func_id.func.__code__
            if not any(isinstance(each, python_types.CodeType) for each in code.co_consts):
                for each in pipelines:
                    each.passes = [one for one in each.passes if one[0] is not InlineClosureLikes]
                    each.finalize()
            return pipelines

    return QuickCompiler


@functools.cache
def _kind_of_options() -> Any:
    from numba.core.compiler import Flags

    # All options have one hash.
    own_hash = hash(Flags())

    class Shared(Flags):
        def __hash__(self) -> int:
            return own_hash

        def __eq__(self, other: Any) -> Any:
            return self is other or super().__eq__(other)

    return Shared


_options: dict[str, Any] = {}


def _shared(flags: Any) -> Any:
    """The same options, as one object for all that are alike."""
    # Which are set counts as well, not only their values.
    key = repr(flags)
    if key not in _options:
        _options[key] = _kind_of_options()(flags)
    return _options[key]


@functools.cache
def _remembering(plain: Any) -> Any:
    """The same typing context, whose operators remember."""
    from numba.core import types

    kind = _kind_of_function()
    # By the type that numba has for an operator, which it replaces where an overload is added.
    known: dict[int, Any] = {}

    class Remembering(type(plain)):  # type: ignore[misc]
        def __init__(self) -> None:
            self.__dict__ = plain.__dict__

        def __hash__(self) -> int:
            return hash(plain)

        def __eq__(self, other: object) -> bool:
            return other is plain or other is self

        def resolve_value_type(self, val: Any) -> Any:
            function = self._known(val)
            return super().resolve_value_type(val) if function is None else function

        def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
            with _as_parts():
                return self._resolve(func, args, kws)

        def _resolve(self, func: Any, args: Any, kws: Any) -> Any:
            function = func if isinstance(func, kind) else self._known(func)
            if function is None:
                return super().resolve_function_type(func, args, kws)
            answer = None if kws else function.answers.get(tuple(args))
            if isinstance(answer, tuple):
                return function.get_call_type(self, args, kws)
            return super().resolve_function_type(function, args, kws)

        def _known(self, val: Any) -> Any:
            if type(val) is not python_types.BuiltinFunctionType or val.__module__ != "_operator":
                return None
            found = self._lookup_global(val)
            if type(found) is not types.Function:
                return None
            if id(found) not in known:
                known[id(found)] = kind(found)
            return known[id(found)]

    return Remembering()


@contextlib.contextmanager
def _as_parts() -> Iterator[None]:
    """What numba has written in Python for an array's methods and the like becomes ``parts``.

    It would make machine code of each, which only other compiled code calls.
    """
    from numba.core.target_extension import CPU, jit_registry

    plain = jit_registry[CPU]

    def within(*args: Any, **options: Any) -> Any:
        return plain(
            *args, **options, no_cfunc_wrapper=True, pipeline_class=pipeline(quick_compiler())
        )

    if getattr(plain, "makes_parts", False):
        yield
        return
    within.makes_parts = True  # type: ignore[attr-defined]
    # Who compiles holds numba's lock.
    jit_registry.update({CPU: within})
    try:
        yield
    finally:
        jit_registry.update({CPU: plain})


@functools.cache
def _kind_of_function() -> Any:
    from numba.core import types
    from numba.core.dispatcher import Dispatcher
    from numba.core.errors import TypingError

    simple = (types.Number, types.Boolean, types.Array, types.Omitted)

    def is_simple(kind: Any) -> bool:
        if isinstance(kind, types.BaseTuple):
            parts: Any = kind
            return all(map(is_simple, parts))
        return isinstance(kind, simple)

    class Remembered(types.Function):
        """An operator. ``answers`` by arguments: signature and implementation, or an error."""

        _impl_keys: dict[Any, Any]

        def __init__(self, plain: Any) -> None:
            super().__init__(plain.templates)
            self.plain, self.answers = plain, dict[Any, Any]()

        def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
            key = tuple(args)
            answer = None if kws else self.answers.get(key)
            if isinstance(answer, tuple):
                signature, implementation = answer
                self._impl_keys[signature.args] = implementation
                return signature
            if answer is not None:
                raise TypingError(answer)
            is_kept = not kws and all(map(is_simple, key))
            try:
                found: Any = super().get_call_type(context, args, kws)
            except TypingError as error:
                if is_kept:
                    self.answers[key] = str(error)
                raise
            implementation = self.get_impl_key(found)
            # What is compiled for it depends on the options.
            if is_kept and not isinstance(implementation, Dispatcher):
                self.answers[key] = found, implementation
            return found

    return Remembered
