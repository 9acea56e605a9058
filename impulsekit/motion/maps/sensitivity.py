"""Sensitivity of a whole motion with its impacts to its start: the chain of flows and impacts.

Φ = Φ_k Ξ_k … Φ_1 Ξ_1 Φ_0 on the tangent of (q, v), with the saltation matrices Ξ of the
impacts and the flows Φ between them. Over a period it is the monodromy matrix.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, permutations
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ...errors import InputError, check_kind
from ...errors.calls import public
from ...formatting import OneLine
from ...impact.saltation import Saltation, saltation
from ...impact.solver import ImpactSolver
from ...robot.arrays import array_of, floats
from ...scene import JointFriction
from ...scene.coefficients import is_plain
from ...scene.contacts import adheres, turns
from .flow import Flow

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...impact import Impact
    from ..record.trajectory import Trajectory
    from ..simulation import Simulation

__all__ = ["Chain", "Sensitivity", "sensitivity"]

# Times [s] this near are one.
SAME_TIME = 1e-12
# A flow that ends this far [m, rad] from the motion is another one.
ASTRAY = 1e-5
# Two orders of contacts that differ less than this, relatively, are the same.
SAME_ANSWER = 1e-8
MOST_TOGETHER = 4


@public
@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(OneLine):
    """The linear map from deviations (δq, δv) at the start of a motion to those at its end.

    Attributes:
        matrix: (2 nv, 2 nv) Φ, read-only.
        saltations: (time [s], ``Saltation``) of its impacts.
        by_restitution, by_friction: by contact, (2 nv,) how the end changes with its coefficient.
            NaN by the friction of a contact that rests on the way.
        by_controls: (2 nv, nv) how it changes with a torque from outside in each degree of
            freedom, constant from start to end [N m, N]; None unless asked for.
    """

    matrix: np.ndarray
    saltations: tuple[tuple[float, Saltation], ...] = field(repr=False)
    by_restitution: Mapping[str, np.ndarray] = field(default_factory=dict, repr=False)
    by_friction: Mapping[str, np.ndarray] = field(default_factory=dict, repr=False)
    by_controls: np.ndarray | None = field(default=None, repr=False)

    def vjp(self, cotangent: ArrayLike) -> dict[str, Any]:
        """Return the gradient of cotangent · (δq, δv) at the end by all that it changes with.

        Args:
            cotangent: (2 nv,) weights of the end's place, on its tangent, and velocity.

        Raises:
            ShapeError, NotFiniteError.
        """
        w = array_of(floats(cotangent, "cotangent"), (len(self.matrix),), "cotangent")
        nv, start = len(w) // 2, w @ self.matrix
        found: dict[str, Any] = {"q": start[:nv], "v": start[nv:]}
        for name in ("restitution", "friction"):
            table = getattr(self, f"by_{name}")
            found[name] = {contact: float(w @ own) for contact, own in table.items()}
        if self.by_controls is not None:
            found["controls"] = w @ self.by_controls
        return found

    @property
    def exists(self) -> bool:
        """True if every impact on the way has derivatives."""
        return all(item.derivatives.status.exists for _, item in self.saltations)

    @property
    def multipliers(self) -> np.ndarray:
        """(2 nv,) eigenvalues of Φ, the largest first; Floquet's where the motion is periodic."""
        values = np.linalg.eigvals(self.matrix)
        return values[np.argsort(-np.abs(values))]


@public
def sensitivity(motion: Trajectory | Simulation, *, controls: bool = False) -> Sensitivity:
    """The derivative of the final state of a motion by its initial state, across its impacts.

    Impacts enter with their saltation matrices; the motion between them, free or with resting
    contacts, by central differences (error about 1e-8 of the largest entry). Impulses at t = 0
    act at a fixed time; later impacts occur when their contact closes. Contacts that close at
    the same instant have a derivative if their order does not matter.

    Args:
        motion: what ``simulate`` gave, or a ``Simulation``: up to where it is, with the torques
            that were set.
        controls: whether to find ``by_controls``, too.

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
    from ..simulation import Simulation

    if isinstance(motion, Simulation):
        motion = motion.trajectory()
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
    return Chain(motion, controls=controls).followed()


class Chain:
    """Flows and impacts of one motion, one after the other."""

    def __init__(self, motion: Trajectory, *, controls: bool = False) -> None:
        self._motion, self._size = motion, 2 * motion.scene.robot.nv
        self._names = motion.scene.entry_names("contacts")
        self._by_controls = controls
        # By the state at the start, e and µ of each contact, and by torques.
        self._contacts = self._size + np.arange(2 * len(self._names)).reshape(2, -1)
        width = self._size + self._contacts.size
        self._total = np.eye(self._size, width + controls * (self._size // 2))
        self._forced = slice(width, None)
        self._saltations: list[tuple[float, Saltation]] = []
        self._flows: dict[frozenset[str], Flow] = {}

    def followed(self) -> Sensitivity:
        """The whole chain."""
        motion = self._motion
        t, q, v = self._through(motion.impacts)
        if motion.duration > t:
            self._flow(t, motion.duration, q, v)
        total = self._total
        total.setflags(write=False)
        by_e, by_mu = (
            {n: total[:, i] for n, i in zip(self._names, columns, strict=True)}
            for columns in self._contacts
        )
        for rest in motion.rests:
            contact = motion.scene.contacts[self._names.index(rest.contact)]
            if getattr(contact, "friction", 0.0) and rest.end > rest.start + SAME_TIME:
                by_mu[rest.contact] = np.full(self._size, np.nan)
        forced = total[:, self._forced] if self._by_controls else None
        return Sensitivity(total[:, : self._size], tuple(self._saltations), by_e, by_mu, forced)

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
        before = self._total[:, : self._size]
        self._strike(time, impact)
        after = self._flow_of(self._resting(time, 1.0), time)
        return (
            before,
            self._total[:, : self._size],
            after.acceleration(time, impact.q, impact.v_after),
        )

    def _resting(self, t: float, side: float) -> frozenset[str]:
        """The contacts that rest just before (−1) or after (1) a time."""
        at = t + side * SAME_TIME
        return frozenset(r.contact for r in self._motion.rests if r.start < at < r.end)

    def _flow_of(self, resting: frozenset[str], t: float) -> Flow:
        """The flow while some contacts rest, under the torques of a time."""
        flow = self._flows.get(resting)
        if flow is None:
            flow = self._flows[resting] = Flow(self._motion.scene, resting)
        flow.controls = self._motion._path.resting_state(t).controls
        return flow

    def _switches(self) -> Iterator[float]:
        """The times at which torques from outside change."""
        path, last = self._motion._path, np.zeros(0)
        for t in path.step_times.tolist():
            now = path.resting_state(t).controls
            if not np.array_equal(now, last):
                yield t
            last = now

    def _flow(self, start: float, end: float, q: np.ndarray, v: np.ndarray) -> None:
        """Pass a stretch, cut where contacts let go and torques change."""
        ends = {*(r.end for r in self._motion.rests), *self._switches()}
        inside = {t for t in ends if start + SAME_TIME < t < end - SAME_TIME}
        times = [start, *sorted(inside), end]
        for t, until in pairwise(times):
            flow = self._flow_of(self._resting(t, 1.0), t)
            part, q, v = flow.jacobian(t, until, q, v, by_controls=self._by_controls)
            self._total = part[:, : self._size] @ self._total
            self._total[:, self._forced] += part[:, self._size :]
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
            nv = self._size // 2
            for kind, columns in zip(("restitution", "friction"), self._contacts, strict=True):
                for name, own in item.derivatives["v_after", kind].items():
                    self._total[nv:, columns[self._names.index(name)]] += own

    def _saltation(
        self,
        time: float,
        impact: Impact,
        contact: str | None,
        before: frozenset[str],
        after: frozenset[str],
    ) -> Saltation:
        first = self._flow_of(before, max(time - SAME_TIME, 0.0))
        rate = first.acceleration(time, impact.q, impact.v_before)
        second = self._flow_of(after, time)
        return saltation(
            impact,
            contact,
            acceleration_before=rate,
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
            whole = np.eye(self._size)
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
