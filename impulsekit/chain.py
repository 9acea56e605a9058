"""URDFs of chains and pendulums of n uniform slender rods, written as text."""

from __future__ import annotations

import math
import operator
from typing import SupportsIndex
from xml.sax.saxutils import quoteattr

from impulsekit.errors import InputError, NotFiniteError, RangeError

from .errors.calls import public

__all__ = ["chain_urdf", "pendulum_urdf"]

# 1600 turns: a revolute joint must have limits, and these stay out of the way. The
# alternative, "continuous", would store a cosine and a sine for each angle in q.
_ANGLE_LIMIT = 1.0e4
_EFFORT_LIMIT = 1.0e9
_VELOCITY_LIMIT = 1.0e9


@public
def chain_urdf(
    links: SupportsIndex = 10,
    mass: float = 1.0,
    length: float = 1.0,
    *,
    radius: float | None = None,
    name: str = "chain",
) -> str:
    """Return the URDF of a straight chain of slender rods along +x, pinned about z.

    ``link_1`` is the root. The frame of ``link_k`` is at the rod's near end, the rod
    reaches from there to [length, 0, 0]; ``joint_k`` (k = 2..n) pins its near end to the
    far end of ``link_{k-1}``. At q = 0 the chain is straight; it bends in the xy plane,
    a positive angle turns towards +y. Give it a planar root and it is Whittaker's free
    chain (*Analytical Dynamics*, p. 175).

    The moment of inertia of a rod about its joint axis, and about the other transverse
    axis, is that of a slender rod, m l²/12 at the mass centre, whatever the radius: that
    is the chain whose exact answer is known (``impulsekit.reference.whittaker``). About
    its own axis it is m r²/2 of a solid cylinder, so that a root with six degrees of
    freedom has a regular mass matrix. The joints are revolute, free of friction, with
    limits of ±10⁴ rad that nothing reaches.

    Args:
        links: how many, at least 1.
        mass: of each rod, kg.
        length: of each rod, m.
        radius: of each rod, m, at most a tenth of the length; length / 50 unless given.
        name: of the robot in the URDF.

    Returns:
        The XML text. Every number is written so that it reads back as the same double.

    Raises:
        RangeError: fewer than 1 link, a number not positive, a rod that is not slender.
        NotFiniteError: NaN or an infinity.
        InputError: something that is no number, a name that is no printable text.

    Example:
        >>> text = chain_urdf(3, mass=0.5)
        >>> text.count("<link"), text.count("<joint")
        (3, 2)
    """
    n, m, span, r = _checked(links, mass, length, radius)
    comment = [
        f"A straight chain of {n} uniform slender rods, {m!r} kg and {span!r} m each, along +x,",
        "pinned end to end about z; SI units. The far end of the last link is [length, 0, 0].",
        "Inertia m l^2/12 about both transverse axes, m r^2/2 about the rod's own.",
        "Source: Whittaker, Analytical Dynamics, p. 175; Chang and Huston, Computers and",
        "Structures 57(3), 1995, example 1: 10 links of 1 kg and 1 m, struck at the end.",
    ]
    body = [_rod(k, m, span, r, along="x") for k in range(1, n + 1)]
    tip = f"{span!r} 0 0"
    body += [_pin(k, f"link_{k - 1}", tip, axis="0 0 1") for k in range(2, n + 1)]
    return _document(name, comment, body)


@public
def pendulum_urdf(
    links: SupportsIndex = 10,
    mass: float = 1.0,
    length: float = 1.0,
    *,
    radius: float | None = None,
    name: str = "pendulum",
) -> str:
    """Return the URDF of a chain of slender rods that hangs along -z from a fixed pin.

    The root is the massless link ``pin``; ``joint_1`` hangs the near end of ``link_1``
    from it, ``joint_k`` the near end of ``link_k`` from the far end of ``link_{k-1}``,
    which is [0, 0, -length]. All joints turn about y, so the chain swings in the xz
    plane; at q = 0 it hangs straight and at rest under gravity along -z. A positive angle
    swings a link towards -x. Meant for a fixed root: the pin has no inertia to move with.

    Rods, limits, arguments and errors are those of :func:`chain_urdf`. Source: Chang &
    Huston 1995, example 2.

    Example:
        >>> text = pendulum_urdf(2, mass=14.5939, length=0.3048)
        >>> text.count("<link"), text.count("<joint")
        (3, 2)
    """
    n, m, span, r = _checked(links, mass, length, radius)
    comment = [
        f"A chain of {n} uniform slender rods, {m!r} kg and {span!r} m each, that hangs along -z",
        "from a fixed pin, all joints about y; SI units. The far end of a link is",
        "[0, 0, -length]. Inertia m l^2/12 about both transverse axes, m r^2/2 about the",
        "rod's own. Source: Chang and Huston, Computers and Structures 57(3), 1995,",
        "example 2: 10 links of 1 slug (14.5939 kg) and 1 ft (0.3048 m), struck at the end.",
    ]
    tip = f"0 0 {-span!r}"
    body = ['  <link name="pin"/>']
    body += [_rod(k, m, span, r, along="-z") for k in range(1, n + 1)]
    body.append(_pin(1, "pin", "0 0 0", axis="0 1 0"))
    body += [_pin(k, f"link_{k - 1}", tip, axis="0 1 0") for k in range(2, n + 1)]
    return _document(name, comment, body)


def _checked(
    links: SupportsIndex, mass: float, length: float, radius: float | None
) -> tuple[int, float, float, float]:
    try:
        n = operator.index(links)
    except TypeError:
        raise InputError(f"links must be a whole number, got {links!r}") from None
    if n < 1:
        raise RangeError.of("links", n, "1 or more")
    m = _positive("mass", mass)
    span = _positive("length", length)
    r = span / 50 if radius is None else _positive("radius", radius)
    if r > span / 10:
        raise RangeError.of(
            "radius", r, f"at most a tenth of the length {span!r} (rods are slender)"
        )
    # A product of tiny or huge numbers can leave the doubles although each factor is one.
    axial, transverse = _inertias(m, span, r)
    if not (axial > 0 and math.isfinite(transverse)):
        raise RangeError.of("m l²/12", transverse, "a moment of inertia that a double can hold")
    return n, m, span, r


def _positive(what: str, value: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} must be a number, got {value!r}") from None
    if not math.isfinite(number):
        raise NotFiniteError.of("the chain", what, number)
    if number <= 0:
        raise RangeError.of(what, number, "greater than 0")
    return number


def _inertias(mass: float, length: float, radius: float) -> tuple[float, float]:
    """Axial and transverse moments of inertia at the mass centre, kg m²."""
    return mass * radius * radius / 2, mass * length * length / 12


def _rod(k: int, mass: float, length: float, radius: float, *, along: str) -> str:
    """The link ``link_k`` as a rod from its frame's origin ``along`` "x" or "-z"."""
    axial, transverse = _inertias(mass, length, radius)
    if along == "x":
        centre, turn = f"{length / 2!r} 0 0", f"0 {math.pi / 2!r} 0"  # a URDF cylinder is along z
        ixx, iyy, izz = axial, transverse, transverse
    else:
        centre, turn = f"0 0 {-length / 2!r}", "0 0 0"
        ixx, iyy, izz = transverse, transverse, axial
    shape = (
        f'      <origin xyz="{centre}" rpy="{turn}"/>\n'
        f'      <geometry><cylinder radius="{radius!r}" length="{length!r}"/></geometry>\n'
    )
    return (
        f'  <link name="link_{k}">\n'
        f"    <inertial>\n"
        f'      <origin xyz="{centre}"/>\n'
        f'      <mass value="{mass!r}"/>\n'
        f'      <inertia ixx="{ixx!r}" iyy="{iyy!r}" izz="{izz!r}" ixy="0" ixz="0" iyz="0"/>\n'
        f"    </inertial>\n"
        f"    <visual>\n{shape}    </visual>\n"
        f"    <collision>\n{shape}    </collision>\n"
        f"  </link>"
    )


def _pin(k: int, parent: str, at: str, *, axis: str) -> str:
    """The joint ``joint_k`` from ``parent`` to ``link_k``."""
    return (
        f'  <joint name="joint_{k}" type="revolute">\n'
        f'    <parent link="{parent}"/>\n'
        f'    <child link="link_{k}"/>\n'
        f'    <origin xyz="{at}"/>\n'
        f'    <axis xyz="{axis}"/>\n'
        f'    <limit lower="{-_ANGLE_LIMIT!r}" upper="{_ANGLE_LIMIT!r}"'
        f' effort="{_EFFORT_LIMIT!r}" velocity="{_VELOCITY_LIMIT!r}"/>\n'
        f"  </joint>"
    )


def _document(name: str, comment: list[str], body: list[str]) -> str:
    if not isinstance(name, str) or not name or not name.isprintable():
        raise InputError(f"name must be printable text, got {name!r}")
    head = "\n".join(f"  {line}" for line in comment)
    inside = "\n".join(body)
    return (
        f'<?xml version="1.0"?>\n<!--\n{head}\n-->\n'
        f"<robot name={quoteattr(name)}>\n{inside}\n</robot>\n"
    )
