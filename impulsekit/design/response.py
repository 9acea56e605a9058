"""The response of a scene's robot to unit blows: effective mass, and its ellipsoid.

Δv = H Jᵀp, with the mobility H = M⁻¹ − M⁻¹Aᵀ(A M⁻¹Aᵀ)⁺A M⁻¹ under bilateral rows A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, RangeError, a_thing
from ..errors.calls import public
from ..formatting import OneLine
from ..impact import ImpactSolver
from ..impact.mechanics import Mechanics
from ..impact.singular import refuse_massless
from ..robot import Robot, state
from ..robot.arrays import lock
from ..scene import AppliedImpulse, Scene
from ..scene.driven import at_rest
from ..scene.numbers import vector

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# A vector shorter than this is a zero that was rounded, and has no direction.
NO_DIRECTION = 1e-9


class Response:
    """A robot as blows find it: its mobility, and what reaches its joints.

    Of a scene only the robot and its constraints count, at rest.
    """

    def __init__(self, what: Scene | Robot, q: Any) -> None:
        if isinstance(what, Robot):
            what = Scene(what)
        if not isinstance(what, Scene):
            raise InputError(f"expected a Scene or a Robot, got {a_thing(what)}")
        held = [at_rest(entry) for entry in what.held]
        self.robot = what.robot
        self.scene = Scene(what.robot, constraints=held, gravity=what.gravity)
        self.q = state.checked_configuration(self.robot.model, q)
        self.mechanics = Mechanics(self.scene, self.q)

    @cached_property
    def mobility(self) -> np.ndarray:
        """(nv, nv) H [1/kg, 1/(kg m), 1/(kg m²)]."""
        unit, mechanics = np.eye(self.robot.nv), self.mechanics
        if not self.scene.constraints:
            refuse_massless(self.robot, self.robot.joint_names)
            return self._loose
        free = mechanics.constrained_mass.project_out(unit).reshape(unit.shape)
        return free @ free.T

    def point_mobility(self, jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (3, 3) G = J H Jᵀ, and (3, 3) the same of the robot that nothing holds.

        G is compared with the second for rounding, which is of the size |J|²/m of what cancels.
        """
        held = jacobian @ self.mobility @ jacobian.T
        return held, jacobian @ self._loose @ jacobian.T

    @cached_property
    def _loose(self) -> np.ndarray:
        """(nv, nv) of the size of H, where no rows take anything away."""
        unit = np.eye(self.robot.nv)
        root = self.mechanics.constrained_mass.half(unit).reshape(unit.shape)
        return root @ root.T

    def point_jacobian(self, frame: str, at: Any) -> np.ndarray:
        """Return (3, nv) of a point of a frame, world axes."""
        self.robot.frame_id(frame)
        return self.mechanics.point_jacobian(frame, np.array(vector(at, "at")))[:3]

    def reaction_map(self, joint: str, frame: str, at: Any) -> np.ndarray:
        """Return (6, 6) what a joint carries of unit wrenches at a point, both in world axes."""
        place = vector(at, "at")
        still = self.robot.velocity()
        columns = []
        for unit in np.eye(6):
            blow = AppliedImpulse(frame, tuple(unit[:3]), tuple(unit[3:]), place)
            scene = replace(self.scene, impulses=[blow])
            reactions = ImpactSolver(scene).solve(self.q, still).reactions
            if joint not in reactions:
                self.robot.joint_id(joint)
            columns.append(reactions[joint])
        return np.array(columns).T


def unit_vector(given: Any, what: str) -> np.ndarray:
    """Return a direction (3,) at unit length.

    Raises:
        RangeError: it has no length.
        ShapeError, NotFiniteError: no three finite numbers.
    """
    direction = np.array(vector(given, what))
    length = float(np.linalg.norm(direction))
    if length < NO_DIRECTION:
        raise RangeError.of(f"length of {what}", length, "above zero")
    return direction / length


# Mobility this far below that of the robot when nothing holds it is rounding of what cancels:
# a point held fast leaves some 1e-16 times its condition, what moves at all rarely below 1e-9.
IMMOBILE = 1e-12


@public
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
        """Return 1/(n·G n) along a direction in world axes [kg].

        Raises:
            RangeError, ShapeError, NotFiniteError: no direction.
        """
        n = unit_vector(direction, "direction")
        mobility = float(n @ self.mobility @ n)
        return math.inf if mobility <= self.immobile else 1.0 / mobility


@public
def impact_ellipsoid(
    scene: Scene | Robot, q: ArrayLike, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)
) -> ImpactEllipsoid:
    """Return the impact ellipsoid of a point of a frame.

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


@public
def effective_mass(
    scene: Scene | Robot,
    q: ArrayLike,
    frame: str,
    direction: ArrayLike,
    at: ArrayLike = (0.0, 0.0, 0.0),
) -> float:
    """Return the effective (reflected) mass of a point along a direction in world axes [kg].

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
