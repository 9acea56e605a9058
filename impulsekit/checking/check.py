"""``check``: an impact beside Chang & Huston's own method."""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

import numpy as np

from ..errors import InputError, RangeError, SingularMassError, StateError, a_thing, shown
from ..errors.calls import public
from ..reference import Arithmetic, KaneImpact, Rows
from ..scene import GapContact, JointStop
from .demands import KnownImpulses, constraint_rows, known_impulses
from .result import Check, compared
from .sizes import conditions_of, take
from .system import ReferenceRobot, reference_robot

if TYPE_CHECKING:
    from ..impact import Impact
    from ..motion.estimate import MotionCheck
    from ..motion.record.trajectory import Trajectory

# Digits of the reference. Some hundred tell all that doubles can; far more never end.
MOST_DIGITS = 10_000


@overload
def check(impact: Impact, digits: int | None = None) -> Check: ...


@overload
def check(impact: Trajectory) -> MotionCheck: ...


@public
def check(impact: Impact | Trajectory, digits: int | None = None) -> Check | MotionCheck:
    """Check an impact against Kane's equations, with code independent of Pinocchio.

    A motion is simulated again with a tenth of its tolerance: ``MotionCheck`` reports the
    difference, an estimate of its error.

    The reference reads the URDF again and solves the impact equations of Chang & Huston 1995,
    eqs. (18)-(33); it finds the impulse of each joint by freeing it. It compares Δv, I_l, P_l,
    the velocity jumps of all links, the energies, the impulses of joints and constraints, and
    the velocities that the constraints prescribe. Each difference is relative to the size of its
    quantity in this impact, given in its row; velocities and generalized impulses are measured
    in the metric of the mass matrix, so that metres and radians compare.

    The tolerance is the possible rounding error: 10 ε κ, at least 1e-12 and at most 1e-6. κ is
    κ(M) where all impulses are known, and κ(M) √κ(W) + κ(W) under constraints; κ(M) and
    κ(W) are the condition numbers of the mass matrix and of the Delassus matrix of the
    independent rows, each scaled to unit diagonal. Without ``digits`` the reference rounds its
    positions too: κ is larger by the robot's distance from the origin over its reach.

    Contact impulses follow from the law of contact: the reference takes them as given and checks
    everything else.

    Args:
        impact: a solved impact, or a motion.
        digits: decimal digits of the reference (16 to 10000), by mpmath; by default
            doubles.

    Raises:
        InputError: the impact cannot be checked: its robot has a joint that the reference
            does not know (helical, ellipsoid, mimic in a given model), or its URDF cannot be
            read by the reference; a quaternion of q is off unit length by more than 1e-9; or
            some motion is resisted by constraints alone.
        MissingExtraError: ``digits`` is given and mpmath is not installed.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> check(solve(scene, robot.neutral(), robot.velocity())).agrees
        True
    """
    from ..impact import Impact

    if not isinstance(impact, Impact):
        from ..motion.record.trajectory import Trajectory as AMotion

        if isinstance(impact, AMotion) and digits is None:
            from ..motion.estimate import check_motion

            return check_motion(impact)
        raise InputError(f"check takes an Impact, not {a_thing(impact)}")
    if digits is not None and not (isinstance(digits, int) and 16 <= digits <= MOST_DIGITS):
        raise RangeError.of("digits", shown(digits), f"a whole number from 16 to {MOST_DIGITS}")
    numbers = Arithmetic.double() if digits is None else Arithmetic.mpmath(digits)
    return _checked(impact, reference_robot(impact.scene.robot, numbers))


def _checked(impact: Impact, reference: ReferenceRobot) -> Check:
    """Check an impact by a reading of the robot."""
    scene, system = impact.scene, reference.system
    try:
        at = system.kinematics(impact.q)
    except StateError as error:
        raise _impossible(error, reference) from error
    known = known_impulses(reference, scene.impulses)
    notes = _give_what_solvers_found(impact, known)
    demands = constraint_rows(reference, at, impact.v_before, scene.held)
    conditions = conditions_of(system, at, demands)
    if conditions is None:
        # The reference's own solver names the motion.
        _solved(impact, known, None)
        raise _impossible("its mass matrix is nearly singular", reference)
    truth = _solved(impact, known, take(demands, conditions.independent))
    carried = truth
    if not all(result.unique for result in impact.constraints):
        notes.append(
            "the constraints can share their impulses in more than one way; "
            "joints are compared under the share that was found"
        )
        carried = _solved(impact, _with_constraint_impulses(impact, known), None)
    rows = compared(impact, reference, at, truth, carried, demands, conditions, known.loads)
    return Check(
        rows=rows,
        tolerance=conditions.tolerance,
        condition=conditions.of_masses,
        condition_of_rows=conditions.of_rows,
        numbers=system.arithmetic.name,
        notes=tuple(notes),
    )


def _solved(impact: Impact, known: KnownImpulses, rows: Rows | None) -> KaneImpact:
    system = known.reference.system
    try:
        return system.impact(impact.q, impact.v_before, known.loads, known.in_joints, rows)
    except SingularMassError as error:
        raise _impossible(error, known.reference) from error


def _give_what_solvers_found(impact: Impact, known: KnownImpulses) -> list[str]:
    """Add impulses that no entry of the scene gives or demands; return notes on them."""
    from ..impact.forces import body_impulses

    found = set(impact.scene.entry_names("contacts"))
    for item in body_impulses(impact):
        if item.entry in found and item.frame_id > 0:
            known.add_on_body(item, impact.scene.robot.model.frames)
    touching = 0
    for entry, result in zip(impact.scene.contacts, impact.contacts, strict=True):
        touching += result.touching
        if result.touching and isinstance(entry, GapContact):
            raise InputError(
                "this impact cannot be checked: a GapContact is a function of q, which the "
                "reference has no words for"
            )
        if result.touching and isinstance(entry, JointStop):
            known.add_in_joint(entry.joint, result.impulse)
    return ["the impulses of contacts are given to the reference"] if touching else []


def _with_constraint_impulses(impact: Impact, known: KnownImpulses) -> KnownImpulses:
    """Return the known impulses and those that were found for the constraints."""
    from ..impact.forces import body_impulses

    scene = impact.scene
    everything = KnownImpulses(known.reference, list(known.loads), dict(known.in_joints))
    names = set(scene.entry_names("held"))
    for item in body_impulses(impact):
        if item.entry in names and item.frame_id > 0:
            everything.add_on_body(item, scene.robot.model.frames)
    for entry, result in zip(scene.held, impact.constraints, strict=True):
        everything.add_of_joint_constraint(entry, np.asarray(result.impulse))
    return everything


def _impossible(reason: object, reference: ReferenceRobot) -> InputError:
    words = str(reason).replace(reference.prefix, "") if reference.prefix else str(reason)
    return InputError(f"this impact cannot be checked: {words}")
