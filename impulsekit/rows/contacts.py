"""Which contacts touch at a configuration, and the rows of their relative velocity.

Each touching point has three rows, two tangents and the normal: u = Rᵀ (v_frame −
v_against), with R = [t₁ t₂ n] in the world.
"""

from __future__ import annotations

from collections.abc import Container
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..geometry.axes import contact_axes
from ..geometry.gaps import AT_STOP, before_limit, is_closed
from ..robot import Robot
from ..scene import Collision, Contact, GapContact, JointStop, Rope, Scene
from ..scene.coefficients import EllipticFriction
from ..scene.contacts import turns
from .ellipses import axis_in_plane, ellipse_of
from .entries import FunctionRows, frame_pair, joint_rows
from .faint import cleared, farthest, rows_at, turning_rows
from .pair import Pair, sizes_of_terms
from .reach import ReachedModel

__all__ = ["ContactRows", "PairContact", "Touch", "ellipse_axis"]


class Touch(NamedTuple):
    """One touching point.

    Attributes:
        entry: the index of the contact in the scene.
        axes: (3, 3) columns t₁, t₂, n in the world; None for a joint stop.
        joint_ids, frame_ids: of the two bodies in the whole model, first the one that
            receives the impulse; (0, 0) for a joint stop.
        jacobian: (3, nv) of the model the rows were made for.
        position: (3,) world [m], where it came with the touching; None where it is the
            contact's own point, or for a joint stop.
        gap: [m], likewise.
        turns: −1; where the rows are those of the relative turning, Rᵀ (ω_frame − ω_against)
            [rad/s], the index of the touch whose point they belong to.
        turn: (3, 3) from the frame that is touched to the world, where friction asks for it.
    """

    entry: int
    axes: np.ndarray | None
    joint_ids: tuple[int, int]
    frame_ids: tuple[int, int]
    jacobian: np.ndarray
    position: np.ndarray | None = None
    gap: float | None = None
    turns: int = -1
    turn: np.ndarray | None = None


def ellipse_axis(friction: object, touch: Touch) -> np.ndarray | None:
    """(2,) unit: the first axis of an ellipse in the tangents of a touch; None of other friction.

    Raises:
        InputError: it is along the normal.
    """
    if not isinstance(friction, EllipticFriction) or touch.axes is None or touch.turn is None:
        return None
    return axis_in_plane(friction, touch.axes, touch.turn, touch.entry)


class ContactRows:
    """The contacts of a scene on a reached model."""

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        self.model = reached.model
        self._entries = [
            _compiled(scene.robot, reached, entry, i) for i, entry in enumerate(scene.contacts)
        ]
        self._turning = {i for i, entry in enumerate(scene.contacts) if turns(entry)}
        self._joint_id = reached.joint_id
        self._elliptic = {
            i: found
            for i, entry in enumerate(scene.contacts)
            if isinstance(entry, Contact | Collision)
            and (found := ellipse_of(scene.robot, reached, entry, i)) is not None
        }
        self._plain = not (self._turning or self._elliptic)
        self._needs_places = not self._plain or any(e.needs_places for e in self._entries)

    def touching(
        self, data: pin.Data, q: np.ndarray, only: Container[int] | None = None
    ) -> list[Touch]:
        """The touching points at q, with their rows.

        ``only``: the indices of the contacts that take part. A joint stop among them
        counts as touched at its nearer limit. None for all, by the rules of the scene. After all
        points come the rows of the turning of those that resist it.
        """
        if self._needs_places:
            pin.computeJointJacobians(self.model, data, q)
        touches: list[Touch] = []
        for i, entry in enumerate(self._entries):
            if only is None:
                entry.touch(touches, self.model, data, q)
            elif i in only:
                if isinstance(entry, _AtStop):
                    entry.touch_nearer(touches, q)
                elif isinstance(entry, _OfFunctions):
                    entry.touch_anyway(touches, q)
                elif isinstance(entry, _Taut):
                    entry.touch_anyway(touches, data)
                else:
                    entry.touch(touches, self.model, data, q)
        return touches if self._plain else self._with_more(data, touches)

    def plain_points(self) -> list[PairContact]:
        """The contacts, if all are points on planes that stand still, and plain; else none."""
        points = [entry for entry in self._entries if type(entry) is PairContact]
        plain = self._plain and all(point.stands_still for point in points)
        return points if plain and len(points) == len(self._entries) else []

    def _with_more(self, data: pin.Data, touches: list[Touch]) -> list[Touch]:
        """The touches with what ellipses need, and those of turning after them."""
        if self._elliptic:
            touches = [
                touch._replace(turn=self._elliptic[touch.entry].turn_in_world(data))
                if touch.entry in self._elliptic
                else touch
                for touch in touches
            ]
        if self._turning:
            touches += [
                self._turned(data, touch, i)
                for i, touch in enumerate(touches)
                if touch.entry in self._turning
            ]
        return touches

    def _turned(self, data: pin.Data, touch: Touch, index: int) -> Touch:
        if touch.axes is None:
            raise TypeError("a joint stop does not turn")
        joint_ids = self._joint_id(touch.joint_ids[0]), self._joint_id(touch.joint_ids[1])
        rows = turning_rows(self.model, data, joint_ids, touch.axes)
        return touch._replace(jacobian=rows, turns=index)


class PairContact:
    """A point against a plane, which may move.

    Attributes:
        needs_places: whether ``touch`` takes ``data`` with joint Jacobians.
        stands_still: whether the plane is the world's.
        jacobian_at: (3, nv) its rows, from ``data`` and q; of those that are zero the rounding.
    """

    def __init__(
        self, robot: Robot, reached: ReachedModel, entry: Contact | Rope, index: int
    ) -> None:
        said = frame_pair(robot, entry)
        self._pair = pair = Pair(reached, said)
        self._index = index
        self._bodies = (
            (said.first.joint_id, said.other.joint_id),
            (said.first.frame_id, said.other.frame_id),
        )
        # A point on a plane in the world is the commonest contact, and the quickest.
        self.needs_places = not pair.is_alone
        self.stands_still = pair.is_alone and said.carrier == "world"
        self._model, self._joint_ids = reached.model, (pair.first.joint_id, pair.other.joint_id)
        self._rubs = isinstance(entry, Contact) and entry.friction != 0.0
        self._is_free, self.jacobian_at = pair.is_free, pair.jacobian

    def rows(self, data: pin.Data, q: np.ndarray | None = None) -> np.ndarray:
        """(3, nv) the rows; zero where they are rounding. Without q, of ``data`` with Jacobians."""
        rows = self._pair.rows(data) if q is None else self._pair.jacobian(data, q)
        if self._is_free:
            return rows

        def sizes() -> np.ndarray:
            if q is not None:
                pin.forwardKinematics(self._model, data, q)
            points = [placement.translation for placement in self._pair.placements(data)]
            arm = farthest(self._model, data, self._joint_ids, points)
            return sizes_of_terms(*self._pair.ends(data, q), arm)[:3]

        return cleared(rows, sizes, rubs=self._rubs)

    def touch_of(self, data: pin.Data, jacobian: np.ndarray) -> Touch:
        """The touching point with its rows."""
        return Touch(self._index, self._pair.axes(data), *self._bodies, jacobian)

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        rows = self.rows(data, None if self.needs_places else q)
        touches.append(self.touch_of(data, rows))


class _Taut(PairContact):
    """Two points on a rope, which touch where it is stretched."""

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Rope, index: int) -> None:
        super().__init__(robot, reached, entry, index)
        self._length = entry.length

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        if is_closed(self._gap(data), self._length):
            self.touch_anyway(touches, data)

    def touch_anyway(self, touches: list[Touch], data: pin.Data) -> None:
        """Touch whatever the length."""
        touches.append(self.touch_of(data, self.rows(data))._replace(gap=self._gap(data)))

    def _gap(self, data: pin.Data) -> float:
        return self._length - self._pair.distance(data)


class _OfFunctions:
    """A gap that is a function of q."""

    needs_places = False

    def __init__(self, robot: Robot, entry: GapContact, index: int) -> None:
        self._index, self._said = index, FunctionRows(robot, entry)

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        if self._said.value(q)[0] <= AT_STOP:
            self.touch_anyway(touches, q)

    def touch_anyway(self, touches: list[Touch], q: np.ndarray) -> None:
        """Touch whatever the gap."""
        gap, rows = float(self._said.value(q)[0]), self._said.matrix_at(q)
        touches.append(Touch(self._index, np.eye(3), (0, 0), (0, 0), rows, gap=gap))


class _AtStop:
    """A joint at one of its limits."""

    needs_places = False

    def __init__(self, robot: Robot, reached: ReachedModel, entry: JointStop, index: int) -> None:
        said = joint_rows(robot, entry)
        (((joint_id, _, _),),) = said.terms
        self._index = index
        self._entry_in_q = reached.model.idx_qs[reached.joint_id(joint_id)]
        (row,) = said.matrix(reached.model, reached.joint_id)
        lower, upper = entry.limits(robot)
        self._sides = []
        for limit, sign in ((lower, 1.0), (upper, -1.0)):
            jacobian = np.zeros((3, reached.model.nv))
            jacobian[2] = sign * row
            self._sides.append((limit, sign, jacobian))

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        for limit, sign, jacobian in self._sides:
            gap = float(before_limit(q[self._entry_in_q], limit, sign))
            if is_closed(gap, limit):
                touches.append(Touch(self._index, None, (0, 0), (0, 0), jacobian, gap=gap))

    def touch_nearer(self, touches: list[Touch], q: np.ndarray) -> None:
        """Touch the limit that is nearer, however far it is."""
        at = q[self._entry_in_q]
        limit, sign, jacobian = min(self._sides, key=lambda side: before_limit(at, *side[:2]))
        gap = float(before_limit(at, limit, sign))
        touches.append(Touch(self._index, None, (0, 0), (0, 0), jacobian, gap=gap))


class _Colliding:
    """Two bodies whose geometry meets somewhere."""

    needs_places = True

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Collision, index: int) -> None:
        from .bodies import bodies_of

        self._index, self._bodies = index, bodies_of(robot, entry)
        first, other = self._bodies.joint_ids
        self._reached_ids = (reached.joint_id(first), reached.joint_id(other))

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        from ..geometry.collision import meeting_points

        first, other = (
            [(solid, data.oMi[joint_id] * placement) for solid, placement in pieces]
            for pieces, joint_id in zip(self._bodies.pieces, self._reached_ids, strict=True)
        )
        for point in meeting_points(first, other, self._bodies.margin):
            axes = contact_axes(point.normal)
            rows = rows_at(model, data, self._reached_ids, point.position, axes)
            touches.append(
                Touch(
                    self._index,
                    axes,
                    self._bodies.joint_ids,
                    self._bodies.frame_ids,
                    rows,
                    point.position,
                    point.gap,
                )
            )


def _compiled(
    robot: Robot, reached: ReachedModel, entry: object, index: int
) -> PairContact | _AtStop | _Colliding | _OfFunctions:
    if isinstance(entry, JointStop):
        return _AtStop(robot, reached, entry, index)
    if isinstance(entry, Collision):
        return _Colliding(robot, reached, entry, index)
    if isinstance(entry, Rope):
        return _Taut(robot, reached, entry, index)
    if isinstance(entry, GapContact):
        return _OfFunctions(robot, entry, index)
    if not isinstance(entry, Contact):
        raise TypeError(type(entry).__name__)
    return PairContact(robot, reached, entry, index)
