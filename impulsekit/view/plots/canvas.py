"""Axes to draw on, and what all plots look like."""

from __future__ import annotations

import io
import os
from functools import partial
from typing import TYPE_CHECKING, Any

from ...errors import InputError, MissingExtraError, check_kind
from ...files import check_writable, write_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK = "#22303c"
QUIET = "#8a96a1"
BEFORE = "#8a96a1"
AFTER = "#1a6bbf"
IMPULSE = "#c8412b"
# Colours for things without an order of their own.
# Of x, y and z, as everywhere: red, green, blue.
AXES = ("#c8412b", "#2a9457", "#1a6bbf")
CYCLE = ("#1a6bbf", "#c8412b", "#2a9457", "#8a56a8", "#d9821a", "#4d8f9c", "#7a6a58")


def axes_or_new(ax: Axes | None, height: float = 4.0) -> Axes:
    """Return ``ax``, or the axes of a new figure of pyplot's.

    Raises:
        MissingExtraError: matplotlib is not installed.
        InputError: ``ax`` is no matplotlib axes.
    """
    with MissingExtraError.unless("matplotlib", "plot", "a plot"):
        from matplotlib.axes import Axes
    if ax is not None:
        check_kind(ax, Axes, "ax of a plot")
        return ax
    from matplotlib import pyplot

    _, made = pyplot.subplots(figsize=(7.0, height), layout="constrained")
    return made


def new_figure(width: float, height: float) -> Any:
    """Return a figure without a window: for a file, or a notebook, which shows it as PNG.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    with MissingExtraError.unless("matplotlib", "plot", "a plot"):
        from matplotlib.figure import Figure
    figure: Any = Figure(figsize=(width, height), layout="constrained")
    # Notebooks know figures only once pyplot has drawn one of its own.
    figure._repr_png_ = partial(drawn_as, figure, "png")
    return figure


def drawn_as(figure: Any, ending: str, **options: Any) -> bytes:
    """Return a figure as the content of a file of this format."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format=ending, **options)
    return drawn.getvalue()


def check_picture(path: str | os.PathLike[str]) -> str:
    """Return the format of a picture by its ending, once it is known that it can be written.

    Raises:
        InputError: an ending that matplotlib does not know.
        FileError: the file cannot be written.
        MissingExtraError: matplotlib is not installed.
    """
    known = new_figure(1.0, 1.0).canvas.get_supported_filetypes()
    ending = os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
    if ending not in known:
        raise InputError(
            f'plot: "{os.fspath(path)}" ends in "{ending}"; choose from {", ".join(sorted(known))}'
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
    write_file(path, drawn_as(figure, check_picture(path), **options))


def ink() -> str:
    """Return the colour of words and lines in the style that is set, light on a dark sheet."""
    import matplotlib

    return str(matplotlib.rcParams["text.color"])


def on_sheet(ax: Axes, words: list[tuple[float, float, str]]) -> None:
    """Write words beside points of the axes, on the side where they lie on nothing else.

    Words that find no place are left out: a picture with fewer names is read, one with names
    over one another is not.

    Args:
        words: x and y of each point in data coordinates, and what is written there; between
            dollars it is a formula.
    """
    if not words:
        return
    # Of a subfigure, the figure that it is a part of; a figure is its own.
    figure: Any = ax.figure
    while figure.figure is not figure:
        figure = figure.figure
    figure.draw_without_rendering()
    renderer = figure._get_renderer()
    taken = _boxes(ax, renderer)
    sheet = ax.get_window_extent(renderer)
    for x, y, text in words:
        for right, above in _SIDES:
            note = ax.annotate(
                text,
                (x, y),
                xytext=(7 * right, 9 * above),
                textcoords="offset points",
                ha={1: "left", 0: "center", -1: "right"}[right],
                va="center",
                fontsize=8,
                color=ink(),
            )
            box = note.get_window_extent(renderer)
            # An annotation is no part of the layout, which would make room for it.
            note.set_in_layout(False)
            inside = (
                box.x0 >= sheet.x0 and box.x1 <= sheet.x1
                and box.y0 >= sheet.y0 and box.y1 <= sheet.y1
            )  # fmt: skip
            if inside and not any(box.overlaps(other) for other in taken):
                taken.append(box)
                break
            note.remove()


# Letters of a name on a picture.
LONGEST_NAME = 40
# Where words may stand beside a point: right, left, above, below, and on the diagonals.
_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1),
          (1, 2), (1, -2), (-1, 2), (-1, -2))  # fmt: skip


def _boxes(ax: Axes, renderer: Any) -> list[Any]:
    """Return boxes that words must not cover: other words of these axes and their legend."""
    found = [text.get_window_extent(renderer) for text in ax.texts if text.get_visible()]
    legend = ax.get_legend()
    return [*found, *([legend.get_window_extent(renderer)] if legend else [])]


def tidy(ax: Axes) -> Axes:
    """Take away what carries no number."""
    ax.set_title(ax.get_title(loc="left"), loc="left", fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(color=QUIET, alpha=0.2, linewidth=0.7)
    ax.set_axisbelow(True)
    return ax


def plain(text: str) -> str:
    """Return a name as it is; matplotlib takes what stands between dollars for a formula.

    A long one loses its middle, or the names would leave no room for the picture.

    Example:
        >>> plain("left_hand_" * 6 + "joint")
        'left_hand_left_hand_ ... _left_hand_joint'
    """
    if len(text) > LONGEST_NAME:
        half = LONGEST_NAME // 2
        text = f"{text[:half]} ... {text[-(half - 4) :]}"
    return text.replace("$", r"\$")
