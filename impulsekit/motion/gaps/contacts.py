"""How far contacts are from touching, how fast they close, and their rows where they rest."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from ...geometry.point_table import ROUNDED, Table, table_of
from ...rows.point_rows import gaps_and_rates, rounding_of
from ...rows.reach import ReachedModel
from ...scene import Collision, Contact, GapContact, JointStop, Rope, Scene
from ...scene.functions import numbers_from
from ..tree.memory import Memory
from ..tree.pressed import rows_and_bias
from ..zeros.windows import Turning
from .pairs import Held, Pairs, pairs_of, write_gaps
from .points import PointTables
from .rated import FunctionGap, PlaneGap, RopeGap, StopGap
from .resting import RestingContact
from .turning_planes import Pose

__all__ = ["Gaps"]


class Gaps:
    """The gaps of all contacts of a scene, in its order; a joint stop has two.

    Attributes:
        items: one by one.
        entries: (m,) the contact each belongs to.
        rated: (m,) whether a gap comes with its rate. tabled: (m,) whether compiled code has it.
        arms: (k,) of the tabled ones, what besides its place it is the sum of [m, rad].
        all_rated: whether every gap comes with its rate.
        rated_table: those that are tabled; None without any.
        turning: how fast bodies turn. model: that they are of.
        has_conditions: whether some contacts count only while a condition holds.
    """

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        self.model = reached.model
        self.items: list = []
        names = scene.entry_names("contacts")
        for i, entry in enumerate(scene.contacts):
            if isinstance(entry, Contact):
                self.items.append(PlaneGap(scene.robot, reached, entry, i))
            elif isinstance(entry, GapContact):
                self.items.append(FunctionGap(scene.robot, entry, i, names[i]))
            elif isinstance(entry, Rope):
                self.items.append(RopeGap(scene.robot, reached, entry, i))
            elif isinstance(entry, JointStop):
                limits = entry.limits(scene.robot)
                self.items += [
                    StopGap(scene.robot, reached, entry, i, side)
                    for side in (0, 1)
                    if np.isfinite(limits[side])
                ]
            elif isinstance(entry, Collision):
                # coal is loaded only where bodies may collide.
                from .colliding import CollidingGap

                self.items.append(CollidingGap(scene.robot, reached, entry, i))
        self.entries = np.array([item.entry for item in self.items], dtype=int)
        self.rated = np.array([item.has_rate for item in self.items], dtype=bool)
        self.all_rated = bool(self.rated.all())
        self.turning = Turning(reached.model)
        self._conditions: dict[int, tuple[Callable[[Any, Any], Any], str]] = {
            i: (entry.active, name)
            for i, (entry, name) in enumerate(
                (scene.contacts[item.entry], names[item.entry]) for item in self.items
            )
            if getattr(entry, "active", None) is not None
        }
        self.has_conditions = bool(self._conditions)
        self._memory: Memory | None = None
        # Functions of users have rates, but are in no table.
        self._functions = [i for i, item in enumerate(self.items) if isinstance(item, FunctionGap)]
        self.tabled = self.rated.copy()
        self.tabled[self._functions] = False
        rows = [row for i in np.flatnonzero(self.tabled) for row in self.items[i].in_table()]
        self.rated_table = table_of(rows) if rows else None
        self.arms = np.array([self.items[i].arms for i in np.flatnonzero(self.tabled)])
        self._tables = PointTables(self.items, self.rated)

    @property
    def data(self) -> pin.Data:
        """A workspace, with placements and velocities of the state measured last."""
        return self._shown.data

    def counts(self, i: int, q: np.ndarray, v: np.ndarray) -> bool:
        """Whether a gap that closes at a state is a contact by the condition of its entry.

        Raises:
            CallbackError, ShapeError, NotFiniteError: the user's function failed.
        """
        found = self._conditions.get(i)
        if found is None:
            return True
        return bool(numbers_from(found[0], f"{found[1]}: active", 1, q, v)[0] > 0.0)

    @cached_property
    def paired(self) -> np.ndarray:
        """(m,) which gaps are of bodies whose pairs of pieces are all known to compiled code."""
        return np.array(
            [
                not rated and all(pair.is_closed for pair in item.pairs)
                for item, rated in zip(self.items, self.rated, strict=True)
            ],
            dtype=bool,
        )

    @cached_property
    def pairs(self) -> Pairs:
        """All pairs of pieces of bodies that may collide, of the gaps that are ``paired``."""
        own = [(i, self.items[i]) for i in np.flatnonzero(self.paired).tolist()]
        return pairs_of([(i, item.joint_ids, item.pairs) for i, item in own])

    @cached_property
    def _balls(self) -> np.ndarray:
        """(m, 8) around both bodies of each gap that comes without a rate."""
        balls = np.zeros((len(self.items), 8))
        for i in np.flatnonzero(~self.rated).tolist():
            balls[i] = self.items[i].balls
        return balls

    def are_rated(self, contacts: Sequence[RestingContact]) -> bool:
        """Whether the gaps of contacts come with their rates."""
        return self.all_rated or all(self.rated[contact.gap] for contact in contacts)

    @property
    def _shown(self) -> Memory:
        # Made late: frames are added to the model until all is compiled.
        if self._memory is None:
            self._memory = Memory(self.model)
        return self._memory

    def measure(
        self, q: np.ndarray, v: np.ndarray, which: Sequence[int] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """(m,) gaps and (m,) their rates, NaN where none comes with it or none is asked for.

        ``which``: the indices of the gaps asked for; None for those that come with a rate.
        """
        memory = self._shown
        pin.forwardKinematics(self.model, memory.data, q, v)
        count = len(self.items)
        found = np.full((2, count), np.nan)
        if self.rated_table is not None:
            own = gaps_and_rates(
                self.rated_table,
                memory.places,
                memory.speeds,
                np.ascontiguousarray(q),
                np.ascontiguousarray(v),
            )
            if own.shape[1] == count:
                found = own
            else:
                found[:, self.tabled] = own
        for i in self._functions:
            found[:, i] = self.items[i].gap_and_rate(q, v)
        if which is not None and not self.all_rated:
            asked = np.zeros(count, dtype=bool)
            asked[list(which)] = True
            asked &= ~self.rated
            for i in np.flatnonzero(asked & ~self.paired).tolist():
                found[0, i] = self.items[i].distance(memory.data)
            asked &= self.paired
            if asked.any():
                write_gaps(self.pairs, self._balls, memory.places, asked, found[0])
        return found[0], found[1]

    def move(self, q: np.ndarray, v: np.ndarray) -> None:
        """Let ``data`` have the placements and velocities of a state."""
        pin.forwardKinematics(self.model, self.data, q, v)

    def pose(self, joint_id: int) -> Pose:
        """Of a joint's frame in ``data``, in world axes."""
        place, motion = self.data.oMi[joint_id], self.data.v[joint_id]
        turn = place.rotation.copy()
        return Pose(
            turn, place.translation.copy(), turn.dot(motion.linear), turn.dot(motion.angular)
        )

    def everything(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As ``measure``, with the distances of colliding bodies."""
        return self.measure(q, v, range(len(self.items)))

    def rows_and_bias(
        self, contacts: Sequence[RestingContact], q: np.ndarray, v: np.ndarray, memory: Memory
    ) -> tuple[np.ndarray, np.ndarray]:
        """(3n, nv) rows of contacts and (3n,) their rates at zero joint acceleration.

        ``memory`` with placements, velocities, and accelerations at zero joint acceleration.
        """
        data, table = memory.data, self.table(contacts)
        pin.computeJointJacobians(self.model, data)
        if table is not None and memory.kinematics is not None:
            return rows_and_bias(table, memory.kinematics)
        rows, biases = [], []
        for contact in contacts:
            item = self.items[contact.gap]
            own = item.rows(data, q)
            contact.count = len(own) // 3
            rows.append(own)
            biases.append(item.bias(data, q, v, own))
        return np.vstack(rows), np.concatenate(biases)

    def rows_and_bias_at(
        self, contacts: Sequence[RestingContact], q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same at a state of which nothing is known yet."""
        pin.forwardKinematics(self.model, self.data, q, v, np.zeros(self.model.nv))
        return self.rows_and_bias(contacts, q, v, self._shown)

    def table(self, contacts: Sequence[RestingContact]) -> Table | None:
        """All points of contacts; None where some are found anew at each state."""
        return self._tables.of(contacts)

    def ends_of_held(self, contacts: Sequence[RestingContact]) -> Held | None:
        """Where held points of contacts end; None where some are not of pairs or not held."""
        return self._tables.ends_of_held(contacts, self.pairs, self.paired)

    def hold(self, contacts: Sequence[RestingContact], q: np.ndarray) -> None:
        """Follow the points at which polyhedra touch at q from here on; let go of all others."""
        if self.all_rated:
            return
        pin.forwardKinematics(self.model, self.data, q)
        resting = {contact.gap for contact in contacts}
        for i in np.flatnonzero(~self.rated).tolist():
            self.items[i].hold(self.data if i in resting else None)

    def rounding(self, i: int, gap: float) -> float:
        """By how much a gap of this size with a rate, measured last, is rounded [m, rad]."""
        if self.rated_table is None or not self.tabled[i]:
            # Of a user's function it is not known what its terms are: of the order of 1.
            return ROUNDED * (gap + 1.0)
        k = int(np.count_nonzero(self.tabled[:i]))
        return float(rounding_of(self.rated_table, k, self._shown.places, float(self.arms[k]), gap))

    def let_go_of_rising(
        self,
        contacts: Sequence[RestingContact],
        q: np.ndarray,
        v: np.ndarray,
        speed: float,
        chattering: Collection[int] = (),
    ) -> None:
        """Let go of held points whose gap opens faster than ``speed`` [m/s].

        Of gaps that are ``chattering`` only of what would come back above the capture speed.
        """
        if self.all_rated:
            return
        pin.computeJointJacobians(self.model, self.data, q)
        for contact in contacts:
            item = self.items[contact.gap]
            if not self.rated[contact.gap] and item.held is not None:
                rising = item.rows(self.data, q).dot(v)[2::3]
                least = item.capture_speed if contact.gap in chattering else item.rest_speed
                item.keep(rising <= max(speed, least))

    def let_go(self, contact: RestingContact, gone: np.ndarray | None = None) -> bool:
        """Let go of a contact, or of those of its points that are ``gone`` (k,).

        Returns:
            Whether it could be done: points that are found anew each time are not held.
        """
        item = self.items[contact.gap]
        if self.rated[contact.gap] or item.held is None:
            return False
        if gone is None:
            item.hold(None)
            return True
        item.keep(~gone)
        contact.fit()
        contact.keep(~gone)
        return True

    def of_points(
        self, contacts: Sequence[RestingContact], q: np.ndarray, v: np.ndarray
    ) -> np.ndarray:
        """(n,) the gaps of resting points [m]: of a held one its own."""
        held = {
            c.gap for c in contacts if not self.rated[c.gap] and self.items[c.gap].held is not None
        }
        values, _ = self.measure(q, v, [c.gap for c in contacts if c.gap not in held])
        return np.concatenate(
            [
                self.items[c.gap].held_gaps(self.data)
                if c.gap in held
                else np.full(c.count, values[c.gap])
                for c in contacts
            ]
        )

    def beyond_held(
        self, contacts: Sequence[RestingContact], q: np.ndarray, v: np.ndarray
    ) -> tuple[float, np.ndarray]:
        """Whether bodies touch elsewhere than where they are held.

        Returns:
            By how much the smallest gap of a pair is below those of its held points [m],
            negative where it is, and of one whose points are found anew below zero; and (n,) how
            far each resting point is from where its face or edge ends [m], infinite where it isn't
            held.
        """
        own = [c for c in contacts if not self.rated[c.gap] and self.items[c.gap].exact]
        values, _ = self.measure(q, v, [c.gap for c in own])
        below, inside = np.inf, []
        for contact in contacts:
            item = self.items[contact.gap]
            if contact not in own or item.held is None:
                inside.append(np.full(contact.count, np.inf))
                if contact in own:
                    below = min(below, float(values[contact.gap]) + item.drift(self.data))
                continue
            held = item.held_gaps(self.data)
            below = min(below, float(values[contact.gap] - held.min(initial=0.0)))
            inside.append(item.held_inside(self.data))
        return below, np.concatenate(inside) if inside else np.empty(0)

    def velocities(
        self, contacts: Sequence[RestingContact], q: np.ndarray, v: np.ndarray
    ) -> np.ndarray:
        """(3n,) tangential and normal velocities of contacts."""
        return self.rows(contacts, q).dot(v)

    def rows(self, contacts: Sequence[RestingContact], q: np.ndarray) -> np.ndarray:
        """(3n, nv) rows of contacts."""
        data, table = self.data, self.table(contacts)
        pin.computeJointJacobians(self.model, data, q)
        if table is not None and self._shown.kinematics is not None:
            return rows_and_bias(table, self._shown.kinematics)[0]
        rows = [self.items[contact.gap].rows(data, q) for contact in contacts]
        for contact, own in zip(contacts, rows, strict=True):
            contact.count = len(own) // 3
        return np.vstack(rows) if rows else np.empty((0, self.model.nv))
