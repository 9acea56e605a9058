"""The least impulse that causes a desired velocity change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, NotFiniteError, ShapeError
from ..errors.calls import public
from ..formatting import OneLine
from ..robot import Robot
from ..robot.arrays import floats, lock
from ..scene import AppliedImpulse, Scene
from .response import IMMOBILE, Response

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

RANK = 1e-10


@public
@dataclass(frozen=True, eq=False, repr=False)
class LeastBlow(OneLine):
    """The smallest impulse at a point for a desired velocity change.

    Attributes:
        blow: the ``AppliedImpulse``, linear, in world axes [N s].
        dv: (nv,) the velocity change that it causes, read-only.
        reached: (k,) the part of the desired change that it causes, read-only.
        shortfall: |desired − reached|; above 0 if no impulse at the point can cause it all.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> found = least_blow(rod, [0.0], wanted_dv=[1.0], frame="link_1", at=[0, 0, -1])
        >>> found.shortfall < 1e-12, found.impulse > 0
        (True, True)
    """

    blow: AppliedImpulse
    dv: np.ndarray
    reached: np.ndarray
    shortfall: float

    @property
    def impulse(self) -> float:
        """Its size [N s]."""
        return float(np.linalg.norm(self.blow.linear))


@public
def least_blow(
    scene: Scene | Robot,
    q: ArrayLike,
    wanted_velocity: ArrayLike | None = None,
    frame: str = "",
    at: ArrayLike = (0.0, 0.0, 0.0),
    *,
    wanted_dv: ArrayLike | None = None,
    of: str | None = None,
    of_at: ArrayLike = (0.0, 0.0, 0.0),
) -> LeastBlow:
    """Find the least linear impulse at a point for a desired velocity change.

    Args:
        scene, q: the robot, or a scene whose constraints apply, at a configuration.
        wanted_velocity: (3,) desired change of a point's velocity in world axes [m/s].
        frame, at: the struck point [m].
        wanted_dv: (nv,) desired Δv, in place of ``wanted_velocity``.
        of, of_at: the point whose velocity changes; by default the struck one.

    Raises:
        ShapeError, NotFiniteError, UnknownNameError, StateError.
        InputError: both or neither of the two is given; or the struck point, or the point
            whose velocity changes, cannot move.

    Example:
        >>> from impulsekit import Robot
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> mass = ball.model.inertias[1].mass
        >>> found = least_blow(ball, ball.neutral(), [0, 0, 2.0], "ball")
        >>> abs(found.impulse - 2.0 * mass) < 1e-12
        True
    """
    response = Response(scene, q)
    by_point = wanted_velocity is not None
    if by_point == (wanted_dv is not None):
        raise InputError(
            "least_blow needs wanted_velocity=, the change of a point's velocity, or wanted_dv=, "
            "that of all generalized velocities, and not both"
        )
    if of is not None and not by_point:
        raise InputError("least_blow: of= names the point of a wanted_velocity=, not of wanted_dv=")
    name = "wanted_velocity" if by_point else "wanted_dv"
    target = floats(wanted_velocity if by_point else wanted_dv, name)
    shape = (3,) if by_point else (response.robot.nv,)
    if target.shape != shape:
        raise ShapeError.of(name, shape, target.shape)
    if not np.isfinite(target).all():
        raise NotFiniteError.of(name, "an entry", "not finite")
    struck = response.point_jacobian(frame, at)
    _refuse_immobile(response, struck, frame, at)
    by_blow = response.mobility @ struck.T
    if not by_point:
        effect = by_blow
        weights = np.sqrt(np.diagonal(response.mechanics.mass_matrix))
    else:
        rows = struck
        if of is not None:
            rows = response.point_jacobian(of, of_at)
            _refuse_immobile(response, rows, of, of_at)
        effect = rows @ by_blow
        weights = np.ones(3)
    impulse = np.linalg.lstsq(weights[:, None] * effect, weights * target, rcond=RANK)[0]
    dv, reached = by_blow @ impulse, effect @ impulse
    shortfall = float(np.linalg.norm(target - reached))
    lock(dv, reached)
    blow = AppliedImpulse(frame, linear=tuple(impulse), at=tuple(np.asarray(at)))
    return LeastBlow(blow, dv, reached, shortfall)


def _refuse_immobile(response: Response, jacobian: np.ndarray, frame: str, at: Any) -> None:
    """Check that some blow moves a point, by the scale of the robot that nothing holds."""
    held, loose = response.point_mobility(jacobian)
    if not np.trace(held) > IMMOBILE * np.trace(loose):
        place = ", ".join(f"{float(x):g}" for x in at)
        raise InputError(
            f'least_blow: the point ({place}) of "{frame}" cannot move: the robot or the scene\'s '
            "constraints hold it fast; choose another point or take a constraint away"
        )
