"""How a motion begins: impulses strike, what touches is met, what holds is taken hold of."""

from __future__ import annotations

import numpy as np

from ...errors import InputError, SingularMassError
from ...impact.singular import refuse_massless
from ..dynamics.held import HeldRows
from ..rest.contacts import NO_SLIP
from .present import Present
from .settling import come_to_rest
from .striking import Striking

__all__ = ["begin"]

# What may overlap at the start [m]: rounding of a state written by hand.
PENETRATION = 1e-6
# Gaps at the start up to this [m] touch.
TOUCHES_AT_START = 1e-9
# Constraints that already move as they should, relative to the speeds they add up.
HOLDS = 1e-9


def begin(now: Present, striking: Striking) -> None:
    """Bring a motion from its state before to that just after t = 0.

    Raises:
        InputError: a contact that is penetrated.
        SingularMassError: a joint moves no inertia.
        ContradictionError: constraints that cannot hold together.
        ImpulsekitError: an impact that cannot be solved.
        Stopped: an impact without a valid answer.
    """
    touching: list[int] = []
    meets = bool(now.scene.impulses)
    if now.gaps is not None:
        gap, _ = now.gaps.everything(now.q, now.v)
        if now.gaps.has_conditions:
            for i in np.flatnonzero(gap <= TOUCHES_AT_START).tolist():
                if not now.gaps.counts(i, now.q, now.v):
                    if gap[i] < -TOUCHES_AT_START:
                        now.passing.add(i)
                    gap[i] = np.inf
        _refuse_penetration(now, gap)
        now.base = np.minimum(gap, 0.0)
        touching = np.flatnonzero(gap <= TOUCHES_AT_START).tolist()
        # Rounding of what lies still or slides is no approach.
        meets |= any(now.closing(i) < -now.slow for i in touching)
    held = now.held
    if held is None:
        robot = now.scene.robot
        refuse_massless(robot, robot.joint_names)
        now.dynamics.refuse_singular(now.q)
    if held is not None and not meets:
        meets = _has_to_move(held, now.q, now.v)
    if meets:
        striking.at_start(touching)
    if held is not None:
        held.start(now.q, now.v)
    # Whatever is wrong with the dynamics at the start is the caller's to know.
    first = now.dynamics.acceleration(now.t, now.q, now.v)
    if not np.isfinite(first).all():
        raise SingularMassError(
            "the acceleration at the start is not finite: a joint moves no inertia, or a "
            "force of the scene is not a number",
            joints=now.scene.robot.joint_names,
        )
    _come_to_rest(now, touching)


def _come_to_rest(now: Present, touching: list[int]) -> None:
    """What touches stays; slip that was given is kept, be it below the capture speed."""
    resting = now.resting
    slow, resting.slow = resting.slow, NO_SLIP
    try:
        come_to_rest(now, touching)
    finally:
        resting.slow = slow


def _has_to_move(held: HeldRows, q: np.ndarray, v: np.ndarray) -> bool:
    """Whether a constraint asks for another velocity than it has."""
    rows = held.rows.matrix(held.data, q)
    missing = held.velocity - rows.dot(v)
    if held.kept is not None:
        missing[held.kept] = 0.0
    scale = max(
        float(np.abs(rows).dot(np.abs(v)).max(initial=0.0)),
        float(np.abs(held.velocity).max(initial=0.0)),
    )
    return bool(np.abs(missing).max(initial=0.0) > HOLDS * scale)


def _refuse_penetration(now: Present, gap: np.ndarray) -> None:
    if now.gaps is None or not len(gap):
        return
    worst = int(np.argmin(gap))
    if gap[worst] < -PENETRATION:
        name = now.scene.entry_names("contacts")[now.gaps.entries[worst]]
        raise InputError(
            f"{name} is penetrated at the start by {-gap[worst]:.3g} (m, or rad of a stop); "
            "move the robot out of it, or the contact's plane or limit",
            contact=name,
            gap=float(gap[worst]),
        )
