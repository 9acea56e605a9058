"""How heavy a robot is to a blow at a point: effective mass, and its ellipsoid."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..display import OneLine
from ..robot import Robot
from ..robot.arrays import lock
from ..scene import Scene
from .response import Response, unit_vector

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["ImpactEllipsoid", "effective_mass", "impact_ellipsoid"]

# Mobility this far below that of the robot when nothing holds it is rounding of what cancels:
# a point held fast leaves some 1e-16 times its condition, what moves at all rarely below 1e-9.
IMMOBILE = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class ImpactEllipsoid(OneLine):
    """The mobility of a point, Δu = G p with G = J H Jᵀ, along its own axes.

    Unit impulses in all directions give velocities on the ellipsoid with half-axes 1/m_i
    (Asada 1983; Khatib 1995).

    Attributes:
        frame, at: the point.
        position: (3,) of it in the world [m], read-only.
        mobility: (3, 3) G, world axes [1/kg], read-only.
        axes: (3, 3) unit columns, the heaviest direction first, read-only.
        masses: (3,) the effective mass along each [kg], infinite where the point cannot move.
        immobile: the mobility below which a direction counts as immobile [1/kg].

    Example:
        >>> from impulsekit import Robot
        >>> panda = Robot.from_example("panda")
        >>> ellipsoid = impact_ellipsoid(panda, panda.neutral(), "panda_hand")
        >>> bool(ellipsoid.masses[0] >= ellipsoid.effective_mass([0, 0, 1]) >= ellipsoid.masses[2])
        True
    """

    frame: str
    at: tuple[float, float, float]
    position: np.ndarray
    mobility: np.ndarray
    axes: np.ndarray
    masses: np.ndarray
    immobile: float = 0.0

    def effective_mass(self, direction: ArrayLike) -> float:
        """1/(n·G n) along a direction in world axes [kg].

        Raises:
            RangeError, ShapeError, NotFiniteError: no direction.
        """
        n = unit_vector(direction, "direction")
        mobility = float(n @ self.mobility @ n)
        return math.inf if mobility <= self.immobile else 1.0 / mobility


def impact_ellipsoid(
    scene: Scene | Robot, q: ArrayLike, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)
) -> ImpactEllipsoid:
    """The impact ellipsoid of a point of a frame.

    Args:
        scene: the robot, or a scene whose constraints apply; its impulses and contacts are
            ignored.
        q: (nq,) configuration.
        frame, at: the point, in the frame's coordinates [m].

    Raises:
        UnknownNameError, ShapeError, NotFiniteError, StateError, InputError.

    Example:
        >>> from impulsekit import Robot
        >>> ball = Robot.from_urdf("models/rod.urdf", root="freeflyer")
        >>> found = impact_ellipsoid(ball, ball.neutral(), "rod")
        >>> found.masses.shape, bool(found.masses[0] >= found.masses[2])
        ((3,), True)
    """
    response = Response(scene, q)
    jacobian = response.point_jacobian(frame, at)
    mobility, loose = response.point_mobility(jacobian)
    mobility = 0.5 * (mobility + mobility.T)
    values, axes = np.linalg.eigh(mobility)
    immobile = IMMOBILE * float(np.trace(loose))
    live = values > immobile
    masses = np.where(live, 1.0 / np.where(live, values, 1.0), math.inf)
    place = response.mechanics.frame_placement(frame).act(np.array(at, dtype=float))
    arrays = place, mobility, axes, masses
    lock(*arrays)
    x, y, z = (float(entry) for entry in np.asarray(at))
    return ImpactEllipsoid(frame, (x, y, z), *arrays, immobile)


def effective_mass(
    scene: Scene | Robot,
    q: ArrayLike,
    frame: str,
    direction: ArrayLike,
    at: ArrayLike = (0.0, 0.0, 0.0),
) -> float:
    """The effective (reflected) mass of a point along a direction in world axes [kg].

    1/(n·J M⁻¹Jᵀ n), with the constraints of the scene if one is given; infinite where the
    point cannot move. Arguments and errors are those of ``impact_ellipsoid``.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))  # 1 kg, 1 m: 1/3 kg at the end
        >>> round(effective_mass(rod, [0.0], "link_1", [1, 0, 0], at=[0, 0, -1]), 12)
        0.333333333333
    """
    return impact_ellipsoid(scene, q, frame, at).effective_mass(direction)
