"""Shared by commands: exit statuses, threads, progress on stderr, files to write."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from typing import Any, TextIO

import click

BAD_INPUT = 2
OWN_FAULT = 3
# Of a command that Ctrl-C has ended, as shells have it.
INTERRUPTED = 130


def one_thread_each() -> None:
    """Linear algebra on one thread, as Pinocchio's is: matrices are small, and threads that wait
    for work take the time of processes that have some. What the user has set stays."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")


def is_terminal(stream: TextIO | None) -> bool:
    """Return whether a stream is a terminal; one that the caller has closed is None."""
    return stream is not None and stream.isatty()


def bar_on_terminal(unit: str, **options: Any) -> Callable[[float, float], None] | None:
    """A function of what is done and how much there is; None where stderr is no terminal.

    A bar closes when all is done; what is reported after that begins another one. ``options`` are
    those of tqdm.
    """
    if not is_terminal(sys.stderr):
        return None
    from tqdm import tqdm

    bars: list[Any] = []

    def show(done: float, total: float) -> None:
        if not bars:
            bars.append(tqdm(total=total, unit=f" {unit}", leave=False, **options))
        bars[0].update(done - bars[0].n)
        if done >= total:
            bars.pop().close()

    return show


json_option = click.option(
    "--json", "json_to", type=click.Path(), help='Write all results as JSON; "-": stdout.'
)


def check_outputs(*files: str | None, picture: str | None = None, **by_kind: str | None) -> None:
    """Check that files can be written; None and "-" stand for no file.

    Args:
        files: of any ending. picture: of matplotlib.
        by_kind: a page, motion, video or scene.

    Raises:
        FileError: one cannot be written.
        InputError: its ending is none of its kind's.
        MissingExtraError: a picture is asked for, and matplotlib is not installed.
    """
    from ..files import ENDINGS, check_writable, checked_output

    for file in files:
        if file not in (None, "-"):
            check_writable(str(file))
    for kind, file in by_kind.items():
        if file is not None:
            checked_output(file, kind, *ENDINGS[kind])
    if picture is not None:
        from ..view.plots.canvas import check_picture

        check_picture(picture)


def write_json(data: Any, target: str | None) -> bool:
    """Write data as JSON, if that is asked for; whether stdout is left to text.

    Raises:
        FileError: the file cannot be written.
    """
    from ..files import write_file
    from ..formatting import plain

    if target is None:
        return True
    text = json.dumps(plain(data), indent=2, allow_nan=False)
    if target != "-":
        write_file(target, text + "\n")
        return True
    click.echo(text)
    return False
