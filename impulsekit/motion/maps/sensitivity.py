"""How a whole motion with its impacts changes with its start: the chain of flows and impacts.

Φ = Φ_k Ξ_k … Φ_1 Ξ_1 Φ_0 on the tangent of (q, v), with the saltation matrices Ξ of the
impacts and the flows Φ between them. Over a period it is the monodromy matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise, permutations
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ...display import OneLine
from ...errors import InputError, check_kind
from ...impact.saltation import Saltation, saltation
from ...impact.solver import ImpactSolver
from ...scene import JointFriction
from ...scene.coefficients import is_plain
from ...scene.contacts import adheres, turns
from .flow import Flow

if TYPE_CHECKING:
    from ...impact import Impact
    from ..record.trajectory import Trajectory

__all__ = ["Chain", "Sensitivity", "sensitivity"]

# Times [s] this near are one.
SAME_TIME = 1e-12
# A flow that ends this far [m, rad] from the motion is another one.
ASTRAY = 1e-5
# Two orders of contacts that differ less than this, relatively, are the same.
SAME_ANSWER = 1e-8
MOST_TOGETHER = 4


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(OneLine):
    """The linear map from deviations (δq, δv) at the start of a motion to those at its end.

    Attributes:
        matrix: (2 nv, 2 nv) Φ, read-only.
        saltations: (time [s], ``Saltation``) of its impacts.
    """

    matrix: np.ndarray
    saltations: tuple[tuple[float, Saltation], ...] = field(repr=False)

    @property
    def exists(self) -> bool:
        """Whether every impact on the way has derivatives."""
        return all(item.derivatives.status.exists for _, item in self.saltations)

    @property
    def multipliers(self) -> np.ndarray:
        """(2 nv,) eigenvalues of Φ, the largest first; Floquet's where the motion is periodic."""
        values = np.linalg.eigvals(self.matrix)
        return values[np.argsort(-np.abs(values))]


def sensitivity(motion: Trajectory) -> Sensitivity:
    """The derivative of the final state of a motion by its initial state, across its impacts.

    Impacts enter with their saltation matrices; the motion between them, free or with resting
    contacts, by central differences (error about 1e-8 of the largest entry). Impulses at t = 0
    act at a fixed time; later impacts occur when their contact closes. Contacts that close at
    the same instant have a derivative if their order does not matter.

    Raises:
        InputError: a contact comes to rest by ever smaller bounces, or its slip begins or ends
            while it rests; the order of contacts that close at the same instant
            matters; the motion ended early; or as for
            ``derivatives``.
        RangeError: a contact is only grazed.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, simulate
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.9)])
        >>> drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
        >>> motion = simulate(scene, drop, ball.velocity(), duration=0.8)
        >>> float(round(sensitivity(motion).matrix[0, 0], 6))
        1.0
    """
    from ..record.trajectory import Trajectory as AMotion

    check_kind(motion, AMotion, "sensitivity")
    if not motion.status.finished:
        raise InputError(
            f"sensitivity: the motion was not followed to its end. {motion.status.value}"
        )
    if any(isinstance(force, JointFriction) for force in motion.scene.forces):
        raise InputError(
            "sensitivity: not available for joints with dry friction; use finite differences of "
            "simulate"
        )
    if any(turns(c) or not is_plain(getattr(c, "friction", 0.0)) for c in motion.scene.contacts):
        raise InputError(
            "sensitivity: not available for contacts with rolling or torsion, or with friction "
            "other than a number; use finite differences of simulate"
        )
    if any(map(adheres, motion.scene.contacts)):
        raise InputError(
            "sensitivity: not available for contacts with adhesion or a holding_force; use finite "
            "differences of simulate"
        )
    bounces = dict(zip(motion.scene.entry_names("contacts"), motion.scene.contacts, strict=True))
    for rest in motion.rests:
        entry = bounces.get(rest.contact)
        # What bounces comes to rest in the limit only.
        if rest.start > 0.0 and entry is not None and entry.restitution != 0.0:
            raise InputError(
                f"sensitivity: a contact comes to rest at {rest.start:g} s by ever smaller "
                "bounces; no derivative passes their end"
            )
    given = [entry.restitution for entry in motion.scene.contacts]
    for time, impact in motion.impacts:
        # A contact that approaches ever more slowly is caught without its restitution.
        if [entry.restitution for entry in impact.scene.contacts] != given:
            raise InputError(
                f"sensitivity: a contact comes to rest at {time:g} s by ever smaller bounces; "
                "motions are taken in which contacts part again or stay at their first impact"
            )
    return Chain(motion).followed()


class Chain:
    """Flows and impacts of one motion, one after the other."""

    def __init__(self, motion: Trajectory) -> None:
        self._motion = motion
        self._total = np.eye(2 * motion.scene.robot.nv)
        self._saltations: list[tuple[float, Saltation]] = []
        self._flows: dict[frozenset[str], Flow] = {}

    def followed(self) -> Sensitivity:
        """The whole chain."""
        motion = self._motion
        t, q, v = self._through(motion.impacts)
        if motion.duration > t:
            self._flow(t, motion.duration, q, v)
        self._total.setflags(write=False)
        return Sensitivity(self._total, tuple(self._saltations))

    def _through(
        self, impacts: Sequence[tuple[float, Impact]]
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """The time [s] and state after some impacts from the start on, which are passed."""
        t, (q, v) = 0.0, self._motion.at(0.0)
        for time, impact in impacts:
            if time > t:
                self._flow(t, time, q, v)
            self._strike(time, impact)
            t, q, v = time, impact.q, impact.v_after
        return t, q, v

    def to_impact(self, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As far as one of the impacts of the motion, which is later than its start.

        Returns:
            (2 nv, 2 nv) the derivative of the state before it and (2 nv, 2 nv) of that after it,
            at its time, by the start; and (nv,) the accelerations after it.
        """
        t, q, v = self._through(self._motion.impacts[:index])
        time, impact = self._motion.impacts[index]
        self._flow(t, time, q, v)
        before = self._total
        self._strike(time, impact)
        after = self._flow_of(self._resting(time, 1.0))
        return before, self._total, after.acceleration(time, impact.q, impact.v_after)

    def _resting(self, t: float, side: float) -> frozenset[str]:
        """The contacts that rest just before (−1) or after (1) a time."""
        at = t + side * SAME_TIME
        return frozenset(r.contact for r in self._motion.rests if r.start < at < r.end)

    def _flow_of(self, resting: frozenset[str]) -> Flow:
        flow = self._flows.get(resting)
        if flow is None:
            flow = self._flows[resting] = Flow(self._motion.scene, resting)
        return flow

    def _flow(self, start: float, end: float, q: np.ndarray, v: np.ndarray) -> None:
        """Pass a stretch, cut where contacts let go."""
        inside = {r.end for r in self._motion.rests if start + SAME_TIME < r.end < end - SAME_TIME}
        times = [start, *sorted(inside), end]
        for t, until in pairwise(times):
            flow = self._flow_of(self._resting(t, 1.0))
            part, q, v = flow.jacobian(t, until, q, v)
            self._total = part @ self._total
            there = self._motion.at(until)[0]
            apart = np.abs(pin.difference(self._motion.scene.robot.model, there, q)).max()
            if apart > ASTRAY:
                raise InputError(
                    f"sensitivity: between {t:g} and {until:g} s slip begins or ends at a contact "
                    "that rests; there is no linear way past that"
                )

    def _strike(self, time: float, impact: Impact) -> None:
        """Pass an impact."""
        names = impact.scene.entry_names("contacts")
        outcome = impact.outcome
        touched = [] if outcome is None else [names[touch.entry] for touch in outcome.touches]
        before = self._resting(time, -1.0)
        closing = [name for name in dict.fromkeys(touched) if name not in before]
        after = self._resting(time, 1.0)
        if time <= 0.0:
            found = [self._saltation(time, impact, None, before, after)]
        elif len(closing) == 1:
            found = [self._saltation(time, impact, closing[0], before, after)]
        else:
            found = self._one_by_one(time, impact, closing, before, after)
        for item in found:
            self._saltations.append((time, item))
            self._total = item.matrix @ self._total

    def _saltation(
        self,
        time: float,
        impact: Impact,
        contact: str | None,
        before: frozenset[str],
        after: frozenset[str],
    ) -> Saltation:
        first, second = self._flow_of(before), self._flow_of(after)
        return saltation(
            impact,
            contact,
            acceleration_before=first.acceleration(time, impact.q, impact.v_before),
            acceleration_after=second.acceleration(time, impact.q, impact.v_after),
        )

    def _one_by_one(
        self,
        time: float,
        impact: Impact,
        closing: list[str],
        before: frozenset[str],
        after: frozenset[str],
    ) -> list[Saltation]:
        """Contacts that close together, in an order that does not matter.

        Raises:
            InputError: it matters.
        """
        together = f"sensitivity: {' and '.join(closing)} meet at one instant, {time:g} s"
        if not closing or len(closing) > MOST_TOGETHER:
            raise InputError(together)
        names = impact.scene.entry_names("contacts")
        solver = ImpactSolver(impact.scene)
        wholes, chains = [], []
        for order in permutations(closing):
            v, rests, chain = impact.v_before, before, []
            for name in order:
                part = solver.solve_touching(
                    impact.q, v, {i for i, n in enumerate(names) if n == name or n in rests}
                )
                then = rests | (after & {name})
                chain.append(self._saltation(time, part, name, rests, then))
                v, rests = part.v_after, then
            whole = np.eye(len(self._total))
            for item in chain:
                whole = item.matrix @ whole
            wholes.append((v, whole))
            chains.append(chain)
        scale = np.abs(impact.v_before).max() + np.abs(impact.v_after).max()
        size = max(float(np.abs(whole).max()) for _, whole in wholes)
        for v, whole in wholes:
            if (
                np.abs(v - impact.v_after).max() > SAME_ANSWER * scale
                or np.abs(whole - wholes[0][1]).max() > SAME_ANSWER * size
            ):
                raise InputError(
                    f"{together}, and it matters which is first: there is no derivative"
                )
        return chains[0]
