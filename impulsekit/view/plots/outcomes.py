"""The outcomes that an impact leaves open, as a cloud with its hull and the laws' answers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import check_kind
from ...errors.calls import public
from ..forms import speeds_of
from .canvas import AFTER, CYCLE, QUIET, axes_or_new, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
