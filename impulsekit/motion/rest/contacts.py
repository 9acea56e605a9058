"""The contacts that rest: which of their points slide, and which way."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from ...errors import InputError
from ...scene import JointFriction, Scene
from ...scene.contacts import turns
from ...scene.friction import friction_at
from ..gaps.resting import RestingContact
from ..tree.pressed import Sliding
from .joints import TORN, DryJoints
from .rolling import RollingRest
from .settle import next_slide
from .turn import direction_of_slip

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

    def slides(self) -> list[np.ndarray | None]:
        """By point: the direction in which it slides, or None."""
        found: list[np.ndarray | None] = []
        for contact in self.contacts:
            contact.fit()
            found += contact.slides[: contact.count]
        return found

    def begins(self) -> list[bool]:
        """By point: whether its slip has just begun."""
        return [begins for c in self.contacts for begins in c.begins[: c.count]]

    def friction(self) -> np.ndarray:
        """(n,) µ by point: of one that sticks, or has begun to slide."""
        if not self._measured:
            return np.array([c.friction for c in self.contacts for _ in range(c.count)])
        found: list[float] = []
        for contact in self.contacts:
            own = self._measured.get(contact.entry)
            for k in range(contact.count):
                slides = k < len(contact.slides) and contact.slides[k] is not None
                # The least speed there is: what slides has its kinetic friction.
                moved = own is not None and slides
                found.append(max(friction_at(own, TINY), TINY) if moved else contact.friction)
        return np.array(found)

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
            contact.entry in self._measured and any(s is None for s in contact.slides)
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
                if contact.entry in self._measured and contact.slides[k] is None:
                    force, rate = forces[len(found)], rates[len(found)]
                    own = bar - float(np.hypot(rate[0], rate[1]))
                    across = float(np.hypot(force[0], force[1]))
                    if tear and across and own <= (1.0 - WITH_IT) * bar:
                        contact.slides[k], contact.begins[k] = -force[:2] / across, True
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
        owners = [c.entry for c in self.contacts for _ in range(c.count)]
        speeds = np.hypot(slip[0::3], slip[1::3]).tolist()
        return np.array(
            [
                friction_at(self._measured[entry], max(speed, TINY))
                if entry in self._measured
                else mu
                for entry, speed, mu in zip(owners, speeds, friction.tolist(), strict=True)
            ]
        )

    def ways_of_slip(self) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) of points the direction of slip, and 1 for those that slide; (n,) ``begins``."""
        slides = self.slides()
        ways = np.zeros((len(slides), 3))
        for way, start in zip(ways, slides, strict=True):
            if start is not None:
                way[0], way[1], way[2] = start[0], start[1], 1.0
        return ways, np.array(self.begins(), dtype=bool)

    def slide_as(self, ways: np.ndarray, begins: np.ndarray) -> None:
        """Let contacts of one point each do what ``ways_of_slip`` would tell of them."""
        for contact, way, starts in zip(self.contacts, ways.tolist(), begins.tolist(), strict=True):
            contact.count = 1
            contact.slides = [np.array(way[:2]) if way[2] else None]
            contact.begins = [starts]

    def slide(self) -> bool:
        """Whether some point slides."""
        slides = self.slides()
        return any(s is not None and not b for s, b in zip(slides, self.begins(), strict=True))

    def slowest_slide(self) -> float:
        """The least slip of points that slide, by the last evaluation [m/s]; infinity for none."""
        speeds = np.hypot(self.slip[0::3], self.slip[1::3])
        slides = [s is not None for s in self.slides()]
        return (
            float(np.min(speeds[slides], initial=np.inf)) if len(speeds) == len(slides) else np.inf
        )

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
        found = self._sliding()
        if self._keeps:
            self._kept = found
        return found

    def _sliding(self) -> Sliding:
        slides, begins = self.slides(), self.begins()
        ways = np.zeros((len(slides), 3))
        for way, start, grows in zip(ways, slides, begins, strict=True):
            if start is not None and not grows:
                way[0], way[1], way[2] = start[0], start[1], 1.0
        return Sliding(self.friction(), ways, self.slow, self.negligible)

    def ways(self, slip: np.ndarray, friction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(3n, 3n) contact forces from the unknowns, and (n,) µ of what does not slide.

        Where a point slides, its friction goes with its normal force: P = P_n (−µ s, 1).
        """
        friction = friction.copy()
        moving = self._sliding_friction(friction, slip) if self._measured else friction.copy()
        ways = np.eye(3 * len(friction))
        slides = self.slides()
        for i, (start, begins) in enumerate(zip(slides, self.begins(), strict=True)):
            if start is None or begins:
                continue
            at = 3 * i
            s = self._direction(slip[at : at + 2], start)
            ways[at : at + 2, at : at + 2] = 0.0
            ways[at : at + 2, at + 2] = -moving[i] * s
            friction[i] = 0.0
        return ways, friction

    def _direction(self, slip: np.ndarray, start: np.ndarray) -> np.ndarray:
        """(2,) unit: that of slip, and where it is slow the one in which it began."""
        return direction_of_slip(slip, start, self.slow)

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
        self.slip = slip
        i = 0
        for contact in self.contacts:
            own = slip[3 * i : 3 * (i + contact.count)].reshape(-1, 3)[:, :2]
            speeds = np.sqrt(np.einsum("ij,ij->i", own, own)).tolist()
            contact.slides = [
                way / speed if contact.friction and speed > self.slow else None
                for way, speed in zip(own, speeds, strict=True)
            ]
            contact.begins = [False] * contact.count
            i += contact.count

    def update_slides(self, *, fresh: bool) -> bool:
        """Which points slide from now on, by the last evaluation; whether that has changed.

        Args:
            fresh: after an impact slip decides alone, for nothing is known of before.
        """
        changed = self.joints is not None and self.joints.tear()
        friction, i = self.friction(), 0
        largest = float(np.abs(self.accelerations).max(initial=0.0))
        for contact in self.contacts:
            contact.fit()
            for k in range(contact.count):
                before = contact.slides[k], contact.begins[k]
                now = self._slide(i, *before, (float(friction[i]), largest), fresh)
                changed |= (before[0] is None, before[1]) != (now[0] is None, now[1])
                contact.slides[k], contact.begins[k] = now
                i += 1
        if self.rolling is not None:
            changed |= self.rolling.update(self.contacts, fresh=fresh)
        return changed

    def _slide(
        self,
        i: int,
        before: np.ndarray | None,
        begins: bool,
        numbers: tuple[float, float],
        fresh: bool,
    ) -> tuple[np.ndarray | None, bool]:
        """Where a point slides, or None; and whether that has just begun.

        ``numbers``: µ, and the largest acceleration of a point [m/s²].
        """
        slip1, slip2, _ = self.slip[3 * i : 3 * i + 3].tolist()
        rate1, rate2, _ = self.accelerations[3 * i : 3 * i + 3].tolist()
        force1, force2, normal = self.forces[3 * i : 3 * i + 3].tolist()
        if self._measured and begins and np.hypot(slip1, slip2) <= self.slow:
            # What has torn off has no slip yet but by rounding.
            slip1 = slip2 = 0.0
        way, starts = next_slide(
            (0.0, 0.0, 0.0) if before is None else (float(before[0]), float(before[1]), 1.0),
            begins,
            (slip1, slip2),
            (rate1, rate2),
            (force1, force2, normal),
            (*numbers, self.slow, self.grown),
            fresh,
        )
        return np.array(way[:2]) if way[2] else None, starts
