"""``transient_contact``: a robot that strikes a person and both spring apart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ..design.response import impact_ellipsoid, unit_vector
from ..errors import InputError, RangeError, UnknownNameError, a_thing
from ..errors.calls import public
from ..formatting import Displayed
from ..impact.mechanics import Mechanics
from ..robot import Robot, state
from ..scene import Scene
from ..scene.numbers import keep, number, positive, text

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# [Pa] of 1 N/cm².
PER_CM2 = 1e4


@public
@dataclass(frozen=True)
class BodyRegion:
    """A region of the body: how heavy and stiff it is, and its limits.

    Attributes:
        name: of the region.
        mass: effective mass [kg].
        stiffness: effective spring constant [N/m].
        force: largest permissible quasi-static force [N].
        pressure: largest permissible quasi-static pressure, at its most sensitive place [Pa].
        transient: factor on both while a transient contact lasts; 1 where none is permitted
            beyond the quasi-static values.
        source: where the values are from.

    Raises:
        RangeError, NotFiniteError, InputError.

    Example:
        >>> forearm = BodyRegion("forearm", mass=2.0, stiffness=40e3, force=160, pressure=1.8e6)
        >>> forearm.transient
        2.0
    """

    name: str
    mass: float
    stiffness: float
    force: float
    pressure: float
    transient: float = 2.0
    source: str = "user"

    def __post_init__(self) -> None:
        text(self.name, "BodyRegion: name")
        fields = ("mass", "stiffness", "force", "pressure", "transient")
        keep(self, "BodyRegion", positive, *fields)


def _iso(
    name: str, mass: float, per_mm: float, force: float, per_cm2: float, transient: float = 2.0
) -> BodyRegion:
    pressure = per_cm2 * PER_CM2
    return BodyRegion(name, mass, 1e3 * per_mm, force, pressure, transient, SOURCE)


SOURCE = "ISO 10218-2:2025 (before: ISO/TS 15066:2016, tables A.2 and A.3)"

# Table A.3: effective mass [kg] and spring constant [N/mm]; table A.2: force [N] and the smallest
# of the region's pressures [N/cm²]. Transient contact doubles both, but at skull and face, where
# the table permits none: there the quasi-static values stand.
ISO_TS_15066: Mapping[str, BodyRegion] = MappingProxyType(
    {
        region.name: region
        for region in (
            _iso("skull", 4.4, 150.0, 130.0, 110.0, 1.0),
            _iso("face", 4.4, 75.0, 65.0, 110.0, 1.0),
            _iso("neck", 1.2, 50.0, 150.0, 140.0),
            _iso("back", 40.0, 35.0, 210.0, 160.0),
            _iso("chest", 40.0, 25.0, 140.0, 120.0),
            _iso("abdomen", 40.0, 10.0, 110.0, 140.0),
            _iso("pelvis", 40.0, 25.0, 180.0, 210.0),
            _iso("upper arm", 3.0, 30.0, 150.0, 190.0),
            _iso("forearm", 2.0, 40.0, 160.0, 180.0),
            _iso("hand", 0.6, 75.0, 140.0, 190.0),
            _iso("thigh", 75.0, 50.0, 220.0, 220.0),
            _iso("lower leg", 75.0, 60.0, 130.0, 210.0),
        )
    }
)

# Links whose speeds differ by less than this share are equally fast: the first one is named.
EQUALLY_FAST = 1e-12
# Speeds below this have no direction [m/s].
STILL = 1e-12


@public
@dataclass(frozen=True, eq=False, repr=False)
class TransientContact(Displayed):
    """A transient contact of a robot with a person, beside the limits of the body.

    The person's region is a mass on a spring that the robot's point meets: with the reduced mass
    µ = 1/(1/m_H + 1/m_R), E = ½ µ v² and F = v √(µ K) (ISO 10218-2:2025; before: ISO/TS 15066,
    A.3.4). The standard puts half the moving mass and the payload for m_R; here it is the effective
    mass 1/(n·J M⁻¹Jᵀ n) of the point at this pose.

    Attributes:
        region: the ``BodyRegion``.
        frame, at: the point of the robot that strikes.
        direction: (3,) of the strike, world axes.
        speed: of the point along it [m/s].
        robot_mass: effective mass of the robot there [kg], infinite where the point cannot give.
        reduced_mass: µ [kg].
        energy: transferred to the body [J].
        force: peak force [N].
        pressure: peak pressure [Pa]; None unless ``area`` was given.
        force_limit, pressure_limit: limits of the region in a transient contact [N, Pa].
        permitted_speed: the largest speed along the direction that keeps the limits [m/s].
        within_limits: whether force, and pressure where known, keep them.

    Example:
        >>> from impulsekit import Robot
        >>> arm = Robot.from_example("panda")
        >>> v = arm.velocity(panda_joint1=1.0)
        >>> hit = transient_contact(arm, arm.configuration(panda_joint4=-1.5), v, body="chest")
        >>> hit.force > 0
        True
    """

    answer = ("within_limits", "force", "force_limit", "speed", "permitted_speed", "frame")

    region: BodyRegion
    frame: str
    at: tuple[float, float, float]
    direction: np.ndarray
    speed: float
    robot_mass: float
    reduced_mass: float
    energy: float
    force: float
    pressure: float | None
    force_limit: float
    pressure_limit: float
    permitted_speed: float
    within_limits: bool


@public
def transient_contact(
    robot: Robot | Scene,
    q: ArrayLike,
    v: ArrayLike,
    frame: str | None = None,
    *,
    body: str | BodyRegion = "chest",
    at: ArrayLike = (0.0, 0.0, 0.0),
    direction: ArrayLike | None = None,
    area: float | None = None,
    limits: Mapping[str, BodyRegion] = ISO_TS_15066,
) -> TransientContact:
    """Return the load on a region of a person's body that a moving robot strikes and recoils from.

    Args:
        robot: the robot, or a scene whose constraints and controlled joints hold.
        q, v: (nq,), (nv,) its state.
        frame: the frame that carries the point that strikes; None for the link whose origin
            moves fastest.
        body: the name of a region of ``limits``, or a ``BodyRegion`` of your own.
        at: the point in the frame's coordinates [m].
        direction: of the strike in world axes; None for that of the point's motion.
        area: of the contact [m²], for the pressure.
        limits: regions by name; those of ISO 10218-2:2025 (before: ISO/TS 15066) unless given.

    Raises:
        UnknownNameError: no such region or frame.
        InputError: the point does not move along the direction.
        RangeError, ShapeError, NotFiniteError, StateError.

    Example:
        >>> from impulsekit import Robot
        >>> arm = Robot.from_example("panda")
        >>> v = arm.velocity(panda_joint1=1.0)
        >>> hit = transient_contact(arm, arm.configuration(panda_joint4=-1.5), v, body="chest")
        >>> hit.frame, hit.within_limits
        ('panda_link7', True)
    """
    scene = Scene(robot) if isinstance(robot, Robot) else robot
    if not isinstance(scene, Scene):
        raise InputError(f"transient_contact takes a Robot or a Scene, not {a_thing(robot)}")
    own = scene.robot
    place = state.checked_configuration(own.model, q)
    moving = state.checked_velocity(own.model, v)
    region = _region(body, limits)
    contact_area = None if area is None else number(area, "area")
    if contact_area is not None and not contact_area > 0.0:
        raise RangeError.of("area", contact_area, "above 0")
    mechanics = Mechanics(Scene(own), place)
    name = frame if frame is not None else _fastest_link(mechanics, own, moving)
    found = impact_ellipsoid(scene, place, name, at)
    velocity = mechanics.point_jacobian(name, np.array(found.at))[:3] @ moving
    n, speed = _strike(velocity, direction, name)
    mass = found.effective_mass(n)
    reduced = 1.0 / (1.0 / region.mass + 1.0 / mass)
    force = speed * math.sqrt(reduced * region.stiffness)
    force_limit, pressure_limit = (region.transient * x for x in (region.force, region.pressure))
    most = force_limit
    pressure = None
    if contact_area is not None:
        pressure = force / contact_area
        most = min(most, pressure_limit * contact_area)
    permitted = most / math.sqrt(reduced * region.stiffness)
    return TransientContact(
        region,
        name,
        found.at,
        n,
        speed,
        mass,
        reduced,
        0.5 * reduced * speed * speed,
        force,
        pressure,
        force_limit,
        pressure_limit,
        permitted,
        force <= most,
    )


def _strike(
    velocity: np.ndarray, direction: ArrayLike | None, name: str
) -> tuple[np.ndarray, float]:
    """Return the direction of the strike, and the speed along it."""
    if direction is not None:
        n = unit_vector(direction, "direction")
    elif float(np.linalg.norm(velocity)) > STILL:
        n = unit_vector(velocity / np.abs(velocity).max(), "velocity")
    else:
        raise InputError(
            f'transient_contact: the point of "{name}" does not move; give a direction and a '
            "velocity"
        )
    speed = float(n @ velocity)
    if not speed > STILL:
        raise InputError(
            f'transient_contact: the point of "{name}" moves at {speed:.3g} m/s along the '
            "direction; it must move towards the person"
        )
    n.setflags(write=False)
    return n, speed


def _region(body: str | BodyRegion, limits: Mapping[str, BodyRegion]) -> BodyRegion:
    if isinstance(body, BodyRegion):
        return body
    if not isinstance(body, str):
        raise InputError(f"body must be a name or a BodyRegion, got {a_thing(body)}")
    if body not in limits:
        raise UnknownNameError.among("region of the body", body, tuple(limits))
    region = limits[body]
    if not isinstance(region, BodyRegion):
        raise InputError(f'limits: "{body}" is {a_thing(region)}, not a BodyRegion')
    return region


def _fastest_link(mechanics: Mechanics, robot: Robot, v: np.ndarray) -> str:
    """Return the link whose origin moves fastest; of equally fast ones the first."""
    origin = np.zeros(3)
    speeds = {
        link.name: float(np.linalg.norm(mechanics.point_jacobian(link.name, origin)[:3] @ v))
        for link in robot.links
        if link.joint_id > 0
    }
    if not speeds:
        raise InputError("transient_contact: the robot has no moving link")
    most = max(speeds.values())
    return next(name for name, speed in speeds.items() if speed >= most * (1.0 - EQUALLY_FAST))
