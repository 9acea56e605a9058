"""What is a terminal; progress of long work on stderr: a bar, if that is one."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, TextIO

__all__ = ["bar_on_terminal", "is_terminal"]


def is_terminal(stream: TextIO | None) -> bool:
    """Whether somebody reads it; a stream that the caller has closed is None."""
    return stream is not None and stream.isatty()


def bar_on_terminal(unit: str) -> Callable[[int, int], None] | None:
    """A function of what is done and how much there is; None where stderr is no terminal.

    A bar closes when all is done; what is told after that begins another one.
    """
    if not is_terminal(sys.stderr):
        return None
    from tqdm import tqdm

    bars: list[Any] = []

    def tell(done: int, total: int) -> None:
        if not bars:
            bars.append(tqdm(total=total, unit=f" {unit}", leave=False))
        bars[0].update(done - bars[0].n)
        if done >= total:
            bars.pop().close()

    return tell
