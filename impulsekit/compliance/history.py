"""``force_history``: the force of a contact over time, from its impulse."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, RangeError, UnknownNameError, a_thing, check_kind
from ..errors.calls import public
from ..formatting import Displayed
from ..impact import Impact
from ..impact.joint_loads import JointLoad
from ..named import ByName
from ..robot.arrays import read_only
from ..scene.contacts import turns
from ..tolerances import NONZERO
from .curves import Curve, Hertz, HuntCrossley, PowerCurve
from .viscous import Phases, Sample, Way, phases_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# A time after the end by less than this share of the duration is the end; absolute and relative
# error of the fraction at which a time is reached.
BEHIND, XTOL, RTOL = 1e-12, 1e-15, 1e-14
# An imposed constraint whose rows jump by more than this share of the velocities acts as a blow.
IMPOSED = 1e-9


@public
@dataclass(frozen=True, eq=False, repr=False)
class ForceHistory(Displayed):
    """The force of one contact while an impact lasts.

    The direction of the force is that of the contact's impulse, and every joint reaction grows
    in proportion to it.

    Everything but the peak is computed on first access.

    Attributes:
        contact: the name of the contact.
        impulse: its normal impulse, ∫F dt [N s].

    Example:
        >>> from impulsekit import Contact, Robot, Scene, solve
        >>> from impulsekit.compliance import Hertz
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", at=[0, 0, -0.1])], gap_bound=1.0)
        >>> impact = solve(scene, ball.neutral(), ball.velocity(root_joint=[0, 0, -2, 0, 0, 0]))
        >>> history = force_history(impact, Hertz(E=1e7, nu=0.5, radius=0.1))
        >>> history.duration == history.compression, history.restitution
        (True, 0.0)
    """

    answer = ("contact", "peak_force", "duration", "impulse", "indentation")

    contact: str
    impulse: float
    _impact: Impact = field(repr=False)
    _way: Way = field(repr=False)

    @property
    def duration(self) -> float:
        """The duration of the contact [s]."""
        return self._way.duration

    @property
    def compression(self) -> float:
        """The duration of the compression [s]."""
        return self._way.compression

    @property
    def peak_force(self) -> float:
        """The largest normal force [N]."""
        return self._way.peak

    @property
    def indentation(self) -> float:
        """The largest indentation [m]."""
        return self._way.deepest

    @property
    def remaining(self) -> float:
        """The permanent indentation at the end [m]."""
        return self._way.remaining

    @property
    def restitution(self) -> float:
        """√(W_r/W_c), of the work regained to the work of the compression."""
        return math.sqrt(self._way.phases.regained / self.stored)

    @property
    def stored(self) -> float:
        """The energy at the deepest point [J]."""
        return self._way.phases.spent

    @property
    def lost(self) -> float:
        """The part of ``stored`` that is not regained [J]."""
        return self.stored - self._way.phases.regained

    @property
    def damping(self) -> float:
        """λ of ``HuntCrossley`` [s/m]; 0 for others."""
        return self._way.damping

    @cached_property
    def peak_reactions(self) -> Mapping[str, np.ndarray]:
        """By joint name, (6,) the wrench that the parent gives the child at the peak [N, N m].

        At the joint's origin, world axes. Gravity, motors and velocity terms, which are finite
        beside it, are not included.
        """
        scale = self.peak_force / self.impulse
        reactions = self._impact.reactions.items()
        return ByName({joint: read_only(scale * each) for joint, each in reactions}, "joint")

    @cached_property
    def peak_loads(self) -> Mapping[str, JointLoad]:
        """By joint name, ``peak_reactions`` in the joint's own axes: a ``JointLoad`` [N, N m]."""
        scale = self.peak_force / self.impulse
        loads = {
            joint: JointLoad(
                joint, read_only(scale * load.force), read_only(scale * load.moment), load.axis
            )
            for joint, load in self._impact.joint_loads.items()
        }
        return ByName(loads, "joint")

    @cached_property
    def _share(self) -> np.ndarray:
        """(3,) the impulse over its normal part, world axes."""
        contact = self._impact.contacts[self.contact]
        touched: np.ndarray = next(p.impulse for p in contact.points if p.impulse.any())
        return touched / self.impulse

    @cached_property
    def _samples(self) -> np.ndarray:
        return np.array([self._way.at(x) for x in np.linspace(0.0, 2.0, 201)])

    @property
    def t(self) -> np.ndarray:
        """(201,) instants from the first touch [s]."""
        return self._column(0)

    @property
    def force(self) -> np.ndarray:
        """(201,) normal force at ``t`` [N]."""
        return self._column(1)

    @property
    def depth(self) -> np.ndarray:
        """(201,) indentation at ``t`` [m]."""
        return self._column(2)

    @property
    def rate(self) -> np.ndarray:
        """(201,) rate of indentation at ``t`` [m/s]."""
        return self._column(3)

    def _column(self, k: int) -> np.ndarray:
        column = self._samples[:, k].copy()
        return read_only(column)

    def at(self, t: float) -> Sample:
        """Return force, indentation, its rate and the impulse so far at an instant, to rounding.

        Args:
            t: time since the first touch [s].

        Raises:
            RangeError: not within the contact.
        """
        if not 0.0 <= t <= self.duration * (1.0 + BEHIND):
            raise RangeError.of("t", t, f"0 to {self.duration:.6g} s, the duration")
        from scipy.optimize import brentq

        if t <= 0.0:
            return self._way.at(0.0)
        if t >= self.duration:
            return self._way.at(2.0)
        place = brentq(lambda x: self._way.at(x).time - t, 0.0, 2.0, xtol=XTOL, rtol=RTOL)
        return self._way.at(float(place))

    def force_at(self, t: ArrayLike) -> np.ndarray:
        """Return the (n,) normal force at instants [N]; 0 before and after the contact."""
        times = np.atleast_1d(np.array(t, dtype=float))
        return np.array(
            [self.at(float(x)).force if 0.0 <= x <= self.duration else 0.0 for x in times]
        )

    def vector_at(self, t: ArrayLike) -> np.ndarray:
        """Return the (n, 3) force that the contact's first body receives, world axes [N]."""
        return self.force_at(t)[:, None] * self._share


@public
def force_history(impact: Impact, curve: Curve, contact: str | int | None = None) -> ForceHistory:
    """Return the force of a contact over time, from the impulse that the law of impact gave it.

    A rigid impact gives the impulse P, the velocities before and after, and the work; how force
    grows with indentation determines how long that takes, how deep it goes, and the largest force.
    The impulse, both velocities and the restitution of the impact are kept.

    Args:
        impact: a valid impact in which one contact carries an impulse and nothing else strikes.
            Several contacts that act at once share the time by their stiffnesses: that is
            ``Law(restitution="lzb")``.
        curve: ``Hertz``, ``HuntCrossley``, ``PowerCurve`` or ``MeasuredCurve``.
        contact: name or index, of the contact that carries the impulse; may be left out.

    Raises:
        InputError: no contact or several carry an impulse, a blow or imposed constraint acts at
            the same instant, or the impact is not valid.
        RangeError: a curve that does not hold the energy; ``HuntCrossley`` without restitution.
        UnknownNameError: no such contact.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, solve
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = Contact("ball", at=[0, 0, -0.1], restitution=0.8)
        >>> drop = ball.velocity(root_joint=[0, 0, -2, 0, 0, 0])
        >>> impact = solve(Scene(ball, contacts=[floor]), ball.neutral(), drop)
        >>> history = force_history(impact, Hertz(E=1e7, nu=0.5, radius=0.1))
        >>> round(history.restitution, 12)
        0.8
    """
    check_kind(impact, Impact, "force_history")
    checked_curve(curve, "force_history")
    index, point = _only_contact(impact, contact)
    name = impact.scene.entry_names("contacts")[index]
    outcome: Any = impact.outcome
    solution, jacobian = outcome.contacts, outcome.touches[point].jacobian
    before, after = float(jacobian[2] @ impact.v_before), float(jacobian[2] @ impact.v_after)
    impulse, work = solution.impulse[3 * point + 2], solution.normal_work[point]
    where = f'contact "{name}"'
    phases = phases_of(float(impulse), before, after, float(work), where)
    way = way_of(phases, curve, where)
    # Raises here, not on first access, if a measured curve ends before it holds the energy.
    _ = way.peak
    return ForceHistory(name, phases.impulse, impact, way)


def way_of(phases: Phases, curve: Curve, where: str) -> Way:
    """Return compression and restitution of a contact on a curve."""
    viscous = isinstance(curve, HuntCrossley)
    if isinstance(curve, Hertz | HuntCrossley):
        curve = PowerCurve(curve.stiffness, curve.exponent)
    return Way(phases, curve, where, viscous)


def checked_curve(curve: Curve, what: str) -> None:
    """Raise InputError unless ``curve`` is one of the four kinds; ``what`` names the caller."""
    if not isinstance(curve, Curve):
        raise InputError(
            f"{what}: curve must be a Hertz, HuntCrossley, PowerCurve or MeasuredCurve, "
            f"got {a_thing(curve)}"
        )


def _only_contact(impact: Impact, contact: str | int | None) -> tuple[int, int]:
    """Return the index of the contact that carries the impulse, and of its touching point."""
    scene = impact.scene
    # As far as is known it has to be the only answer.
    if not impact.status.valid or impact.uniqueness.several:
        raise InputError(f"force_history: the impact is not valid: {impact.describe_status()}")
    if scene.impulses:
        raise InputError(
            "force_history: an applied impulse acts at the same instant; how long it takes is not "
            "known, so solve it apart from the contact"
        )
    if impact.constraints:
        jump = max(
            float(np.abs(c.velocity_after - c.velocity_before).max()) for c in impact.constraints
        )
        if jump > IMPOSED * max(float(np.abs(impact.v_before).max()), NONZERO):
            raise InputError(
                "force_history: a constraint is imposed at the same instant; how long that takes "
                "is not known, so solve it apart from the contact"
            )
    if any(map(turns, scene.contacts)):
        raise InputError(
            "force_history: not available with rolling or torsion, whose moments over time are not "
            "defined; set both to 0"
        )
    names = scene.entry_names("contacts")
    known = names if isinstance(contact, str) else range(len(names))
    if contact is not None and contact not in known:
        raise UnknownNameError.among("contact", str(contact), names, "force_history")
    outcome: Any = impact.outcome
    normal = () if outcome is None or outcome.contacts is None else outcome.contacts.impulse[2::3]
    loaded = [i for i, impulse in enumerate(normal) if impulse > 0.0]
    if not loaded:
        raise InputError("force_history: no contact carries an impulse")
    if len(loaded) > 1:
        touched = sorted({names[outcome.touches[i].entry] for i in loaded})
        raise InputError(
            f"force_history: {len(loaded)} points carry impulses at once ({', '.join(touched)}); "
            "how they share the time depends on the stiffness of each"
        )
    index = outcome.touches[loaded[0]].entry
    if contact is not None and contact not in (index, names[index]):
        raise InputError(f'force_history: "{contact}" carries no impulse, "{names[index]}" does')
    return index, loaded[0]
