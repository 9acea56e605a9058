"""``public``: wrong arguments of a call raise impulsekit's own error, with the nearest name."""

from __future__ import annotations

import functools
import inspect
import types
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from . import InputError, UnknownNameError
from .wording import one_of, shown

T = TypeVar("T", bound=Callable[..., Any])

# What textbooks and other programs call an argument.
SYNONYMS = {
    "mu": ("friction",), "e": ("restitution",), "kp": ("stiffness",), "kd": ("damping",),
    "force": ("linear",), "torque": ("angular",), "quaternion": ("xyzw", "wxyz"),
}  # fmt: skip


def public(thing: T) -> T:
    """Return a function, or a class with its methods, that names what is wrong in a call of it.

    Decorate every public function and class. Arguments that do not fit its parameters raise
    ``InputError``, unknown ones ``UnknownNameError``; what is raised within passes unchanged.

    Example:
        >>> @public
        ... def strike(link, *, speed=1.0):
        ...     return speed
        >>> try:
        ...     strike("hand", sped=2.0)
        ... except UnknownNameError as error:
        ...     print(error)
        strike: unknown argument "sped"; did you mean "speed"?
    """
    if not isinstance(thing, type):
        return _guarded(thing)
    package = __name__.partition(".")[0]
    for kind in thing.__mro__:
        if kind.__module__.partition(".")[0] == package:
            _guard_methods(kind)
    return thing


def _guard_methods(kind: type) -> None:
    for name, member in list(vars(kind).items()):
        if name.startswith("_") and name not in ("__init__", "__call__"):
            continue
        function = getattr(member, "__func__", member)
        if not isinstance(function, types.FunctionType) or hasattr(function, "is_public"):
            continue
        guarded = _guarded(function, in_class=True)
        setattr(kind, name, guarded if member is function else type(member)(guarded))


def _guarded(function: Any, *, in_class: bool = False) -> Any:
    @functools.wraps(function)
    def called(*args: Any, **named: Any) -> Any:
        try:
            return function(*args, **named)
        except TypeError:
            wrong = _wrong_call(function, args, named, in_class=in_class)
            if wrong is None:
                raise
        raise wrong

    called.is_public = True  # type: ignore[attr-defined]
    return called


def _wrong_call(
    function: Any, args: tuple[Any, ...], named: Mapping[str, Any], *, in_class: bool
) -> InputError | None:
    """The error on arguments that do not fit; None where they do, and what ran has raised."""
    signature = inspect.signature(function)
    try:
        signature.bind(*args, **named)
        return None
    except TypeError as unbound:
        reason = _in_words(str(unbound))
    where = function.__name__
    if where == "__init__" and args:
        where = type(args[0]).__name__
    known = _names(signature)[1 if in_class else 0 :]
    for name in named:
        if name not in known:
            hint = ""
            if args and name in getattr(type(args[0]), "__dataclass_fields__", ()):
                kind = type(args[0]).__name__
                hint = f"it belongs to the {kind}: {kind.lower()}.replace({name}=...)"
            elif meant := [one for one in SYNONYMS.get(name, ()) if one in known]:
                hint = f"did you mean {one_of(meant)}?"
            return UnknownNameError.among("argument", name, known, where, hint)
    takes = ", ".join(known) if known else "no arguments"
    return InputError(f"{where}: {shown(reason, 200)}; it takes {takes}")


def _in_words(reason: str) -> str:
    """Return the sentence of ``inspect`` on arguments that do not fit, in the caller's words."""
    name = reason.rpartition("'")[0].rpartition("'")[2]
    if "missing" in reason:
        return f'argument "{name}" is missing'
    if "multiple values" in reason:
        return f'argument "{name}" is given twice'
    return "too many arguments" if "too many" in reason else reason


def _names(signature: inspect.Signature) -> list[str]:
    """The names of arguments that can be given."""
    return [
        name
        for name, parameter in signature.parameters.items()
        if parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
        and not name.startswith("_")
    ]
