"""The display of results in a notebook, by rooms that the package's face names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .one_line import OneLine

__all__ = ["Displayed", "show_with"]

_shown: list[Callable[[Any], str]] = []


def show_with(html_of: Callable[[Any], str]) -> None:
    """Have notebooks show results by a function that gives valid HTML of one."""
    _shown[:] = [html_of]


class Displayed(OneLine):
    """A result that a notebook shows as tables, or as a interactive replay."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return _shown[0](self)
