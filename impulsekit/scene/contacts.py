"""Unilateral contacts: a point on a plane, a joint at its stop, colliding bodies, a rope."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import InitVar, dataclass
from dataclasses import field as a_field
from typing import Annotated, Any

from ..errors import InputError, RangeError
from ..errors.calls import public
from ..robot import Robot
from .coefficients import (
    ByTable,
    Damping,
    FrictionOrMaterial,
    RestitutionLike,
    RestitutionOrMaterial,
    Stiffness,
    is_plain,
    keep_from_table,
)
from .constraints import KEPT_ANYWAY
from .entry import BetweenFrames, Entry, InJoint, check_two_bodies
from .law import Law
from .numbers import Name, NotNegative, Number, OfMotion, Positive, Vector, between

# A direction whose length is this near to 1 is left as it is given: dividing would only round it.
UNIT = 1e-15

# Longer or shorter normals are taken for a mistake, not for a direction.
SHORTEST_NORMAL = 1e-9
Tangential = Annotated[float, between(-1.0, 1.0)]


@public
@dataclass(frozen=True)
class Contact(Entry):
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
        stiffness: k in F = k δ^exponent [N/m^exponent], for ``Law(restitution="lzb")``, and for
            several contacts under ``Law(slip="compliant")``; only ratios count. ``math.inf`` for
            one that supports and does not give way beside the others.
        stiffness_ratio: κ, tangential over normal stiffness, for ``Law(slip="compliant")``:
            (1 − ν)/(1 − ν/2) of round bodies with Poisson's ratio ν (Mindlin 1949), math.inf for
            one that is rigid along its tangents.
        tangential_damping: D, the share of its work that the tangential spring does not give back,
            0 to .99, as 1 − e² of the normal one; none for ``None``.
        adhesion: the largest pull that it carries [N s], as of a suction cup, magnet or gecko pad
            that catches: 0 ≤ P_n + A ⊥ u_n⁺ ≥ 0, |P_t| ≤ µ (P_n + A). It holds what takes no more
            than A and lets go of the rest. Needs restitution 0 and ``Law()``.
        holding_force: the largest pull that it carries while it rests in ``simulate`` [N], as A for
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

    section, wording = "contacts", '{kind} of "{frame}" against "{against}"'

    frame: Name
    at: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    origin: Vector = (0.0, 0.0, 0.0)
    against: Name = "world"
    restitution: RestitutionOrMaterial = 0.0
    friction: FrictionOrMaterial = 0.0
    tangential_restitution: Tangential = 0.0
    name: Name | None = None
    stiffness: Stiffness = None
    adhesion: NotNegative = 0.0
    active: OfMotion | None = None
    rolling: NotNegative = 0.0
    torsion: NotNegative = 0.0
    holding_force: NotNegative = 0.0
    stiffness_ratio: Stiffness = None
    tangential_damping: Damping = None
    # Coefficients that a table of materials gave; ``dataclasses.replace`` passes them on.
    _by_table: InitVar[ByTable] = a_field(default=(), kw_only=True)

    def __post_init__(self, _by_table: ByTable) -> None:
        super().__post_init__()
        keep_from_table(self, _by_table)

    def _check(self, what: str) -> None:
        if self.frame == self.against:
            raise InputError(f"{what}: a frame does not touch itself")
        length = math.hypot(*self.normal)
        if length < SHORTEST_NORMAL:
            raise RangeError.of(f"{what}: length of normal", length, "above zero")
        # A normal that is of unit length but for rounding stays as it is, bit for bit.
        if abs(length - 1.0) > UNIT:
            x, y, z = self.normal
            object.__setattr__(self, "normal", (x / length, y / length, z / length))
        _check_tangential(self, what)

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has both frames, on two bodies."""
        check_two_bodies(robot, self.frame_names, where, "they cannot strike each other")

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame, self.against)


@public
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

    section = "contacts"

    joint: Name
    lower: Number | None = None
    upper: Number | None = None
    restitution: RestitutionLike = 0.0
    name: Name | None = None
    stiffness: Stiffness = None

    def _check(self, what: str) -> None:
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise RangeError.of(f"{what}: lower", self.lower, f"at most upper = {self.upper:g}")

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the joint has one coordinate, with limits in order."""
        joint = robot.model.joints[robot.joint_id(self.joint, where)]
        if joint.nq != 1 or joint.nv != 1:
            raise InputError(
                f'{where}: joint "{self.joint}" has no single coordinate that could reach a stop '
                "(a continuous joint has no limits)"
            )
        lower, upper = self.limits(robot)
        if not lower <= upper:
            raise InputError(
                f"{where}: the lower limit {lower:g} is above the upper {upper:g}; give both"
            )

    def limits(self, robot: Robot) -> tuple[float, float]:
        """Return lower and upper limit, its own or the model's [rad, m]."""
        joint = robot.model.joints[robot.joint_id(self.joint)]
        model = robot.model
        lower = model.lowerPositionLimit[joint.idx_q] if self.lower is None else self.lower
        upper = model.upperPositionLimit[joint.idx_q] if self.upper is None else self.upper
        return float(lower), float(upper)


@public
@dataclass(frozen=True)
class Collision(Entry):
    """A possible contact of two links, or of two pieces of collision geometry.

    Points, normals and gaps come from the geometry at the configuration of the impact; flat
    pairs touch in several points. A mesh counts as its convex hull. The normal points
    from ``other`` to ``first``, the impulse is the one that ``first`` receives.

    Attributes:
        first, other: links (all their geometry) or single geometry objects by name.
        restitution, friction, tangential_restitution: as for ``Contact``, for every point.
        margin: every corner of a flat pair whose gap is no more than this touches [m], whatever the
            depth of others; None for 5e-4 of the diameter of a ball around the smaller body, to
            which meshes of flat faces are flat. ``Impact.doubts`` reports more of them
            close by.
        name: its name in results; by default its index in the scene.
        stiffness, stiffness_ratio, tangential_damping: as for ``Contact``, of each point.
        rolling, torsion: as for ``Contact`` [m], at every point.

    Raises:
        InputError, NotFiniteError, RangeError.

    Example:
        >>> Collision("ball/ball", "arm/hand", restitution=0.8, friction=0.3, margin=1e-5).margin
        1e-05
    """

    section, wording = "contacts", '{kind} of "{first}" and "{other}"'

    first: Name
    other: Name
    restitution: RestitutionOrMaterial = 0.0
    friction: FrictionOrMaterial = 0.0
    tangential_restitution: Tangential = 0.0
    margin: Annotated[float, between(0.0, 1.0, "0 to 1 m")] | None = None
    name: Name | None = None
    stiffness: Stiffness = None
    rolling: NotNegative = 0.0
    torsion: NotNegative = 0.0
    stiffness_ratio: Stiffness = None
    tangential_damping: Damping = None
    _by_table: InitVar[ByTable] = a_field(default=(), kw_only=True)

    def __post_init__(self, _by_table: ByTable) -> None:
        super().__post_init__()
        keep_from_table(self, _by_table)

    def _check(self, what: str) -> None:
        if self.first == self.other:
            raise InputError(f"{what}: a body does not collide with itself")
        _check_tangential(self, what)

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that both names have geometry, on two bodies."""
        from ..robot.geometry import geometry_ids

        ends = [geometry_ids(robot, name, where)[1] for name in (self.first, self.other)]
        if ends[0] == ends[1]:
            raise InputError(
                f'{where}: "{self.first}" and "{self.other}" belong to one rigid body '
                "and cannot collide"
            )


@public
@dataclass(frozen=True)
class Rope(BetweenFrames):
    """Two points that a rope joins: no further apart than its length, and free when nearer.

    A contact without friction whose gap is length − distance. It pulls and never pushes. In
    ``solve`` it acts when the points are its length apart, or further; in ``simulate`` it jerks
    taut as an impact. The impulse is the one that ``frame`` receives.

    Attributes:
        frame, other: the frames; "world" is the fixed one.
        at, other_at: the points, each in its own frame [m].
        length: the largest distance [m], above 0.
        restitution: of the speed along the rope: as for ``Contact``.
        name: its name in results; by default its index in the scene.
        stiffness: as for ``Contact``.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> Rope("ball", length=0.8, other_at=[0, 0, 2], restitution=0.3).other
        'world'
    """

    section, within, alone = "contacts", *KEPT_ANYWAY

    frame: Name
    other: Name = "world"
    at: Vector = (0.0, 0.0, 0.0)
    other_at: Vector = (0.0, 0.0, 0.0)
    length: Positive = 1.0
    restitution: RestitutionLike = 0.0
    name: Name | None = None
    stiffness: Stiffness = None


def adheres(entry: Any) -> bool:
    """Return whether a contact holds what it touches, in impacts or at rest."""
    return bool(getattr(entry, "adhesion", 0.0) or getattr(entry, "holding_force", 0.0))


def turns(entry: Any) -> bool:
    """Return whether a contact resists rolling or spin."""
    return bool(getattr(entry, "rolling", 0.0) or getattr(entry, "torsion", 0.0))


def _check_tangential(entry: Contact | Collision, what: str) -> None:
    if entry.tangential_restitution and not is_plain(entry.friction):
        raise InputError(
            f"{what}: tangential_restitution goes with a friction that is a number, or is 0"
        )


def check_law(law: Law, contacts: Sequence[Any]) -> None:
    """Check that a law has what contacts ask of it.

    Raises:
        InputError: it has not.
    """
    for i, contact in enumerate(contacts):
        _check_law(law, contact, f"contacts[{i}]")


def _check_law(law: Law, contact: Any, where: str) -> None:
    at_once = (law.slip, law.order) == ("end", "simultaneous")
    usual = at_once and law.restitution in ("newton", "poisson")
    given = 'slip="end" and order="simultaneous"'
    if getattr(contact, "tangential_restitution", 0.0) and not (
        law.slip == "end" and law.restitution == "newton"
    ):
        raise InputError(
            f'{where}: tangential restitution has no meaning with restitution="{law.restitution}", '
            f'slip="{law.slip}"; it belongs to Law(restitution="newton", slip="end"), or is 0'
        )
    if law.restitution == "lzb" and contact.stiffness is None:
        raise InputError(
            f'{where}: restitution="lzb" needs the stiffness of every contact; give stiffness=, of '
            "which only ratios count"
        )
    mu: Any = getattr(contact, "friction", 0.0)
    if law.slip == "compliant" and mu and contact.stiffness_ratio is None:
        raise InputError(
            f'{where}: slip="compliant" needs the stiffness_ratio of every contact with friction, '
            "tangential over normal stiffness; (1 − ν)/(1 − ν/2) of round bodies, math.inf of rigid"
        )
    if adheres(contact):
        what = "adhesion" if contact.adhesion else "holding_force"
        if not (at_once and law.restitution == "newton"):
            raise InputError(
                f"{where}: {what} belongs to Law(), without words of its own; under other laws it "
                "is 0"
            )
        if callable(contact.restitution) or contact.restitution:
            raise InputError(
                f"{where}: a contact with {what} holds what it touches: restitution must be 0, got "
                f"{contact.restitution}"
            )
    if turns(contact) and (adheres(contact) or not usual):
        raise InputError(
            f"{where}: rolling and torsion need Newton's or Poisson's law with {given}, without "
            "adhesion; else set both to 0"
        )
    if not (usual or is_plain(getattr(contact, "friction", 0.0))):
        raise InputError(
            f"{where}: friction other than a number needs Newton's or Poisson's law with {given}; "
            "for other laws give a number"
        )
