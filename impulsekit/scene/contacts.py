"""Unilateral contacts: a point on a plane, a joint at its stop, two bodies that collide."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import InitVar, dataclass
from dataclasses import field as a_field
from typing import Any, Literal

import numpy as np

from ..errors import InputError, RangeError
from ..robot import Robot
from .coefficients import (
    ByTable,
    Friction,
    checked_friction,
    checked_restitution,
    is_by_material,
    is_plain,
    keep_from_table,
)
from .numbers import (
    Vector,
    between,
    check_name,
    keep,
    not_negative,
    number,
    optional,
    positive,
    text,
    vector,
)
from .validation import Acting, InJoint

# A direction whose length is this near to 1 is left as it is given: dividing would only round it.
UNIT = 1e-15

# Longer or shorter normals are taken for a mistake, not for a direction.
SHORTEST_NORMAL = 1e-9


@dataclass(frozen=True)
class Contact(Acting):
    """A contact of a point of a frame with a plane fixed in the world or in another frame.

    In ``solve`` it counts as touching whatever its gap. The impulse is the one that
    ``frame`` receives. In ``simulate`` the point is fixed on its body: for a body that rolls, or
    touches the plane at other points too, use a ``Collision``.

    Attributes:
        frame: the frame that carries the point.
        at: the point in the frame's coordinates [m].
        normal: of the plane, in the coordinates of ``against``; from ``against`` to
            ``frame``. Kept at unit length.
        origin: a point of the plane in the coordinates of ``against`` [m].
        against: the frame that carries the plane; "world" is the fixed one.
        restitution: of the normal velocity: 0 to 1, a ``Restitution``, a
            ``RestitutionTable``, or a function of the approach speed [m/s]; "material" for that
            of the pair in ``Scene.materials``, as for ``friction``.
        friction: Coulomb's coefficient µ, 0 or more; or a pair (static, kinetic), a
            ``FrictionTable`` or a function of the slip speed [m/s], an ``EllipticFriction``.
        tangential_restitution: of the tangential velocity where it sticks, -1 to 1;
            1 is a superball.
        active: function of (q, v), read-only copies of the whole robot's state, that says in
            ``simulate`` whether the contact counts when its gap closes: above zero it does, else
            the point passes through and counts again once it has come out, such as a swing foot
            that scuffs in models of walking. ``solve`` does not ask it.
        name: its name in results; by default its index in the scene.
        stiffness: k in F = k δ^exponent [N/m^exponent], for ``Law(restitution="lzb")``, which
            uses ratios only; ``math.inf`` for one that supports and does not give way beside
            the others.
        adhesion: the largest pull that it bears [N s], as of a suction cup, magnet or gecko pad
            that catches: 0 ≤ P_n + A ⊥ u_n⁺ ≥ 0, |P_t| ≤ µ (P_n + A). It holds what takes no more
            than A and lets go of the rest. Needs restitution 0 and ``Law()``.
        holding_force: the largest pull that it bears while it rests in ``simulate`` [N], as A for
            impulses: 0 ≤ F_n + F ⊥ a_n ≥ 0, |F_t| ≤ µ (F_n + F). Once it lets go it pulls no more
            until it rests again. Needs what ``adhesion`` needs.
        rolling: rolling friction [m]: |M_t| ≤ rolling·P_n across the normal opposes the relative
            rolling ω_t (Acary & Bourrier 2021; condim 6 of MuJoCo). Needs Newton's or Poisson's
            law with slip at the end.
        torsion: torsional friction [m]: |M_n| ≤ torsion·P_n about the normal opposes the spin
            ω_n. A pressed patch of radius a gives (2/3) µ a.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> Contact("left_sole", at=[0.1, 0, 0], normal=[0, 0, 2], restitution=0.2).normal
        (0.0, 0.0, 1.0)
    """

    frame: str
    at: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    origin: Vector = (0.0, 0.0, 0.0)
    against: str = "world"
    restitution: float | Callable[[float], float] | Literal["material"] = 0.0
    friction: Friction | Literal["material"] = 0.0
    tangential_restitution: float = 0.0
    name: str | None = None
    stiffness: float | None = None
    adhesion: float = 0.0
    active: Callable[[Any, Any], float] | None = None
    rolling: float = 0.0
    torsion: float = 0.0
    holding_force: float = 0.0
    # Coefficients that a table of materials gave; ``dataclasses.replace`` hands them on.
    _by_table: InitVar[ByTable] = a_field(default=(), kw_only=True)

    def __post_init__(self, _by_table: ByTable) -> None:
        text(self.frame, "Contact: frame")
        text(self.against, "Contact: against")
        what = f'Contact of "{self.frame}" against "{self.against}"'
        if self.frame == self.against:
            raise InputError(f"{what}: a frame does not touch itself")
        keep(self, what, vector, "at", "normal", "origin")
        if self.active is not None and not callable(self.active):
            raise InputError(f"{what}: active must be a function of (q, v)")
        length = math.hypot(*self.normal)
        if length < SHORTEST_NORMAL:
            raise RangeError.of(f"{what}: length of normal", length, "above zero")
        # A normal that is of unit length but for rounding stays as it is, bit for bit.
        if abs(length - 1.0) > UNIT:
            x, y, z = self.normal
            object.__setattr__(self, "normal", (x / length, y / length, z / length))
        _check_coefficients(self, what)
        keep(self, what, not_negative, "adhesion", "holding_force")
        keep_from_table(self, _by_table)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame, self.against)


@dataclass(frozen=True)
class JointStop(InJoint):
    """The limits of a joint as a contact.

    In ``solve`` a stop is touched when q is at the limit or past it. The impulse is the
    one the joint receives, along its own coordinate.

    Attributes:
        joint: a revolute or prismatic joint.
        lower, upper: the limits [rad, m]; None for those of the model.
        restitution: as for ``Contact``, of the joint's velocity [rad/s, m/s].
        name: its name in results; by default its index in the scene.
        stiffness: as for ``Contact`` [N m/rad^exponent, N/m^exponent].

    Raises:
        InputError, NotFiniteError, RangeError.

    Example:
        >>> JointStop("elbow", upper=2.0, restitution=0.5).upper
        2.0
    """

    joint: str
    lower: float | None = None
    upper: float | None = None
    restitution: float | Callable[[float], float] = 0.0
    name: str | None = None
    stiffness: float | None = None

    def __post_init__(self) -> None:
        text(self.joint, "JointStop: joint")
        what = f'JointStop of "{self.joint}"'
        keep(self, what, optional(number), "lower", "upper")
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise RangeError.of(f"{what}: lower", self.lower, f"at most upper, {self.upper:g}")
        keep(self, what, checked_restitution, "restitution")
        check_stiffness(self, what)
        check_name(self.name, what)

    def limits(self, robot: Robot) -> tuple[float, float]:
        """Lower and upper limit, its own or the model's [rad, m]."""
        joint = robot.model.joints[robot.joint_id(self.joint)]
        model = robot.model
        lower = model.lowerPositionLimit[joint.idx_q] if self.lower is None else self.lower
        upper = model.upperPositionLimit[joint.idx_q] if self.upper is None else self.upper
        return float(lower), float(upper)


@dataclass(frozen=True)
class Collision(Acting):
    """A possible contact of two links, or of two pieces of collision geometry.

    Points, normals and gaps come from the geometry at the configuration of the impact; flat
    pairs touch in several points. A mesh counts as its convex hull. The normal points
    from ``other`` to ``first``, the impulse is the one that ``first`` receives.

    Attributes:
        first, other: links (all their geometry) or single geometry objects by name.
        restitution, friction, tangential_restitution: as for ``Contact``, for every point.
        margin: every corner of a flat pair whose gap is no more than this touches [m], whatever the
            depth of others; None for 5e-4 of the diameter of a ball around the smaller body, to
            which meshes of flat faces are flat. More of them close by are told in
            ``Impact.doubts``.
        name: its name in results; by default its index in the scene.
        stiffness: as for ``Contact``, of each point.
        rolling, torsion: as for ``Contact`` [m], at every point.

    Raises:
        InputError, NotFiniteError, RangeError.

    Example:
        >>> Collision("ball/ball", "arm/hand", restitution=0.8, friction=0.3, margin=1e-5).margin
        1e-05
    """

    first: str
    other: str
    restitution: float | Callable[[float], float] | Literal["material"] = 0.0
    friction: Friction | Literal["material"] = 0.0
    tangential_restitution: float = 0.0
    margin: float | None = None
    name: str | None = None
    stiffness: float | None = None
    rolling: float = 0.0
    torsion: float = 0.0
    _by_table: InitVar[ByTable] = a_field(default=(), kw_only=True)

    def __post_init__(self, _by_table: ByTable) -> None:
        text(self.first, "Collision: first")
        text(self.other, "Collision: other")
        what = f'Collision of "{self.first}" and "{self.other}"'
        if self.first == self.other:
            raise InputError(f"{what}: a body does not collide with itself")
        keep(self, what, optional(between(0.0, 1.0, "0 to 1 m")), "margin")
        _check_coefficients(self, what)
        keep_from_table(self, _by_table)


def adheres(entry: Any) -> bool:
    """Return whether a contact holds what it touches, in impacts or at rest."""
    return bool(getattr(entry, "adhesion", 0.0) or getattr(entry, "holding_force", 0.0))


def turns(entry: Any) -> bool:
    """Return whether a contact resists rolling or spin."""
    return bool(getattr(entry, "rolling", 0.0) or getattr(entry, "torsion", 0.0))


def _check_coefficients(entry: Contact | Collision, what: str) -> None:
    if not is_by_material(entry.restitution):
        keep(entry, what, checked_restitution, "restitution")
    if not is_by_material(entry.friction):
        keep(entry, what, checked_friction, "friction")
    keep(entry, what, not_negative, "rolling", "torsion")
    keep(entry, what, between(-1.0, 1.0), "tangential_restitution")
    if entry.tangential_restitution and not is_plain(entry.friction):
        raise InputError(
            f"{what}: tangential_restitution goes with a friction that is a number, or is 0"
        )
    check_stiffness(entry, what)
    check_name(entry.name, what)


def check_stiffness(entry: Any, what: str) -> None:
    """Prove that the stiffness of a contact is a number above 0, infinity, or None."""
    if not (isinstance(entry.stiffness, float | np.floating) and entry.stiffness == math.inf):
        keep(entry, what, optional(positive), "stiffness")
