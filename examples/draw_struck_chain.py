"""Draw the velocities in a chain of ten rods an instant after its end is struck.

The numbers are the exact ones of Whittaker's chain (*Analytical Dynamics*, p. 175), which
are those of Table 1 of Chang & Huston 1995. Needs matplotlib: pip install ".[plot]".

    python examples/draw_struck_chain.py [OUTPUT]        # struck_chain.svg beside this file
"""

import argparse
import math
from pathlib import Path

import matplotlib

matplotlib.use("svg")

from matplotlib import pyplot as plt
from matplotlib.patches import FancyArrowPatch
from matplotlib.ticker import FixedLocator, NullLocator

from impulsekit.reference.whittaker import struck_chain

LINKS, MASS, LENGTH, BLOW = 10, 1, 1, 5  # kg, m, N s, as in the paper

INK = "#22303c"
QUIET = "#7b8894"
WITH = "#c8412b"  # along the blow
AGAINST = "#2b6cb0"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    beside = Path(__file__).with_name("struck_chain.svg")
    parser.add_argument("output", nargs="?", type=Path, default=beside, help="SVG or PNG")
    output = parser.parse_args().output

    blow = struck_chain(LINKS, MASS, LENGTH, BLOW)
    u = [float(velocity) for velocity in blow.point_velocities]
    x = [k * LENGTH for k in range(LINKS + 1)]

    # Same input, same bytes: fixed ids in the SVG, and no date.
    style = {
        "svg.hashsalt": "struck chain",
        "font.family": "DejaVu Sans",
        "font.size": 10,
        "text.color": INK,
        "axes.edgecolor": QUIET,
        "axes.labelcolor": INK,
        "xtick.color": INK,
        "ytick.color": INK,
    }
    with plt.rc_context(style):
        figure, (top, bottom) = plt.subplots(
            2, 1, figsize=(9, 6.4), height_ratios=[1.55, 1], sharex=True, layout="constrained"
        )
        draw_motion(top, x, u)
        draw_magnitudes(bottom, x, u)
        figure.align_ylabels()
        metadata = {"Date": None} if output.suffix == ".svg" else None
        figure.savefig(output, metadata=metadata, dpi=110)


def draw_motion(axes, x: list[float], u: list[float]) -> None:
    """The straight chain, and the velocity of each point as an arrow to scale."""
    # A rod is rigid, so between two pins the velocity runs in a straight line.
    axes.fill_between(x, u, color=QUIET, alpha=0.13, linewidth=0)
    axes.plot(x, u, color=QUIET, linewidth=1, linestyle=(0, (4, 2)))
    axes.plot(x, [0] * len(x), color=INK, linewidth=5, solid_capstyle="round", zorder=3)
    for point, velocity in zip(x, u, strict=True):
        if abs(velocity) < 0.5:
            continue  # shorter than an arrowhead; the lower half shows it
        colour = WITH if velocity > 0 else AGAINST
        axes.add_patch(
            FancyArrowPatch(
                (point, 0),
                (point, velocity),
                arrowstyle="-|>",
                mutation_scale=min(15, 7 * abs(velocity)),
                linewidth=2.4,
                color=colour,
                shrinkA=0,
                shrinkB=0,
                zorder=4,
            )
        )
        side = 1 if velocity > 0 else -1
        axes.annotate(
            f"{velocity:+.3f}".replace("-", "−"),
            (point, velocity),
            xytext=(10, 2 * side),
            textcoords="offset points",
            va="bottom" if velocity > 0 else "top",
            color=colour,
            fontweight="bold",
        )
    axes.plot(x, [0] * len(x), "o", color="white", markeredgecolor=INK, markersize=6, zorder=3.5)
    axes.annotate(
        f"blow {BLOW} N s",
        (x[0], -0.6),
        xytext=(x[0], -7.6),
        ha="center",
        va="top",
        fontweight="bold",
        arrowprops={
            "arrowstyle": "simple,head_length=0.8,head_width=1.1,tail_width=0.4",
            "color": INK,
        },
    )
    axes.text(
        x[-1],
        16.6,
        f"{LINKS} pinned rods, {MASS} kg and {LENGTH} m each,\nfree and at rest, struck at the end",
        ha="right",
        va="top",
        linespacing=1.5,
        fontsize=11,
    )
    axes.text(4.05, 1.3, "dashed: velocity along the rods, right after the blow", color=QUIET)
    axes.set_ylabel("velocity [m/s]")
    axes.set_xlim(-0.75, LINKS * LENGTH + 1)
    axes.set_ylim(-10, 19.5)
    axes.yaxis.set_major_locator(FixedLocator([-5, 0, 5, 10, 15]))
    axes.spines[["top", "right", "bottom"]].set_visible(False)
    axes.tick_params(bottom=False)


def draw_magnitudes(axes, x: list[float], u: list[float]) -> None:
    """The size of each velocity on a logarithmic scale, its sign as the colour."""
    # Points and no bars: on a logarithmic axis a bar has no foot to be measured from.
    axes.plot(x, [abs(v) for v in u], color=QUIET, linewidth=1, linestyle=(0, (1, 2)), zorder=1)
    for sign, colour, label in ((1, WITH, "along the blow"), (-1, AGAINST, "against it")):
        at, speed = zip(
            *((p, abs(v)) for p, v in zip(x, u, strict=True) if v * sign > 0), strict=True
        )
        marker = "^" if sign > 0 else "v"
        axes.plot(at, speed, marker, color=colour, markersize=9, linestyle="", label=label)
        for p, s in zip(at, speed, strict=True):
            text = f"{s:.{1 - math.floor(math.log10(s))}f}" if s < 10 else f"{s:.0f}"
            axes.annotate(
                text,
                (p, s),
                xytext=(8, 3),
                textcoords="offset points",
                fontsize=9,
                color=colour,
            )
    note = (
        "the ratio of neighbours tends to 2 − √3 = 0.268;\n"
        "the free far end has half its neighbour's speed"
    )
    axes.text(0, 2.2e-5, note, color=QUIET, va="bottom", linespacing=1.4)
    axes.set_yscale("log")
    axes.set_ylim(1e-5, 200)
    axes.yaxis.set_major_locator(FixedLocator([10.0**k for k in range(-5, 3)]))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color=QUIET, alpha=0.18, linewidth=0.8)
    axes.set_ylabel("speed [m/s], log scale")
    axes.set_xlabel("distance from the struck end [m]")
    axes.set_xticks(x)
    axes.legend(loc="upper right", frameon=False, ncols=2)
    axes.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    main()
