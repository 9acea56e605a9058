"""Results by name and by position; an unknown name raises an error with the nearest ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any, Protocol, SupportsIndex, TypeVar, overload

from .errors import UnknownNameError

__all__ = ["ByName", "Named"]


class HasName(Protocol):
    """A result with a name."""

    @property
    def name(self) -> str | None: ...


T = TypeVar("T")
R = TypeVar("R", bound=HasName)


class Named(tuple[R, ...]):
    """A tuple of results or entries, each with a ``name``, that can be indexed by name as well.

    One without a name is called by its place, such as "contacts[0]".

    Raises:
        UnknownNameError: on a name that no result has; a ``KeyError``, too.

    Example:
        >>> from types import SimpleNamespace
        >>> feet = Named([SimpleNamespace(name="left"), SimpleNamespace(name="right")], "contact")
        >>> feet["right"] is feet[1], "left" in feet, feet.names
        (True, True, ('left', 'right'))
    """

    kind: str

    def __new__(cls, items: Iterable[R] = (), kind: str = "entry") -> Named[R]:
        """The results, and what one of them is called in an error."""
        self = super().__new__(cls, items)
        self.kind = kind
        return self

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names, in order."""
        return tuple(item.name or f"{self.kind}s[{i}]" for i, item in enumerate(self))

    @overload
    def __getitem__(self, key: str | SupportsIndex) -> R: ...
    @overload
    def __getitem__(self, key: slice) -> Named[R]: ...
    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            found = self.get(key)
            if found is None:
                raise UnknownNameError.among(self.kind, key, self.names)
            return found
        found = super().__getitem__(key)
        return Named(found, self.kind) if isinstance(key, slice) else found

    def __contains__(self, key: object) -> bool:
        return key in self.names if isinstance(key, str) else super().__contains__(key)

    def get(self, name: str, default: Any = None) -> Any:
        """The result of a name, or ``default``."""
        names = self.names
        return self[names.index(name)] if name in names else default


class ByName(Mapping[str, T]):
    """A mapping by name that cannot be changed.

    Raises:
        UnknownNameError: on a name that is not there; a ``KeyError``, too.

    Example:
        >>> ByName({"elbow": 1.0}, "joint")["elbow"]
        1.0
    """

    def __init__(self, items: Mapping[str, T], kind: str) -> None:
        self._items = dict(items)
        self._kind = kind

    def __getitem__(self, name: str) -> T:
        try:
            return self._items[name]
        except (KeyError, TypeError):
            raise UnknownNameError.among(self._kind, str(name), self._items) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self) -> str:
        return repr(self._items)
