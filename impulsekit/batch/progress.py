"""Progress of a batch: a bar with its rate, a function of the user's, or nothing."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from ..errors import InputError, quoted

__all__ = ["shown"]


@contextlib.contextmanager
def shown(progress: Any, total: int, done: int = 0) -> Iterator[Callable[[int], object]]:
    """A function that takes how many rows are done.

    Args:
        progress: None or False for nothing, True for a bar on stderr, or a function of rows
            done and rows in all.
        total: rows in all.
        done: rows done before.

    Raises:
        InputError: anything else.
    """
    if progress is None or progress is False:
        yield lambda rows: None
    elif progress is True:
        from tqdm import tqdm

        with tqdm(total=total, initial=done, unit="row", unit_scale=True) as bar:
            yield lambda rows: bar.update(rows - bar.n)
    elif callable(progress):
        yield lambda rows: progress(rows, total)
    else:
        raise InputError(
            f"progress must be True, or a function of rows done and in all, got {quoted(progress)}"
        )
