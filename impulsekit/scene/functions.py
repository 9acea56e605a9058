"""Functions that users give: called with copies, and their results checked."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from ..errors import CallbackError, NotFiniteError, ShapeError, a_thing, shown
from ..robot.arrays import FLOAT, read_only

T = TypeVar("T")


def call(function: Callable[..., Any], what: str | Callable[[], str], *arguments: Any) -> Any:
    """Return the result of a user's function. Arrays among its arguments are read-only copies.

    Args:
        function: the user's.
        what: the entry and the field, for errors; or a function that returns them.
        *arguments: of the function.

    Raises:
        CallbackError: the function raised an exception, which is the cause.
    """
    own = [read_only(x.copy()) if isinstance(x, np.ndarray) else x for x in arguments]
    try:
        return function(*own)
    except Exception as error:
        what = _said(what)
        raise CallbackError(
            f"{what}: its function raised {type(error).__name__}: {shown(str(error), 200)}",
            entry=what,
            from_function=True,
        ) from error


def let_through(run: Callable[[], T], time: Callable[[], float]) -> T:
    """Run a motion; what a user's function raises in it comes out as it was raised.

    Args:
        run: the motion.
        time: the time that it has reached [s], for the note that the exception gets.
    """
    try:
        return run()
    except CallbackError as error:
        own = of_function(error, time())
    # Outside of the handler: the exception keeps its own context and cause.
    raise own


def of_function(error: CallbackError, time: float) -> BaseException:
    """Return what a user's function raised in a motion, with a note, or the error if it did not.

    Args:
        time: the time that the motion has reached [s].
    """
    own = error.__cause__
    if own is None:
        return error
    own.add_note(f"raised in {error.entry}, in the step of the motion from t = {time:g} s")
    return own


def numbers_from(
    function: Callable[..., Any],
    what: str | Callable[[], str],
    size: int,
    *arguments: Any,
    infinite: bool = False,
) -> np.ndarray:
    """Return (size,) the numbers that a user's function gives; one alone stands for (1,).

    Args:
        function: the user's.
        what: the entry and the field, for errors; or a function that returns them.
        size: how many numbers are expected.
        *arguments: of the function.
        infinite: whether infinite ones may pass.

    Raises:
        CallbackError: it raised an exception, or gave something else than real numbers.
        ShapeError: it gave another number of them.
        NotFiniteError: it gave NaN, or an infinity.
    """
    given = call(function, what, *arguments)
    try:
        array = np.asarray(given)
        if array.dtype.kind == "O" and not _holds_no_numbers(array):
            array = array.astype(float)
    except Exception:
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        what = _said(what)
        thing = "complex numbers" if array.dtype.kind == "c" else a_thing(given)
        raise CallbackError(
            f"{what}: its function gave {thing} ({shown(given)}), expected real numbers",
            entry=what,
            from_function=True,
        )
    if type(given) not in (tuple, list) or array.ndim == 0 or array.dtype is not FLOAT:
        array = np.array(array, dtype=float, ndmin=1)
    if array.shape != (size,):
        what = _said(what)
        raise _of_function(ShapeError.of(what, (size,), array.shape), what)
    # One number that is not finite makes the sum so, too.
    if math.isfinite(sum(array.tolist())):
        return array
    bad = np.isnan(array) if infinite else ~np.isfinite(array)
    if bad.any():
        first, what = int(np.argmax(bad)), _said(what)
        raise _of_function(NotFiniteError.of(what, f"entry {first}", array[first]), what)
    return array


def _said(what: str | Callable[[], str]) -> str:
    return what() if callable(what) else what


def _holds_no_numbers(array: np.ndarray) -> bool:
    return any(isinstance(entry, str | bytes | bool | None) for entry in array.flat)


def _of_function(error: Any, what: str) -> Any:
    """The error, with the entry whose function it comes from."""
    error.entry, error.from_function = what, True
    return error
