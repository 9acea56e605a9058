"""``display``: a robot in one configuration, in a notebook, a page or a meshcat viewer."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from ..errors import check_kind
from ..errors.calls import public
from ..measured.recording import Recording
from ..robot import Robot
from ..robot.state import checked_configuration
from .replay import Replay, replay

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@public
def display(
    robot: Robot,
    q: ArrayLike | None = None,
    html: str | os.PathLike[str] | None = None,
    *,
    open: bool = False,
    viewer: Any = None,
    picture: str | os.PathLike[str] | None = None,
) -> Replay:
    """Show a robot at one configuration; a notebook shows what is returned.

    Args:
        robot: the robot.
        q: (nq,) configuration; None for the neutral one.
        html: path of a page to write.
        open: open the page in the browser; without ``html`` from a temporary file.
        viewer: a ``meshcat.Visualizer`` that is drawn into as well.
        picture: path of a PNG, drawn by a headless Chromium.

    Raises:
        ShapeError, NotFiniteError, StateError: q is not valid.
        InputError, FileError, MissingExtraError: as ``replay``.

    Example:
        >>> shown = display(Robot.from_example("panda"))
        >>> shown.duration, len(shown.nodes)
        (0.0, 9)
    """
    check_kind(robot, Robot, "display")
    place = robot.neutral() if q is None else checked_configuration(robot.model, q)
    # A recording of one instant is a still picture.
    still = Recording(robot, [0.0], place[None])
    return replay(still, html, open=open, viewer=viewer, picture=picture)
