"""Where the words of a figure stand: none off the sheet, none over another."""

from __future__ import annotations

import itertools

# Extents touch by rounding and by the empty rim of letters.
SLACK = 1.5  # px


def words_of(figure):
    """The text objects of a figure that are seen, with their boxes on the sheet [px]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    if not isinstance(figure.canvas, FigureCanvasAgg):
        FigureCanvasAgg(figure)
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    unseen = {id(label) for axes in figure.axes for label in _unseen_ticks(axes)}
    return [
        (text, text.get_window_extent(renderer))
        for text in figure.findobj(Text)
        if text.get_visible() and text.get_text().strip() and id(text) not in unseen
    ]


def _unseen_ticks(axes):
    """Ticks outside the limits keep their words but are not drawn."""
    for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        low, high = sorted(limits)
        slack = 1e-9 * (high - low)
        for tick in itertools.chain(axis.get_major_ticks(), axis.get_minor_ticks()):
            if not low - slack <= tick.get_loc() <= high + slack:
                yield from (tick.label1, tick.label2)


def faults_of(figure):
    """Sentences on words off the sheet or over one another."""
    words = words_of(figure)
    width, height = figure.bbox.width, figure.bbox.height
    faults = [
        f"{text.get_text()!r} leaves the sheet"
        for text, box in words
        if box.x0 < -SLACK or box.y0 < -SLACK or box.x1 > width + SLACK or box.y1 > height + SLACK
    ]
    for (one, a), (other, b) in itertools.combinations(words, 2):
        across = min(a.x1, b.x1) - max(a.x0, b.x0)
        along = min(a.y1, b.y1) - max(a.y0, b.y0)
        if across > SLACK and along > SLACK:
            faults.append(f"{one.get_text()!r} lies over {other.get_text()!r}")
    return faults
