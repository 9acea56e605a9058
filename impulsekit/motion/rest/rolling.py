"""Contacts that resist rolling and spin while they rest or roll: moments in step with P_n.

Across the normal |M_t| ≤ rolling P_n, and about it |M_n| ≤ torsion P_n; a point that rolls has
M_t = −rolling P_n ω_t/|ω_t|, one that does not has the M_t by which ω̇_t obeys the law of
``laws.product_cones``; spin alike. Which of them move, begin and stop is followed as for slip.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pinocchio as pin

from ...impact.contact_law import Turning
from ...laws.product_cones import IMMOBILE, SMALL, find_cone_impulses
from ...laws.tolerances import RESIDUAL_LIMIT
from ...rows.faint import turning_rows
from ...scene import Collision, Contact, Scene
from ...scene.contacts import turns
from ...tolerances import NONZERO
from ..gaps.contacts import Gaps
from ..gaps.resting import RestingContact
from ..gaps.wandering import MOVE, SLOWEST
from ..tree.pressed import STICKS
from .law import RestNotSolved, cones_of
from .slip import begin_slides, couple_friction, stop_slides, update_slides, write_signs

__all__ = ["RollingRest"]

# Turning below this [rad/s] has no direction of its own.
NO_TURN = 1e-9
# Turning that began, and is slower than this [rad/s], is opposed along its acceleration.
GROWN_SLIP = 1e-7
# Turning that stops sooner than time can tell has stopped, relative to the speeds of the motion.
STOPPED = 1e-6
# Axes that differ by no more than this over MOVE do not turn.
STEADY = 1e-13
# Entries of axes that differ by more than this over MOVE were chosen anew, and did not turn.
CHOSEN_ANEW = 0.1


class PointsAtRest(Protocol):
    """What ``contacts.Resting`` knows of the points that rest."""

    contacts: list[RestingContact]

    def friction(self) -> np.ndarray:
        """(n,) µ by point."""

    def ways(self, slip: np.ndarray, friction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The directions in which forces may act, and µ in them."""

    def note(self, unknowns: np.ndarray, accelerations: np.ndarray, slip: np.ndarray) -> None:
        """Keep what was found."""


class RollingRest:
    """The turning of the points that rest, of contacts that resist it.

    Attributes:
        moments: (3k,) of the last evaluation [N m], two across the normal and one about it.
        rates: (3k,) angular accelerations [rad/s²]. speeds: (3k,) [rad/s].
        normals: (k,) the normal force of each point [N].
    """

    def __init__(self, scene: Scene) -> None:
        self._reach = {
            i: (entry.rolling, entry.torsion)
            for i, entry in enumerate(scene.contacts)
            if isinstance(entry, Contact | Collision) and turns(entry)
        }
        self._last = np.empty(0)
        self._shifted: pin.Data | None = None
        self.moments = self.rates = self.speeds = self.normals = np.empty(0)

    def acts(self, contacts: Sequence[RestingContact]) -> bool:
        """Whether one of these contacts resists turning."""
        return any(contact.entry in self._reach for contact in contacts)

    def points(self, contacts: Sequence[RestingContact]) -> np.ndarray:
        """(k,) which of all points resist turning."""
        found, first = list[int](), 0
        for contact in contacts:
            if contact.entry in self._reach:
                found += range(first, first + contact.count)
            first += contact.count
        return np.array(found, dtype=int)

    def _both(self, contacts: Sequence[RestingContact]) -> tuple[_Turns, _Turns]:
        """Rolling and spin of all points that resist it."""
        own = [contact for contact in contacts if contact.entry in self._reach]
        for contact in own:
            contact.fit_turning()
        reach = [self._reach[c.entry] for c in own for _ in range(c.count)]
        rolling, torsion = np.array(reach).reshape(-1, 2).T
        return _Turns(own, "rolls", rolling), _Turns(own, "spins", torsion)

    def rows(self, gaps: Gaps, contacts: Sequence[RestingContact], data: pin.Data) -> np.ndarray:
        """(3k, nv); ``data`` with joint Jacobians."""
        found = [
            turning_rows(gaps.model, data, joint_ids, axes)
            for joint_ids, axes in self._axes(gaps, contacts, data)
        ]
        return np.vstack(found) if found else np.empty((0, gaps.model.nv))

    def turning(
        self, gaps: Gaps, contacts: Sequence[RestingContact], q: np.ndarray, v: np.ndarray
    ) -> np.ndarray:
        """(3k,) relative angular velocities at a state [rad/s]."""
        gaps.rows(contacts, q)
        return self.rows(gaps, contacts, gaps.data).dot(v)

    def rates_of(
        self,
        gaps: Gaps,
        contacts: Sequence[RestingContact],
        data: pin.Data,
        q: np.ndarray,
        v: np.ndarray,
    ) -> np.ndarray:
        """(3k,) the rows' rates at zero joint acceleration.

        ``data`` with placements, velocities, and accelerations at zero joint acceleration.
        """
        here = self._axes(gaps, contacts, data)
        turned = self._turn_of_axes(gaps, contacts, q, v, here)
        found = []
        for (joint_ids, axes), change in zip(here, turned, strict=True):
            speed, rate = np.zeros(3), np.zeros(3)
            for sign, joint_id in zip((1.0, -1.0), joint_ids, strict=True):
                if joint_id > 0:
                    turn = data.oMi[joint_id].rotation
                    speed += sign * turn.dot(data.v[joint_id].angular)
                    rate += sign * turn.dot(data.a[joint_id].angular)
            found.append(axes.T.dot(rate) + change.T.dot(speed))
        return np.concatenate(found) if found else np.empty(0)

    def _axes(
        self, gaps: Gaps, contacts: Sequence[RestingContact], data: pin.Data
    ) -> list[tuple[tuple[int, int], np.ndarray]]:
        """By point the two bodies and (3, 3) R."""
        found = []
        for contact in contacts:
            if contact.entry in self._reach:
                item = gaps.items[contact.gap]
                spots = item.spots(data)[: contact.count]
                found += [(item.joint_ids, axes) for _, axes in spots]
        return found

    def _turn_of_axes(
        self,
        gaps: Gaps,
        contacts: Sequence[RestingContact],
        q: np.ndarray,
        v: np.ndarray,
        here: list[tuple[tuple[int, int], np.ndarray]],
    ) -> list[np.ndarray]:
        """By point (3, 3) Ṙ, by central differences along the motion."""
        still = [np.zeros((3, 3)) for _ in here]
        size = float(np.abs(v).max(initial=0.0))
        if size == 0.0:
            return still
        if self._shifted is None:
            self._shifted = gaps.model.createData()
        time, sides = MOVE / max(size, SLOWEST), []
        for sign in (1.0, -1.0):
            pin.forwardKinematics(
                gaps.model, self._shifted, pin.integrate(gaps.model, q, sign * time * v)
            )
            sides.append(self._axes(gaps, contacts, self._shifted))
        if not len(sides[0]) == len(sides[1]) == len(here):
            return still
        found = []
        for (_, after), (_, before) in zip(*sides, strict=True):
            change = after - before
            # Tangents may be chosen anew where the normal passes an axis.
            jumps = np.abs(change).max() > CHOSEN_ANEW
            steady = np.abs(change).max() <= STEADY
            found.append(np.zeros((3, 3)) if jumps or steady else change / (2.0 * time))
        return found

    def forces(
        self, resting: PointsAtRest, delassus: np.ndarray, free: np.ndarray, slip: np.ndarray
    ) -> np.ndarray:
        """(3n + 3k,) forces and moments at all points, two tangents and the normal of each.

        Args:
            resting: what rests, which is told the forces.
            delassus: (3n + 3k, 3n + 3k) W.
            free: (3n + 3k,) accelerations without contact forces.
            slip: (3n + 3k,) velocities.

        Raises:
            RestNotSolved: there are none, or they were not found.
        """
        points, n = self.points(resting.contacts), len(resting.friction())
        rolls, spins = self._both(resting.contacts)
        ways, turned = np.eye(len(free)), slip[3 * n :]
        ways[: 3 * n, : 3 * n], friction = resting.ways(slip[: 3 * n], resting.friction())
        rows, normals = 3 * n + np.arange(3 * len(points)).reshape(-1, 3), 3 * points + 2
        for both, own in ((rolls, rows[:, :2]), (spins, rows[:, 2:])):
            speeds = both.part(turned)
            moves = couple_friction(both.ways, speeds, both.reach, NO_TURN, own, normals, ways)
            both.reach = np.where(moves, 0.0, both.reach)
        start = self._last if len(self._last) == len(free) else np.zeros(len(free))
        turning = Turning(points, rolls.reach, spins.reach)
        found = _least_moments(delassus, ways, free, friction, turning, start)
        forces = ways.dot(found)
        rates = free + delassus.dot(forces)
        resting.note(found[: 3 * n], rates[: 3 * n], slip[: 3 * n])
        self._last, self.moments = found, forces[3 * n :]
        self.rates, self.speeds = rates[3 * n :], slip[3 * n :]
        self.normals = forces[2 : 3 * n : 3][points]
        return forces

    def by_point(
        self, contacts: Sequence[RestingContact]
    ) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """By point among all that rest, (3,) its moment [N m] and turning [rad/s]."""
        moments, speeds = self.moments.reshape(-1, 3), self.speeds.reshape(-1, 3)
        points = self.points(contacts).tolist()
        return {i: (moments[j], speeds[j]) for j, i in enumerate(points)}

    def begin(self, contacts: Sequence[RestingContact], speeds: np.ndarray) -> None:
        """After an impact: what turns rolls and spins."""
        for both in self._both(contacts):
            begin_slides(both.part(speeds), both.reach, NO_TURN, both.ways)
            both.keep()
        self.speeds = speeds

    def update(self, contacts: Sequence[RestingContact], *, fresh: bool) -> bool:
        """Which points roll and spin from now on, by the last evaluation; whether that changed."""
        changed, count = False, 3 * len(self.points(contacts))
        if len(self.speeds) != count or len(self.moments) != count:
            return False
        numbers = float(np.abs(self.rates).max(initial=0.0)), NO_TURN, GROWN_SLIP
        for both in self._both(contacts):
            forces = both.part(self.moments)
            forces[2::3] = self.normals
            own = both.part(self.speeds), both.part(self.rates), forces, both.reach
            changed |= update_slides(*own, numbers, fresh, both.ways)
            both.keep()
        return changed

    def heed_stop(
        self, contacts: Sequence[RestingContact], speeds: np.ndarray, fastest: float
    ) -> None:
        """Rolling or spin has stopped, or turned; (3k,) ``speeds`` now."""
        for both in self._both(contacts):
            stop_slides(both.part(speeds), STOPPED * max(1.0, fastest), NO_TURN, both.ways)
            both.keep()

    def signs(self, contacts: Sequence[RestingContact], speeds: np.ndarray) -> np.ndarray:
        """(4k,) below zero where rolling or spin has stopped, or has got going."""
        found = []
        for both in self._both(contacts):
            signs = np.empty((len(both.reach), 3))
            write_signs(both.part(speeds), both.ways, GROWN_SLIP, signs)
            found += [signs[:, 0], signs[:, 2]]
        return np.concatenate(found)

    def still_rows(
        self, gaps: Gaps, contacts: Sequence[RestingContact], data: pin.Data
    ) -> np.ndarray:
        """(m, nv) the rows of loaded points that neither roll nor spin; ``data`` as ``rows``."""
        rows, (rolls, spins) = self.rows(gaps, contacts, data), self._both(contacts)
        if not len(self.normals) == len(rolls.reach) == len(rows) / 3:
            return rows[:0]
        rolling, spinning = (
            (self.normals > 0.0) & (both.reach > 0.0) & (both.ways[:, 2] == STICKS)
            for both in (rolls, spins)
        )
        return rows[np.column_stack([rolling, rolling, spinning]).ravel()]


class _Turns:
    """Rolling or spin of all points that resist it.

    Attributes:
        ways: (k, 3) what they do. reach: (k,) the largest moment over the normal force [m].
    """

    def __init__(self, contacts: Sequence[RestingContact], kind: str, reach: np.ndarray) -> None:
        self._contacts, self._kind, self.reach = contacts, kind, reach
        own = (getattr(contact, kind)[: contact.count] for contact in contacts)
        self.ways = np.concatenate([np.zeros((0, 3)), *own])

    def part(self, turning: np.ndarray) -> np.ndarray:
        """(3k,) of turning, two across the normal and one about it, that of this kind before 0."""
        if self._kind == "rolls":
            return turning.copy()
        found = np.zeros_like(turning)
        found[0::3] = turning[2::3]
        return found

    def keep(self) -> None:
        """Let the contacts have what became of it."""
        first = 0
        for contact in self._contacts:
            setattr(contact, self._kind, self.ways[first : first + contact.count])
            first += contact.count


def _least_moments(
    delassus: np.ndarray,
    ways: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    turning: Turning,
    start: np.ndarray,
) -> np.ndarray:
    """(3n + 3k,) forces and moments that obey the law, before ``ways``.

    Moments are zero where bodies do not turn without them: with moments, a face that slides on
    several points could share its load in many ways, each with another yaw.

    Raises:
        RestNotSolved: there are no such forces, or they were not found.
    """
    n = len(friction)
    coupled = np.ascontiguousarray(delassus.dot(ways))
    mobility, free = delassus.diagonal().copy(), np.ascontiguousarray(free)
    none = np.zeros(len(turning.of))
    held = np.concatenate([np.zeros(3 * n), _by_row(turning.rolling, turning.torsion)]) > 0.0
    if held.any():
        plain = cones_of(friction, Turning(turning.of, none, none), np.zeros(n))
        without, residual, _ = find_cone_impulses(
            coupled, mobility, free, np.where(held, 0.0, start), plain
        )
        if residual <= RESIDUAL_LIMIT:
            # Tangents without friction are rows of nothing: rounding is all that b is there.
            moves = mobility > IMMOBILE * mobility.max()
            unit = np.where(moves, 1.0 / np.sqrt(np.maximum(mobility, NONZERO)), 0.0)
            rates = np.abs(unit * (free + coupled.dot(without)))
            if rates[held].max() <= SMALL * np.abs(unit * free).max():
                return without
    cones = cones_of(friction, turning, np.zeros(n))
    found, residual, _ = find_cone_impulses(coupled, mobility, free, start, cones)
    if not residual <= RESIDUAL_LIMIT:
        raise RestNotSolved(f"residual {residual:.1e}")
    return found


def _by_row(rolling: np.ndarray, torsion: np.ndarray) -> np.ndarray:
    """(3k,) rolling, rolling and torsion [m] by turning row."""
    return np.column_stack([rolling, rolling, torsion]).ravel()
