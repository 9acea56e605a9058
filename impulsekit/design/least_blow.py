"""The blow that gives a wanted velocity change with the least impulse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import NotFiniteError, ShapeError
from ..robot import Robot
from ..scene import AppliedImpulse, Scene
from .response import Response

__all__ = ["LeastBlow", "least_blow"]

RANK = 1e-10


@dataclass(frozen=True, eq=False)
class LeastBlow:
    """A blow at a point.

    Attributes:
        blow: ready for a scene; linear, in world axes [N s].
        dv: (nv,) the velocity change that it gives, read-only.
        reached: (k,) of what was wanted, what it gives, read-only.
        shortfall: |wanted − reached|; not 0 where a blow there cannot do it.
    """

    blow: AppliedImpulse
    dv: np.ndarray
    reached: np.ndarray
    shortfall: float

    @property
    def impulse(self) -> float:
        """Its size [N s]."""
        return float(np.linalg.norm(self.blow.linear))


def least_blow(
    scene: Scene | Robot,
    q: Any,
    wanted: Any,
    frame: str,
    at: Any = (0.0, 0.0, 0.0),
    *,
    of: str | None = None,
    of_at: Any = (0.0, 0.0, 0.0),
) -> LeastBlow:
    """The least linear impulse at a point that comes nearest to a wanted velocity change.

    Args:
        scene, q: the robot, or a scene whose constraints hold it, at a configuration.
        wanted: (3,) Δ of a point's velocity in world axes [m/s], or (nv,) Δv.
        frame, at: the point that is struck [m].
        of, of_at: the point whose velocity is meant; the struck one unless given.

    Raises:
        ShapeError, NotFiniteError, UnknownNameError, StateError, InputError.

    Example:
        >>> from impulsekit import Robot
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> mass = ball.model.inertias[1].mass
        >>> found = least_blow(ball, ball.neutral(), [0, 0, 2.0], "ball")
        >>> abs(found.impulse - 2.0 * mass) < 1e-12
        True
    """
    response = Response(scene, q)
    target = np.array(wanted, dtype=float)
    nv = response.robot.nv
    if target.shape not in ((3,), (nv,)):
        raise ShapeError.of("wanted", (3,), target.shape)
    if not np.isfinite(target).all():
        raise NotFiniteError.of("wanted", "an entry", "not finite")
    struck = response.point_jacobian(frame, at)
    by_blow = response.mobility @ struck.T
    if target.shape == (nv,) and (nv != 3 or of is None):
        effect = by_blow
        weights = np.sqrt(np.diagonal(response.mechanics.mass_matrix))
    else:
        rows = struck if of is None else response.point_jacobian(of, of_at)
        effect = rows @ by_blow
        weights = np.ones(3)
    impulse = np.linalg.lstsq(weights[:, None] * effect, weights * target, rcond=RANK)[0]
    dv, reached = by_blow @ impulse, effect @ impulse
    shortfall = float(np.linalg.norm(target - reached))
    dv.setflags(write=False)
    reached.setflags(write=False)
    blow = AppliedImpulse(frame, linear=tuple(impulse), at=tuple(at))
    return LeastBlow(blow, dv, reached, shortfall)
