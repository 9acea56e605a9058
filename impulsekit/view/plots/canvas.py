"""Axes to draw on, and what all plots look like."""

from __future__ import annotations

import io
import os
from typing import TYPE_CHECKING, Any

from ...errors import InputError, MissingExtraError
from ...files import check_writable, write_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "AFTER",
    "BEFORE",
    "BLOW",
    "INK",
    "QUIET",
    "axes_or_new",
    "check_picture",
    "new_figure",
    "save_figure",
    "tidy",
]

INK = "#22303c"
QUIET = "#8a96a1"
BEFORE = "#8a96a1"
AFTER = "#1a6bbf"
BLOW = "#c8412b"
# Colours for things without an order of their own.
CYCLE = ("#1a6bbf", "#c8412b", "#2a9457", "#8a56a8", "#d9821a", "#4d8f9c", "#7a6a58")


def axes_or_new(ax: Axes | None, height: float = 4.0) -> Axes:
    """``ax``, or the axes of a new figure of pyplot's.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError:
        raise MissingExtraError.of("matplotlib", "plot", "a plot") from None
    _, made = pyplot.subplots(figsize=(7.0, height), layout="constrained")
    return made


def new_figure(width: float, height: float) -> Any:
    """A figure that belongs to no window, for writing to a file.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError.of("matplotlib", "plot", "a plot") from None
    return Figure(figsize=(width, height), layout="constrained")


def check_picture(path: str | os.PathLike[str]) -> str:
    """The format of a picture by its ending, once it is known that it can be written.

    Raises:
        InputError: an ending that matplotlib does not know.
        FileError: the file cannot be written.
        MissingExtraError: matplotlib is not installed.
    """
    known = new_figure(1.0, 1.0).canvas.get_supported_filetypes()
    ending = os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
    if ending not in known:
        raise InputError(
            f'plot: "{os.fspath(path)}" ends in "{ending}"; known are {", ".join(sorted(known))}'
        )
    check_writable(path)
    return ending


def save_figure(figure: Any, path: str | os.PathLike[str], **options: Any) -> None:
    """Draw a figure into a file, in the format that its ending says.

    Args:
        options: of matplotlib's ``savefig``.

    Raises:
        InputError, FileError: as ``check_picture``.
    """
    drawn = io.BytesIO()
    figure.savefig(drawn, format=check_picture(path), **options)
    write_file(path, drawn.getvalue())


def tidy(ax: Axes) -> Axes:
    """Take away what carries no number."""
    ax.set_title(ax.get_title(loc="left"), loc="left", fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(color=QUIET, alpha=0.2, linewidth=0.7)
    ax.set_axisbelow(True)
    return ax


def plain(text: str) -> str:
    """A name as it is: matplotlib would take what stands between dollars for a formula."""
    return text.replace("$", r"\$")
