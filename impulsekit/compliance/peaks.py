"""Peaks: the largest force of a contact at many states, the largest torque of a gear."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, RangeError, check_kind, quoted
from ..errors.calls import public
from ..formatting import Displayed, OneLine
from ..impact import Impact
from ..robot.arrays import lock
from ..scene import Scene
from ..scene.contacts import turns
from ..scene.numbers import positive
from .curves import Curve, Hertz, HuntCrossley, PowerCurve
from .history import checked_curve, way_of
from .viscous import FASTEST, phases_of, viscous_peak

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..batch.result import ImpactBatch


@public
@dataclass(frozen=True, eq=False, repr=False)
class PeakForces(OneLine):
    """The largest force of one contact at B states. Arrays are read-only.

    Rows whose impact is not valid hold NaN, rows in which the contact is not struck 0.

    Attributes:
        contact: the name of the contact.
        status: (B,) the ``Status`` of each impact, as an integer code.
        impulse: (B,) normal impulse, ∫F dt [N s].
        peak_force: (B,) the largest normal force [N].
        indentation: (B,) the largest indentation [m].
        stored: (B,) the energy at the deepest point [J].
        lost: (B,) the part of ``stored`` that is not regained [J].

    Of a joint stop impulses and forces are N m s and N m, indentations rad.

    Example:
        >>> import numpy as np
        >>> zero = np.zeros(2)
        >>> PeakForces("tip", np.zeros(2, dtype=np.int8), zero, zero, zero, zero, zero).contact
        'tip'
    """

    contact: str
    status: np.ndarray
    impulse: np.ndarray
    peak_force: np.ndarray
    indentation: np.ndarray
    stored: np.ndarray
    lost: np.ndarray


@public
def peak_forces(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike,
    curve: Curve,
    *,
    restitution: Any = None,
    friction: Any = None,
    masses: Mapping[str, ArrayLike] | None = None,
    points: Mapping[str, ArrayLike] | None = None,
    threads: int | None = None,
) -> PeakForces:
    """Return the peak of ``force_history`` at many states, at the speed of ``solve_batch``.

    One effective mass m = P/(c + s) moves in and out, with P the normal impulse, c and s the
    normal speeds of approach and separation. The deepest indentation δ follows from
    ∫₀^δ F dδ = ½ m c²; ``HuntCrossley`` has its largest force before it.

    Args:
        scene: one contact, no impulses, no constraints; no friction, or Newton's law with slip
            at the end; no rolling, torsion or adhesion.
        q, v: (B, nq) or (nq,), and (B, nv) or (nv,).
        curve: ``Hertz``, ``HuntCrossley``, ``PowerCurve`` or ``MeasuredCurve``.
        restitution, friction, masses, points, threads: as for ``solve_batch``.

    Raises:
        InputError: another scene, or something that is not a curve.
        What ``solve_batch`` raises.
        RangeError: an approach above 1e100 m/s; a row's impact takes more energy than a measured
            curve holds; ``HuntCrossley`` with restitution below 0.03.

    Example:
        >>> import numpy as np
        >>> from impulsekit import Contact, Robot, Scene
        >>> from impulsekit.compliance import Hertz
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = Contact("ball", at=[0, 0, -0.1], restitution=0.8)
        >>> drops = np.zeros((3, 6))
        >>> drops[:, 2] = [-1.0, -2.0, -4.0]
        >>> rubber = Hertz(E=1e7, nu=0.5, radius=0.1)
        >>> found = peak_forces(Scene(ball, contacts=[floor]), ball.neutral(), drops, rubber)
        >>> found.peak_force.round()
        array([ 378.,  868., 1995.])
    """
    from ..batch.solve import solve_batch

    name = _only_contact(scene, curve, friction)
    batch = solve_batch(
        scene, q, v, restitution=restitution, friction=friction, masses=masses, points=points,
        outputs=("normal_components",), threads=threads,
    )  # fmt: skip
    return _peaks(name, batch, curve)


def _only_contact(scene: Scene, curve: Curve, friction: Any) -> str:
    """Return the name of the scene's contact, or raise where peaks are not available."""
    check_kind(scene, Scene, "peak_forces")
    checked_curve(curve, "peak_forces")
    if len(scene.contacts) != 1 or scene.impulses or scene.held:
        raise InputError(
            "peak_forces: the scene must have one contact, no impulses and no constraints, got "
            f"{len(scene.contacts)} contacts, {len(scene.impulses)} impulses and "
            f"{len(scene.held)} constraints; use force_history for each impact"
        )
    entry, law = scene.contacts[0], scene.law
    rubs = friction is not None or getattr(entry, "friction", 0.0) != 0.0
    if rubs and (law.restitution, law.slip) != ("newton", "end"):
        raise InputError(
            "peak_forces: with friction the law must be Newton's with slip at the end, got "
            f'restitution="{law.restitution}", slip="{law.slip}"; use force_history for each impact'
        )
    if turns(entry) or getattr(entry, "adhesion", 0.0) != 0.0:
        raise InputError("peak_forces: not available with rolling, torsion or adhesion")
    return scene.entry_names("contacts")[0]


def _peaks(name: str, batch: ImpactBatch, curve: Curve) -> PeakForces:
    """Compute peaks from a batch's normal velocities and impulses; rows not struck are left out."""
    parts = batch.normal_components[:, 0]
    impulse = np.where(batch.valid, parts[:, 2], np.nan)
    struck = np.flatnonzero(impulse > 0.0)
    whole = len(struck) == len(impulse)
    before, after, pressed = (parts if whole else parts[struck]).T
    approach, separation = -before, np.maximum(after, 0.0)
    fastest = float(approach.max(initial=0.0))
    if fastest > FASTEST:
        raise RangeError.of(f'contact "{name}": approach speed', fastest, f"up to {FASTEST:g} m/s")
    mass = pressed / (approach + separation)
    spent = 0.5 * mass * approach * approach
    lost = spent - 0.5 * mass * separation * separation
    if isinstance(curve, HuntCrossley):
        _, deepest, peak = viscous_peak(
            approach, separation, mass, mass, curve.stiffness, curve.exponent
        )
        if np.isnan(peak).any():
            slow = float(np.min(separation / approach))
            raise RangeError.of("HuntCrossley: restitution", slow, "above 0.03")
    elif isinstance(curve, Hertz | PowerCurve):
        power = PowerCurve(curve.stiffness, curve.exponent)
        deepest = power.deepest(spent)
        peak = power.force(deepest)
    else:
        columns = zip(pressed, before, after, strict=True)
        where = f'contact "{name}"'
        ways = [
            way_of(phases_of(P, u, w, 0.5 * P * (u + w), where), curve, where)
            for P, u, w in columns
        ]
        deepest = np.array([way.deepest for way in ways])
        peak = np.array([way.peak for way in ways])
    arrays = [peak, deepest, spent, lost]
    if not whole:
        nothing = np.where(np.isnan(impulse), np.nan, 0.0)
        arrays = [_spread(array, struck, nothing) for array in arrays]
    lock(impulse, *arrays)
    return PeakForces(name, batch.status, impulse, *arrays)


def _spread(values: np.ndarray, rows: np.ndarray, nothing: np.ndarray) -> np.ndarray:
    """Return ``values`` at the given rows, ``nothing`` at all others."""
    whole = nothing.copy()
    whole[rows] = values
    return whole


@public
@dataclass(frozen=True, repr=False)
class GearPeak(Displayed):
    """The peak torque of a gear in an impact.

    Attributes:
        joint: its name.
        jump: Δω of the joint in the impact [rad/s].
        torque: the peak torque at the output [N m], 0 or more.
        limit: the catalogue's limit of momentary torque [N m]; None if none was given.

    Example:
        >>> GearPeak("elbow", jump=1.0, torque=60.0, limit=80.0).share
        0.75
    """

    answer = ("joint", "torque", "limit", "share")

    joint: str
    jump: float
    torque: float
    limit: float | None = None

    @property
    def share(self) -> float:
        """The torque over its limit; NaN without one."""
        return math.nan if self.limit is None else self.torque / self.limit


@public
def gear_peaks(
    impact: Impact,
    stiffness: Mapping[str, float],
    *,
    inertia: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
) -> tuple[GearPeak, ...]:
    """Return the peak torques of gears, the largest share of its limit first.

    The links jump by Δω at once, and the rotor behind the gear follows through its torsional
    stiffness k. With the rotor's inertia J at the output (gear ratio squared times its own) all of
    its energy of relative motion goes into the gear, ½ J Δω² = τ²/(2k), so that τ = Δω √(kJ). It is
    a bound from above: what the gear holds back slows the links, too.

    Args:
        impact: a solved impact, in which these joints are free and carry no rotor, so that Δω is
            that of the links alone.
        stiffness: k by joint, at the output [N m/rad], of revolute joints.
        inertia: J by joint, at the output [kg m²]; by default the robot's armature.
        limits: torques of the catalogue by joint [N m].

    Raises:
        InputError: a joint without a single angle, or without inertia of a rotor.
        UnknownNameError, RangeError, NotFiniteError.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> arm = Robot.from_example("ur5")
        >>> impact = solve(Scene(arm, [AppliedImpulse("tool0", linear=[0, 0, 5])]),
        ...                arm.neutral(), arm.velocity())
        >>> gear_peaks(impact, {"elbow_joint": 2e4}, inertia={"elbow_joint": 0.92})[0].joint
        'elbow_joint'
    """
    check_kind(impact, Impact, "gear_peaks")
    for what, table in (("stiffness", stiffness), ("inertia", inertia), ("limits", limits)):
        if not isinstance(table, Mapping | None):
            raise InputError(f"gear_peaks: {what} must be a mapping by joint, got {quoted(table)}")
    model, robot = impact.scene.robot.model, impact.scene.robot
    found = []
    for name, given in stiffness.items():
        joint = model.joints[robot.joint_id(name, "gear_peaks")]
        if joint.nv != 1:
            raise InputError(f'gear_peaks: joint "{name}" has no single angle')
        rotor = (inertia or {}).get(name, float(model.armature[joint.idx_v]))
        if not rotor:
            raise InputError(
                f'gear_peaks: no rotor is known behind joint "{name}"; give inertia= or '
                "robot.with_armature"
            )
        stiff = positive(given, f'gear_peaks: stiffness of "{name}"')
        turning = positive(rotor, f'gear_peaks: inertia of "{name}"')
        limit = None if limits is None or name not in limits else limits[name]
        if limit is not None:
            limit = positive(limit, f'gear_peaks: limit of "{name}"')
        jump = float(impact.dv[joint.idx_v])
        found.append(GearPeak(name, jump, abs(jump) * math.sqrt(stiff * turning), limit))
    shares = [-each.torque if each.limit is None else -each.share for each in found]
    return tuple(each for _, each in sorted(zip(shares, found, strict=True), key=lambda x: x[0]))
