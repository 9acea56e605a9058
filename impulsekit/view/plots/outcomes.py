"""Plots of the outcomes of an impact: their cloud with its hull, and the spread of a quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import check_kind
from ...errors.calls import public
from ..forms import speeds_of
from .canvas import AFTER, CYCLE, QUIET, axes_or_new, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...design import Distribution
    from ...impact import Outcomes


@public
def outcome_cloud(outcomes: Outcomes, x: int = 0, y: int = 1, ax: Axes | None = None) -> Axes:
    """Draw two entries of v⁺ of all outcomes, their hull, and the answers of the laws.

    Args:
        outcomes: of an impact. x, y: entries of v. ax: where to draw; a new figure if None.

    Raises:
        InputError: no ``Outcomes``. RangeError: an entry that v does not have.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, outcomes
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", at=[0, 0, -0.1])], gap_bound=1)
        >>> found = outcomes(scene, ball.neutral(), [1, 0, -2, 0, 0, 0], samples=16)
        >>> outcome_cloud(found, 0, 2).get_xlabel()
        'root_joint vx [m/s]'
    """
    from ...impact import Outcomes as SomeOutcomes

    check_kind(outcomes, SomeOutcomes, "outcome_cloud")
    corners = outcomes.hull([x, y])
    ax = axes_or_new(ax)
    cloud = outcomes.velocities_after
    ax.plot(cloud[:, x], cloud[:, y], ".", color=QUIET, markersize=2, label="outcomes")
    ring = np.vstack([corners, corners[:1]])
    ax.plot(ring[:, 0], ring[:, 1], color=AFTER, linewidth=1.2, label="hull")
    for k, (name, v) in enumerate(outcomes.laws.items()):
        ax.plot(v[x], v[y], "oD^svP"[k % 6], color=CYCLE[k % len(CYCLE)], label=name)
    speeds = speeds_of(outcomes.impact.scene.robot, outcomes.impact.q)
    ax.set_xlabel(plain(f"{speeds[x].title} [{speeds[x].unit}]"))
    ax.set_ylabel(plain(f"{speeds[y].title} [{speeds[y].unit}]"))
    ax.legend(frameon=False)
    return tidy(ax)


@public
def spread(distribution: Distribution, label: str = "", ax: Axes | None = None) -> Axes:
    """Draw the share of samples up to each value, of all and of each sequence, with quantiles.

    Args:
        distribution: of a quantity. label: its name and unit. ax: where to draw; a new figure if
            None.

    Raises:
        InputError: no ``Distribution``. MissingExtraError: matplotlib is not installed.

    Example:
        >>> import numpy as np
        >>> from impulsekit.design import Distribution
        >>> found = Distribution(np.random.default_rng(0).normal(size=(8, 64)), 0)
        >>> spread(found, "load [N s]").get_ylabel()
        'share of samples'
    """
    from ...design import Distribution as SomeDistribution

    check_kind(distribution, SomeDistribution, "spread")
    ax = axes_or_new(ax)
    for row in distribution.values:
        own = np.sort(row[~np.isnan(row)])
        ax.plot(own, (np.arange(len(own)) + 0.5) / len(own), color=QUIET, linewidth=0.5)
    every = np.sort(distribution.values[~np.isnan(distribution.values)])
    ax.plot(every, (np.arange(len(every)) + 0.5) / len(every), color=AFTER)
    for share in (0.05, 0.5, 0.95):
        value = distribution.quantile(share)
        ax.axvline(value, color=CYCLE[1], linewidth=0.8, linestyle="--")
        ax.annotate(f"{100 * share:g} %: {value:.3g}", (value, share), fontsize="small")
    ax.set_xlabel(plain(label))
    ax.set_ylabel("share of samples")
    return tidy(ax)
