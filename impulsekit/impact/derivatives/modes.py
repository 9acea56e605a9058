"""The mode in which each contact point was found, and whether it is on its edge.

parted: P = 0. sliding: ξ_n = 0, P_t = −µ P_n s with s = ξ_t/|ξ_t|. sticking: ξ = 0. Under
Poisson's law the expansion may hold P_n at e P_n^c instead of ξ_n at 0 (held). ξ is the
velocity after, shifted by restitution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...scene.coefficients import Restitution, RestitutionTable, restitution_at
from ...scene.functions import call

__all__ = ["EDGE", "PARTED", "Coefficients", "ContactMode", "coefficients_of", "found_mode"]

# A contact that slips has its impulse on the cone, to this share of its bound.
SLIPS_ON_CONE = 1e-6
# What is this small beside the velocities of the contacts is on an edge.
EDGE = 1e-7
# The step of differences in the slope of a function, beside the velocities.
STEP = 1e-3
# An impulse that could move this much faster than anything moves is held up by nothing.
OUT_OF_PROPORTION = 1e7


class Coefficients(NamedTuple):
    """The coefficients of one contact at its approach speed.

    Attributes:
        e, slope: restitution and de/d(approach speed).
        mu, e_t: friction and tangential restitution.
        approach: −u_n⁻ [m/s], 0 where it was not approaching.
        edge: why the restitution has a corner here; "" where it has none.
        differenced: whether the slope was found by differences.
    """

    e: float
    slope: float
    mu: float
    e_t: float
    approach: float
    edge: str
    differenced: bool


class ContactMode(NamedTuple):
    """The mode of one contact point in one stage of an impact.

    Attributes:
        parted, sticking, held: booleans; sliding is what is neither parted nor sticking.
        slip: (2,) s, zeros where nothing slips.
        resistance: µ P_n/|ξ_t| [kg], how the impulse of friction turns with the slip.
        normal_impulse: P_n [N s].
        compressed: P_n^c of the compression [N s], where P_n is held.
        mu: µ.
        edges: reasons for which a small change may end the mode.
    """

    parted: bool
    sticking: bool
    held: bool
    slip: np.ndarray
    resistance: float
    normal_impulse: float
    compressed: float
    mu: float
    edges: tuple[str, ...]


PARTED = ContactMode(True, False, False, np.zeros(2), 0.0, 0.0, 0.0, 0.0, ())


def coefficients_of(entry: object, normal_before: float, scale: float, name: str) -> Coefficients:
    """The coefficients at the normal velocity before [m/s].

    Raises:
        InputError: the slope that the restitution itself gives is no number.
        RangeError, NotFiniteError: a restitution function gave something else than 0 to 1.
    """
    value = getattr(entry, "restitution", 0.0)
    approach = max(-normal_before, 0.0)
    e = restitution_at(value, approach, name)
    slope, edge, differenced = 0.0, "", False
    if normal_before > EDGE * scale:
        # What parts has an approach speed of zero, here and nearby.
        pass
    elif isinstance(value, RestitutionTable):
        slope = _slope(value, approach)
        if len(value.speeds) > 1 and np.abs(np.array(value.speeds) - approach).min() < EDGE * scale:
            edge = "its approach speed is at a point of its restitution table"
    elif isinstance(value, Restitution):
        if value.capture_speed and abs(approach - value.capture_speed) < EDGE * scale:
            edge = "its approach speed is at the capture speed"
    elif callable(value):
        slope, differenced = _slope_of_function(value, approach, scale, name)
    if (e > 0.0 or slope) and abs(normal_before) <= EDGE * scale:
        edge = edge or "it hardly approaches, where restitution sets in"
    return Coefficients(
        e,
        slope,
        getattr(entry, "friction", 0.0),
        getattr(entry, "tangential_restitution", 0.0),
        approach,
        edge,
        differenced,
    )


def _slope_of_function(
    function: Callable[[float], float], speed: float, scale: float, name: str
) -> tuple[float, bool]:
    """de/d(speed) of a function: its own ``derivative``, or differences; which of the two."""
    own = getattr(function, "derivative", None)
    if callable(own):
        slope = call(own, f"{name}: derivative", speed)
        if not isinstance(slope, int | float | np.floating) or not math.isfinite(slope):
            raise InputError(f"{name}: the derivative of its restitution is {slope!r}, no number")
        return float(slope), False
    # Richardson's extrapolation of central differences: of fourth order.
    step = min(STEP * max(speed, scale), 0.5 * speed)
    if step <= 0.0:
        return 0.0, True
    coarse, fine = (
        (restitution_at(function, speed + h, name) - restitution_at(function, speed - h, name))
        / (2.0 * h)
        for h in (step, 0.5 * step)
    )
    return (4.0 * fine - coarse) / 3.0, True


def _slope(table: RestitutionTable, speed: float) -> float:
    """de/d(speed) of the piece that the speed lies in."""
    speeds, values = table.speeds, table.values
    if not speeds[0] <= speed < speeds[-1]:
        return 0.0
    i = int(np.searchsorted(speeds, speed, side="right")) - 1
    return (values[i + 1] - values[i]) / (speeds[i + 1] - speeds[i])


def found_mode(
    impulse: np.ndarray,
    shifted: np.ndarray,
    mu: float,
    own: np.ndarray,
    scale: float,
    name: str,
    e: float = 0.0,
    compressed: float = 0.0,
) -> ContactMode:
    """The mode of a point with impulse P (3,) and ξ (3,).

    Args:
        own: (3,) the diagonal of its W [1/kg], which turns impulses into velocities.
        scale: the size of the velocities [m/s].
        e, compressed: in an expansion, e and P_n^c, which hold P_n at e P_n^c or above.
    """
    small = EDGE * scale
    p1, p2, normal = impulse.tolist()
    x1, x2, lift = shifted.tolist()
    m1, m2, mobility = own.tolist()
    tangential, speed = math.hypot(p1, p2), math.hypot(x1, x2)
    edges: list[str] = []
    held = False
    if mobility * (normal - e * compressed) <= small:
        held = compressed > 0.0
        # Without restitution nothing expands, and the velocity stays at zero.
        clear = lift > small or (held and e == 0.0)
        if not clear:
            edges.append(f"{name}: it hardly presses and hardly parts")
        if not held and (clear or normal <= 0.0):
            return ContactMode(True, False, False, np.zeros(2), 0.0, 0.0, 0.0, mu, tuple(edges))
    sticking = mu > 0.0 and speed <= small
    if sticking and max(m1, m2) * (mu * normal - tangential) <= small and not held:
        edges.append(f"{name}: it sticks with its impulse at the edge of the cone")
    if mu > 0.0 and not sticking and mu * normal - tangential > SLIPS_ON_CONE * mu * normal:
        edges.append(f"{name}: it hardly slips")
    if mobility * normal > OUT_OF_PROPORTION * scale:
        edges.append(f"{name}: its impulse is out of all proportion to what it moves")
    direction = np.array((x1 / speed, x2 / speed)) if speed > small else np.zeros(2)
    resistance = mu * normal / speed if speed > small else 0.0
    return ContactMode(
        False, sticking, held, direction, resistance, normal, compressed, mu, tuple(edges)
    )
