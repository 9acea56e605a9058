"""The contacts that rest: which of their points slide, and which way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from ...errors import InputError
from ...scene import JointFriction, Scene
from ...scene.coefficients import friction_at
from ...scene.contacts import turns
from ..gaps.resting import NO_WAYS, RestingContact
from ..tree.pressed import BEGINS, SLIDES, STICKS, Sliding
from .joints import TORN, DryJoints
from .rolling import RollingRest
from .slip import begin_slides, couple_friction, stop_slides, update_slides

__all__ = ["Resting"]

# Slip below this [m/s] has no direction of its own, whatever the capture speed.
NO_SLIP = 1e-9
# The slip [m/s] of what has begun to slide.
TINY = 1e-300
# With a point that breaks away do all that slip with at least this part of TORN.
WITH_IT = 0.5
# What a pull holds has let go where it parts with more than this share: until it is told the pull
# goes on.
PARTED = 1e-10


class Resting:
    """All contacts that rest at one time.

    Attributes:
        contacts: in the order in which their rows are stacked.
        forces: (3n,) of the last evaluation [N]: two tangents and the normal each, with ``pulls``.
        accelerations: (3n,) of the contact points [m/s²].
        slip: (3n,) their velocities [m/s].
        slow: slip below this keeps the direction in which it began [m/s]. Slower slip turns
            ever faster, at a rate of µ P_n / (m |slip|), which no explicit method can follow.
        grown: slip that began, and is slower than this [m/s], is opposed by friction along its
            acceleration: that is where it turns to, within a time of slip / (µ P_n / m). Steps
            are not held up by it. 0 where nobody watches for its end.
        size: the largest acceleration of the contact points without contact forces at the last
            evaluation, or by what holds one of them alone [m/s²].
        joints: those with dry friction; None without any.
        negligible: accelerations that are nowhere above this are zero [m/s²]. Where all stands
            still without a force they are the squares of rounding, which contradict each other.
    """

    def __init__(self, scene: Scene) -> None:
        self.contacts: list[RestingContact] = []
        self.slow, self.grown, self.negligible, self.size = NO_SLIP, 0.0, 0.0, 0.0
        self.forces = self.accelerations = self.slip = np.empty(0)
        self._last = np.empty(0)
        dry = any(isinstance(f, JointFriction) and f.torque for f in scene.forces)
        self.joints = DryJoints(scene) if dry else None
        self._rolling = RollingRest(scene) if any(map(turns, scene.contacts)) else None
        if dry and self._rolling is not None:
            raise InputError(
                "simulate: JointFriction and contacts with rolling or torsion in one scene are "
                "not supported; leave out one of them"
            )
        # By contact, friction by slip speed. Ellipses have µ = 1 in the axes of their gaps.
        friction = [getattr(entry, "friction", 0.0) for entry in scene.contacts]
        self._measured = {i: own for i, own in enumerate(friction) if callable(own)}
        pulls = [getattr(entry, "holding_force", 0.0) for entry in scene.contacts]
        self._pulls = np.array(pulls) if any(pulls) else None
        self._keeps = False
        self._kept: Sliding | None = None

    @property
    def acts(self) -> bool:
        """Whether something rests: contacts, or joints with dry friction that stand still."""
        return bool(self.contacts) or (self.joints is not None and len(self.joints.still) > 0)

    @property
    def rolling(self) -> RollingRest | None:
        """What resists rolling and spin, where something that rests now does."""
        own = self._rolling
        return own if own is not None and own.acts(self.contacts) else None

    @property
    def is_compiled(self) -> bool:
        """Whether compiled code has words for what rests."""
        if not (self._measured or self._rolling) and self._pulls is None:
            return True
        own = any(contact.entry in self._measured for contact in self.contacts)
        return self.rolling is None and not own and self.pulls() is None

    def slips(self) -> np.ndarray:
        """(n, 3) what all points do, copied."""
        for contact in self.contacts:
            contact.fit()
        return np.concatenate([NO_WAYS, *(c.slips[: c.count] for c in self.contacts)])

    def slip_as(self, ways: np.ndarray) -> None:
        """Let points do from now on what is told (n, 3)."""
        first = 0
        for contact in self.contacts:
            contact.slips = ways[first : first + contact.count]
            first += contact.count

    def _by_point(self, own: Callable[[RestingContact], float]) -> np.ndarray:
        """(n,) of each point what its contact has."""
        return np.array([own(c) for c in self.contacts for _ in range(c.count)])

    def friction(self) -> np.ndarray:
        """(n,) µ by point: of one that sticks, or has begun to slide."""
        static = self._by_point(lambda contact: contact.friction)
        if not self._measured:
            return static
        slips, owners = self.slips(), self._by_point(lambda contact: contact.entry)
        for i in np.flatnonzero(slips[:, 2] != STICKS).tolist():
            if (own := self._measured.get(int(owners[i]))) is not None:
                # The least speed there is: what slides has its kinetic friction.
                static[i] = max(friction_at(own, TINY), TINY)
        return static

    def pulls(self) -> np.ndarray | None:
        """(n,) the force that holds each point to what it touches [N]; None where none does.

        With F̂ = F + pull n the law is that of a contact that pushes: ``forces`` has F̂.
        """
        if self._pulls is None:
            return None
        found = self._pulls[[c.entry for c in self.contacts for _ in range(c.count)]]
        return found if found.any() else None

    @property
    def may_tear(self) -> bool:
        """Whether some point sticks by a static friction of its own, or is held by a pull."""
        return self.pulls() is not None or any(
            contact.entry in self._measured and (contact.slips[:, 2] == STICKS).any()
            for contact in self.contacts
        )

    @contextmanager
    def held(self) -> Iterator[None]:
        """Within it forces are solved for without a start from the last ones.

        Shares of redundant points must not depend on earlier evaluations.
        """
        last, self._last = self._last, np.empty(0)
        try:
            yield
        finally:
            self._last = last

    def left_to_tear(self, *, tear: bool = False) -> np.ndarray:
        """(n,) margin until static friction lets points slip, or what holds them lets go [m/s²].

        Points hold as long as they can together, however they share the load: one of several at
        the edge of its own cone does not slip. Infinity for all others. By the last evaluation.
        ``tear``: those that slip begin to slide.
        """
        found: list[float] = []
        forces, rates = self.forces.reshape(-1, 3), self.accelerations.reshape(-1, 3)
        bar = TORN * self.size
        for contact in self.contacts:
            for k in range(contact.count):
                own = np.inf
                if contact.entry in self._measured and contact.slips[k, 2] == STICKS:
                    force, rate = forces[len(found)], rates[len(found)]
                    own = bar - float(np.hypot(rate[0], rate[1]))
                    across = float(np.hypot(force[0], force[1]))
                    if tear and across and own <= (1.0 - WITH_IT) * bar:
                        contact.slips[k] = *(-force[:2] / across), BEGINS
                found.append(own)
        margins, pulls = np.array(found), self.pulls()
        if pulls is not None:
            margins = np.where(
                pulls > 0.0, np.minimum(margins, PARTED * self.size - rates[:, 2]), margins
            )
        return margins

    def lets_go(self) -> np.ndarray:
        """(n,) which points that a pull held have parted from it, by the last evaluation."""
        pulls = self.pulls()
        if pulls is None:
            return np.zeros(len(self.forces) // 3, dtype=bool)
        return (pulls > 0.0) & (self.accelerations[2::3] > WITH_IT * PARTED * self.size)

    def _sliding_friction(self, friction: np.ndarray, slip: np.ndarray) -> np.ndarray:
        """(n,) µ of points at their slip (3n,) [m/s], where it depends on that."""
        owners = self._by_point(lambda contact: contact.entry).tolist()
        speeds = np.hypot(slip[0::3], slip[1::3]).tolist()
        return np.array(
            [
                friction_at(self._measured[entry], max(speed, TINY))
                if entry in self._measured
                else mu
                for entry, speed, mu in zip(owners, speeds, friction.tolist(), strict=True)
            ]
        )

    def slide(self) -> bool:
        """Whether some point slides."""
        return bool((self.slips()[:, 2] == SLIDES).any())

    def slowest_slide(self) -> float:
        """The least slip of points that slide, by the last evaluation [m/s]; infinity for none."""
        speeds, slide = np.hypot(self.slip[0::3], self.slip[1::3]), self.slips()[:, 2] != STICKS
        return float(np.min(speeds[slide], initial=np.inf)) if len(speeds) == len(slide) else np.inf

    @contextmanager
    def unchanged(self) -> Iterator[None]:
        """Within it no point begins or ceases to slide: what is told of them is put down once."""
        self._keeps = True
        try:
            yield
        finally:
            self._keeps, self._kept = False, None

    def sliding(self) -> Sliding:
        """What is known of all points, for compiled code."""
        if self._kept is not None:
            return self._kept
        own = self.slow, self.grown, self.negligible
        found = Sliding(self.friction(), self.slips(), *own)
        if self._keeps:
            self._kept = found
        return found

    def ways(self, slip: np.ndarray, friction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(3n, 3n) contact forces from the unknowns, and (n,) µ of what does not slide.

        Where a point slides, its friction goes with its normal force: P = P_n (−µ s, 1).
        """
        moving = self._sliding_friction(friction, slip) if self._measured else friction
        ways, rows = np.eye(3 * len(friction)), np.arange(3 * len(friction)).reshape(-1, 3)
        own = self.slips(), slip, moving, self.slow
        sliding = couple_friction(*own, rows[:, :2], rows[:, 2], ways)
        return ways, np.where(sliding, 0.0, friction)

    def last_forces(self, points: int) -> np.ndarray:
        """(3n,) unknowns to start from."""
        return self._last if len(self._last) == 3 * points else np.zeros(3 * points)

    def note(self, unknowns: np.ndarray, accelerations: np.ndarray, slip: np.ndarray) -> None:
        """Keep what was found at the last evaluation."""
        self._last = unknowns
        self.forces, self.accelerations, self.slip = unknowns, accelerations, slip

    def loaded(self) -> np.ndarray:
        """(n,) which points push."""
        return self.forces[2::3] > 0.0

    def begin(self, slip: np.ndarray) -> None:
        """After an impact: what slips slides. (3n,) ``slip`` of the contact points [m/s].

        Forces are asked for only then: points that slip cannot be held without contradiction.
        """
        self.slip, slips = slip, self.slips()
        friction = self._by_point(lambda contact: contact.friction)
        begin_slides(slip, friction, self.slow, slips)
        self.slip_as(slips)

    def heed_stop(self, slip: np.ndarray, ended: float, still: float) -> None:
        """Slip (3n,) has stopped or turned; see ``stop_slides``."""
        slips = self.slips()
        stop_slides(slip, ended, still, slips)
        self.slip_as(slips)

    def update_slides(self, *, fresh: bool) -> bool:
        """Which points slide from now on, by the last evaluation; whether that has changed.

        Args:
            fresh: after an impact slip decides alone, for nothing is known of before.
        """
        changed = self.joints is not None and self.joints.tear()
        slips, slip = self.slips(), self.slip
        if self._measured:
            # What has torn off has no slip yet but by rounding.
            own = slip.reshape(-1, 3).copy()
            own[(slips[:, 2] == BEGINS) & (np.hypot(own[:, 0], own[:, 1]) <= self.slow), :2] = 0.0
            slip = own.ravel()
        largest = float(np.abs(self.accelerations).max(initial=0.0))
        changed |= update_slides(
            slip,
            self.accelerations,
            self.forces,
            self.friction(),
            (largest, self.slow, self.grown),
            fresh,
            slips,
        )
        self.slip_as(slips)
        if self.rolling is not None:
            changed |= self.rolling.update(self.contacts, fresh=fresh)
        return changed
