"""Functions that run as Python until compiled code is there.

``compiled`` marks a function that compiled code may call; Python calls it as it is. What
Python calls in compiled form is an ``entry``: its first calls run interpreted, at once. It is
compiled when that was asked for, or when the interpreted calls have taken longer than
compiling (or loading what was compiled before) takes.

numba divides by zero without an error, Python does not: a law must look before it divides.
"""

from __future__ import annotations

import functools
import gc
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np

from .apart import failed, raise_failed, tell_by_address
from .fingerprint import called_by
from .parts import pipeline
from .resolving import quick_compiler
from .store import Store, is_stored

__all__ = ["ENTRIES", "Entry", "compiled", "dispatcher", "entry", "use_numba"]

P = ParamSpec("P")
R = TypeVar("R")
F = TypeVar("F", bound=Callable[..., Any])

# What loading compiled code takes [s]: from disk, and where numba is not imported yet.
LOADING = 0.02
IMPORTING = 0.5
# Of calls on numbers alone, which take microseconds, one in so many is timed.
EVERY = 16
# A compilation longer than this is announced [s].
LONG = 1.0
# An error could not leave a function that is called by its address, and states would be left
# as they were: what is divided by zero is no number. Whether references are counted is not left to
# what calls first (``borrowed.borrowing``).
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": True}
# Called by compiled code alone: wrappers for Python cost more to compile than some bodies.
WITHIN: dict[str, Any] = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

# All entries of the modules that are imported, by the names of their functions.
ENTRIES: dict[str, Entry[..., Any]] = {}

_lock = threading.RLock()
_waiting: list[Callable[[], None]] = []
# numba holds its dispatchers by weak references.
_held: list[Any] = []
_ready = False


def compiled(function: F, **options: bool) -> F:
    """Let compiled code call this function. To Python it stays what it is.

    Args:
        function: of floats, integers, arrays and (named) tuples of these.
        options: of numba's ``njit``, beside those of all.

    Example:
        >>> @compiled
        ... def work(impulse: float, before: float, after: float) -> float:
        ...     return 0.5 * impulse * (before + after)
        >>> work(2.0, -1.0, 0.5)
        -0.5
    """
    chosen = {**WITHIN, **options}
    # Read by the digest of what calls it.
    vars(function)["compiled_with"] = chosen
    tell_numba(lambda: _link(function, dispatcher(function, chosen)))
    return function


def _writable(value: Any) -> Any:
    """An array that is read-only, copied, within tuples too; all else as it is."""
    if isinstance(value, np.ndarray) and not value.flags.writeable:
        return value.copy()
    if isinstance(value, tuple):
        parts = map(_writable, value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value


class Entry(Generic[P, R]):
    """A function that Python calls, compiled when it pays.

    Attributes:
        py_func: the function as Python runs it.
        compiled_with: what the code of those that call it depends on.
    """

    def __init__(
        self,
        function: Callable[P, R],
        examples: Callable[[], tuple[Any, ...]],
        seconds: float,
        apart: bool = False,
    ) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self.compiled_with = {**OPTIONS, "apart": apart}
        self._examples, self._seconds = examples, seconds
        self._spent, self._limit, self._calls = 0.0, LOADING, 0
        self._code: Callable[P, R] | None = None
        self._made: Any = None
        self._arrays: bool | None = None
        # Whether its compiled code was looked for on disk.
        self._looked = False
        if apart:
            tell_numba(lambda: tell_by_address(self, examples(), self.compile))
        else:
            tell_numba(lambda: _link(self, self._dispatcher()))
        ENTRIES[f"{function.__module__}.{function.__name__}"] = self

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Call the compiled code if it is there, else the Python function."""
        code = self._code
        if code is not None:
            try:
                result = code(*args, **kwargs)
            except TypeError:
                # Compiled code takes arrays that may be written to, as its examples are.
                result = code(*map(_writable, args), **kwargs)
            if failed:
                raise_failed()
            return result
        self._calls += 1
        if self._calls % EVERY == 0 or self._arrays is not False:
            return self._interpret(*args, **kwargs)
        try:
            return self.py_func(*args, **kwargs)
        except (ArithmeticError, ValueError):
            return self.compile()(*args, **kwargs)

    @property
    def is_compiled(self) -> bool:
        """Whether calls run compiled code."""
        return self._code is not None

    @property
    def is_stored(self) -> bool:
        """Whether compiled code of these sources is on disk."""
        return is_stored(self.py_func, repr(OPTIONS))

    def load(self, *, again: bool = False) -> None:
        """Many calls are to come: run compiled code from now on if it is on disk.

        Args:
            again: look even where it was not there the last time.
        """
        if self._code is None and (again or not self._looked):
            self._looked = True
            if self.is_stored:
                self.compile()

    def wait(self, seconds: float) -> None:
        """What it would have done took so long of this thread [s]: compile it when that pays."""
        if self._code is None:
            self._spent += seconds
            if self._spent > self._limit:
                self._weigh()

    def compile(self) -> Callable[P, R]:
        """The compiled code, compiled now or loaded from disk."""
        with _lock:
            if self._code is None:
                use_numba()
                from numba import typeof

                made = self._dispatcher()
                made.compile(tuple(typeof(example) for example in self._examples()))
                # For arguments of other types it would be compiled anew without a word.
                made.disable_compile()
                self._code = made
            return self._code

    def _dispatcher(self) -> Any:
        with _lock:
            if self._made is None:
                self._made = dispatcher(self.py_func, OPTIONS)
            return self._made

    def _interpret(self, *args: Any, **kwargs: Any) -> R:
        begin = time.thread_time()
        if self._arrays is None:
            self._arrays = _has_arrays(self._examples())
        try:
            if self._arrays:
                with np.errstate(all="ignore"):
                    result = self.py_func(*args, **kwargs)
            else:
                result = self.py_func(*args, **kwargs)
        except (ArithmeticError, ValueError):
            # Beyond what doubles hold: compiled code goes on with infinities.
            return self.compile()(*args, **kwargs)
        self._spent += (1 if self._arrays else EVERY) * (time.thread_time() - begin)
        if self._spent > self._limit:
            self._weigh()
        return result

    def _weigh(self) -> None:
        """Compile if the interpreted calls have cost as much by now."""
        cost = LOADING if _ready else IMPORTING
        within: list[Entry[..., Any]] = [self]
        within += [each for each in called_by(self.py_func) if isinstance(each, Entry)]
        for each in within:
            if not (each.is_compiled or each.is_stored):
                cost += each._seconds
        if self._spent > cost:
            self.compile()
        else:
            self._limit = min(cost, 2.0 * self._spent)


def _has_arrays(value: Any) -> bool:
    if isinstance(value, tuple):
        return any(map(_has_arrays, value))
    return isinstance(value, np.ndarray)


def entry(
    examples: Callable[[], tuple[Any, ...]], *, seconds: float, apart: bool = False
) -> Callable[[Callable[P, R]], Entry[P, R]]:
    """Make a function an ``Entry``.

    Args:
        examples: gives arguments of the types that it is compiled for.
        seconds: what compiling takes, about, without other entries that it calls.
        apart: whether compiled code that calls it does so by its address, instead of having all
            of it compiled in; it has to return int, float, bool or a tuple of these.

    Example:
        >>> @entry(lambda: (1.0, 1.0), seconds=0.1)
        ... def energy(mass: float, speed: float) -> float:
        ...     return 0.5 * mass * speed * speed
        >>> energy(2.0, 3.0), energy.is_compiled
        (9.0, False)
    """
    return lambda function: Entry(function, examples, seconds, apart)


def dispatcher(function: Callable[..., Any], options: dict[str, Any], *more: str) -> Any:
    """What numba's ``njit`` makes of a function, its code kept by ``Store``.

    Args:
        function: to be compiled, once per types of arguments.
        options: of ``njit``.
        more: other text that the code depends on.
    """
    import numba.core.config
    from numba import njit

    config: Any = numba.core.config
    chosen = quick_compiler()
    if options.get("no_cpython_wrapper") and options.get("no_cfunc_wrapper"):
        chosen = pipeline(chosen)
    # NUMBA_DISABLE_JIT is for a user's own code: njit would give the Python function.
    disabled, config.DISABLE_JIT = config.DISABLE_JIT, 0
    try:
        made = njit(**options, pipeline_class=chosen)(function)
    finally:
        config.DISABLE_JIT = disabled
    made._cache = Store(function, repr(options), *more)
    _take_literals_as_numbers(made)
    _give_up_what_fails(made)
    return made


def _give_up_what_fails(made: Any) -> None:
    """Where compiling ends with an error or an interrupt, no other process waits for it."""
    compile_now = made._compiler.compile

    def compile(args: Any, return_type: Any) -> Any:
        try:
            return compile_now(args, return_type)
        except BaseException:
            made._cache.give_up()
            raise

    made._compiler.compile = compile


def _take_literals_as_numbers(made: Any) -> None:
    """One specialization for literals and variables: numba would compile one for each."""
    from numba import types

    template = made.get_call_template

    def get_call_template(args: Any, kws: Any) -> Any:
        plain = {name: types.unliteral(kind) for name, kind in dict(kws).items()}
        return template(tuple(map(types.unliteral, args)), plain)

    made.get_call_template = get_call_template


def use_numba() -> None:
    """Import numba, and let it know the marked functions."""
    global _ready
    with _lock:
        if _ready:
            return
        import numba  # noqa: F401

        _ready = True
        _announce_long_ones()
        while _waiting:
            _waiting.pop()()


def tell_numba(tell: Callable[[], None]) -> None:
    """Tell numba of a global that compiled code reads, as soon as numba is there."""
    with _lock:
        if _ready:
            tell()
        else:
            _waiting.append(tell)


def _link(name: Any, made: Any) -> None:
    """Where compiled code reads this global, it shall find a dispatcher."""
    from numba import types
    from numba.core.registry import cpu_target

    _held.append(made)
    cpu_target.typing_context.insert_global(name, types.Dispatcher(made))


def _announce_long_ones() -> None:
    """Say in one line, once, that something is compiled if that takes long.

    Meanwhile Python looks for no cycles of garbage: numba makes millions of objects, and each
    look goes through all that were kept, which takes up to a fifth of the time.
    """
    from numba.core import event

    class Listener(event.Listener):
        depth = 0
        timer = threading.Timer(LONG, _say)
        collects = False

        def on_start(self, event: Any) -> None:
            # numba compiles one thing at a time, and what that calls within.
            self.depth += 1
            module = str(event.data["dispatcher"].py_func.__module__)
            if self.depth == 1 and module.startswith(__name__.partition(".")[0]):
                self.collects = gc.isenabled()
                gc.disable()
                self.timer = threading.Timer(LONG, _say)
                self.timer.daemon = True
                self.timer.start()

        def on_end(self, event: Any) -> None:
            self.depth -= 1
            if self.depth == 0:
                self.timer.cancel()
                if self.collects:
                    self.collects = False
                    gc.enable()

    event.register("numba:compile", Listener())


@functools.cache
def _say() -> None:
    # None where the caller has closed it.
    if sys.stderr is not None:
        sys.stderr.write("impulsekit: compiling for this machine, once per installation\n")
