"""``flat_scene``: what holds and touches a robot, as the native core takes it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ..._core import (
    Ball,
    BallAgainst,
    Blow,
    Carrier,
    ContactKind,
    Feature,
    Held,
    HeldKind,
    Inputs,
    Pair,
    StateRows,
    Term,
)
from ..._core import Contact as CoreContact
from ..._core import Scene as CoreScene
from ..._core import Site as CoreSite
from ...errors import InputError
from ...robot.base import RobotFrame
from ...rows.entries import FramePair, JointRows, Site, rows_of_entry, vectors_of_rows
from ...scene import (
    AppliedImpulse,
    Collision,
    Contact,
    GapContact,
    JointStop,
    Rope,
    Scene,
)
from ...scene.coefficients import EllipticFriction
from ...scene.constraints import KEPT
from ...scene.contacts import turns
from ...scene.gap_functions import FunctionRows
from ...scene.scene import SceneCache, scene_at
from .model import FlatModel, flat_model_of

__all__ = [
    "FlatScene",
    "Flattening",
    "check_directions",
    "flat_of",
    "flat_scene",
]

# Joints and frames of the two bodies of a contact, first the one that receives the impulse.
# A contact, and the name of a point of its bodies.
NamedPoint = tuple[int, Feature]
Ends = tuple[tuple[int, int], tuple[int, int]]
NO_ENDS: Ends = ((0, 0), (0, 0))


@dataclass(frozen=True, eq=False)
class FlatScene:
    """A scene in the core.

    Attributes:
        model: the robot.
        core: what holds and touches it.
        names: of the bilateral rows, such as "constraints[0].x".
        slices: where the rows of each constraint stand.
        vectors: (rows,) a number for each, the same for axes of one velocity.
        functions: of the constraints, and of the contacts, that functions give state by state.
        shaped: the contacts of bodies whose points the core finds from their shapes.
        ends: of each contact; zeros for a joint stop and for functions.
        impulses: the numbers of the known impulses: six of each blow, then those in joints.
        order: where each of them stands among the numbers of the scene's entries.
    """

    model: FlatModel
    core: CoreScene
    names: tuple[str, ...]
    slices: tuple[slice, ...]
    vectors: tuple[int, ...]
    functions: tuple[FunctionRows, ...]
    contact_functions: tuple[FunctionRows, ...]
    shaped: tuple[int, ...]
    ends: tuple[Ends, ...]
    impulses: np.ndarray
    order: list[int]

    def given(self, q: np.ndarray) -> dict[str, Any]:
        """Return the values of users' functions at q, by the names of the core's inputs."""
        given: dict[str, Any] = {}
        if self.functions:
            blocks = [rows.matrix_at(q) for rows in self.functions]
            given["function_rows"] = np.concatenate(blocks).ravel()
        if self.contact_functions:
            parts = [(rows.value(q), rows.matrix_at(q).ravel()) for rows in self.contact_functions]
            given["function_contacts"] = np.concatenate([x for part in parts for x in part])
        return given

    def placements(self, q: np.ndarray) -> Callable[[int], pin.SE3]:
        """A function that gives the placement of a joint in the world at q."""
        places = self.model.core.placements(q).reshape(-1, 12)

        def placement_of(joint_id: int) -> pin.SE3:
            numbers = places[self.model.bodies[joint_id]]
            return pin.SE3(numbers[:9].reshape(3, 3), numbers[9:])

        return placement_of

    def rows(
        self,
        q: np.ndarray,
        v: np.ndarray,
        jacobian: np.ndarray | None = None,
        only: Sequence[bool] | None = None,
    ) -> StateRows:
        """The rows at a state.

        Args:
            q, v: (nq,), (nv,).
            jacobian: Pinocchio's of all joints, ``data.J``, in place of the core's own columns.
            only: of each contact whether it takes part, whatever its gap; None for those that
                touch.

        Raises:
            InputError: a line between points that coincide, an axis of friction along a normal.
        """
        given: dict[str, Any] = self.given(q)
        if only is not None:
            given["only"] = only
        found = self.core.rows(q, v, jacobian, Inputs(**given) if given else None)
        check_directions(found)
        return found


def check_directions(rows: StateRows) -> None:
    """Check that lines and axes of friction have a direction at a state.

    Raises:
        InputError: a line between points that coincide, an axis of friction along a normal.
    """
    if rows.without_line >= 0:
        raise InputError(
            "the two points of a DistanceAnchor or a Rope coincide: no line joins them; move "
            "one of them, or use a PointAnchor"
        )
    if rows.without_ellipse >= 0:
        raise InputError(
            f"contacts[{rows.without_ellipse}]: the axis `along` of its EllipticFriction is "
            "along the normal here; give one in the plane of the contact"
        )


def flat_of(scene: Scene) -> FlatScene:
    """The scene in the core, made once and kept with it."""
    return _flats.of(scene)


def flat_scene(scene: Scene, model: FlatModel | None = None) -> FlatScene:
    """The scene in the core. ``model``: of its robot, if that is there already."""
    return Flattening(scene, model or flat_model_of(scene.robot)).done()


_flats: SceneCache[FlatScene] = SceneCache(flat_scene)


class Flattening:
    """A scene on its way into the core."""

    def __init__(self, scene: Scene, model: FlatModel) -> None:
        self._scene, self._robot, self._model = scene, scene.robot, model
        self._core = CoreScene(model.core)
        self._functions: list[FunctionRows] = []
        self._contact_functions: list[FunctionRows] = []
        self._shaped: list[int] = []
        self._ends: list[Ends] = []

    def done(self) -> FlatScene:
        names, slices, vectors = self._hold()
        self._touch_all()
        impulses, order = self._strike()
        return FlatScene(
            self._model, self._core, names, slices, vectors, tuple(self._functions),
            tuple(self._contact_functions), tuple(self._shaped), tuple(self._ends),
            impulses, order,
        )  # fmt: skip

    def _strike(self) -> tuple[np.ndarray, list[int]]:
        """Bring the known impulses over: their numbers as the core has them, and where these stood.

        Those of blows come first, then those in joints.
        """
        numbers: list[float] = []
        blows: list[int] = []
        kicks: list[int] = []
        for entry in self._scene.impulses:
            first = len(numbers)
            if isinstance(entry, AppliedImpulse):
                site = Site.of(self._robot, entry.frame, entry.at)
                blow = Blow(site=self._model.site(site), is_local=entry.axes == "local")
                self._core.add_blow(blow)
                numbers += entry.values
                blows += range(first, len(numbers))
            else:
                numbers += entry.values
                kicks += range(first, len(numbers))
                joint = self._robot.model.joints[self._robot.joint_id(entry.joint)]
                for v in range(joint.idx_v, joint.idx_v + joint.nv):
                    self._core.add_kick(v)
        order = blows + kicks
        return np.array([numbers[i] for i in order], dtype=float), order

    def _hold(self) -> tuple[tuple[str, ...], tuple[slice, ...], tuple[int, ...]]:
        scene = scene_at(self._scene, 0.0)
        names: list[str] = []
        slices: list[slice] = []
        velocity: list[float] = []
        kept: list[bool] = []
        locks: list[int] = []
        entries = [rows_of_entry(self._robot, entry) for entry in scene.held]
        controls = len(scene.held) - len(scene.constraints)
        for k, (entry, said, name) in enumerate(
            zip(scene.held, entries, scene.entry_names("held"), strict=True)
        ):
            count, keeps = len(said.labels), entry.velocity == KEPT
            locks += self._hold_entry(said, is_control=k >= len(entries) - controls)
            slices.append(slice(len(names), len(names) + count))
            names += [f"{name}.{label}" for label in said.labels]
            after: Any = 0.0 if keeps else entry.velocity
            velocity += np.broadcast_to(np.asarray(after, dtype=float), count).tolist()
            kept += [keeps] * count
        passive = [x == 0.0 and not k for x, k in zip(velocity, kept, strict=True)]
        vectors = vectors_of_rows(entries)
        self._core.set_rows(velocity, kept, list(vectors), passive, locks)
        return tuple(names), tuple(slices), vectors

    def _hold_entry(self, said: Any, is_control: bool) -> list[int]:
        """Bring a constraint over; of each row the one speed that it prescribes, or −1."""
        count = len(said.labels)
        if isinstance(said, FramePair):
            held = Held(kind=HeldKind.pair, frames=self._pair(said))
            self._core.add_held(held, list(said.select))
        elif isinstance(said, FunctionRows):
            self._core.add_held(Held(kind=HeldKind.functions, count=count))
            self._functions.append(said)
        else:
            idx_vs = self._robot.model.idx_vs
            terms = [
                Term(row=row, v=idx_vs[joint] + degree, factor=factor)
                for row, parts in enumerate(said.terms)
                for joint, degree, factor in parts
            ]
            stop = self._own_stop(said) if is_control else -1
            self._core.add_held(Held(kind=HeldKind.speeds, count=count, terms=terms, stop=stop))
            if said.whole_joint:
                return [term.v for term in terms]
        return [-1] * count

    def _own_stop(self, said: JointRows) -> int:
        """The stop that the control of a joint yields to; −1 if there is none."""
        name = self._robot.model.names[said.terms[0][0][0]]
        stops = [
            i
            for i, contact in enumerate(self._scene.contacts)
            if isinstance(contact, JointStop) and contact.joint == name
        ]
        return stops[0] if stops else -1

    def _pair(self, said: FramePair) -> Pair:
        return Pair(
            first=self._model.site(said.first),
            other=self._model.site(said.other),
            coincides=said.coincides,
            carrier=Carrier[said.carrier],
            axes=np.ascontiguousarray(said.axes),
        )

    def _touch_all(self) -> None:
        for index, entry in enumerate(self._scene.contacts):
            self._ends.append(self._touch(entry, index))

    def _touch(self, entry: Any, index: int) -> Ends:
        core, robot = self._core, self._robot
        if isinstance(entry, JointStop):
            joint = robot.model.joints[robot.joint_id(entry.joint)]
            lower, upper = entry.limits(robot)
            stop = {"q": joint.idx_q, "v": joint.idx_v, "lower": lower, "upper": upper}
            core.add_contact(CoreContact(kind=ContactKind.stop, **stop))
            return NO_ENDS
        if isinstance(entry, GapContact):
            core.add_contact(CoreContact(kind=ContactKind.functions))
            self._contact_functions.append(FunctionRows(robot, entry))
            return NO_ENDS
        if isinstance(entry, Collision):
            return self._add_body_contact(entry, index)
        said = rows_of_entry(robot, entry)
        if not isinstance(said, FramePair):
            raise TypeError(type(entry).__name__)
        contact = CoreContact(frames=self._pair(said))
        if isinstance(entry, Rope):
            contact.kind, contact.limit = ContactKind.rope, entry.length
        else:
            contact.turns = turns(entry)
            self._rub(entry, said.other.frame, contact)
        core.add_contact(contact)
        first, other = said.first.frame, said.other.frame
        return (first.joint_id, other.joint_id), (first.frame_id, other.frame_id)

    def _rub(self, entry: Contact | Collision, touched: RobotFrame, contact: CoreContact) -> None:
        """Bring over the axes of friction by direction, in the frame that is touched."""
        if isinstance(entry.friction, EllipticFriction):
            contact.ellipse_body = self._model.bodies[touched.joint_id]
            contact.along = touched.rotation.dot(entry.friction.along)

    def _add_body_contact(self, entry: Collision, index: int) -> Ends:
        from ...robot.geometry import geometry_ids
        from ...rows.bodies import bodies_of

        robot, objects = self._robot, self._robot.collision_model.geometryObjects
        ids = [geometry_ids(robot, name)[0] for name in (entry.first, entry.other)]
        pieces, bodies = [objects[own[0]] for own in ids], bodies_of(robot, entry)
        both = bodies.first, bodies.other
        ball = _ball_of(pieces) if len(ids[0]) == len(ids[1]) == 1 else None
        contact = CoreContact(limit=bodies.margin, turns=turns(entry))
        contact.first, contact.other = (body.shapes for body in both)
        if ball is None:
            sites = [
                CoreSite(body=self._model.bodies[body.joint_id], frame=body.frame_id)
                for body in both
            ]
            contact.kind = ContactKind.shapes
            self._shaped.append(index)
        else:
            sites = [
                self._model.site(_site_of(piece))
                for piece in (pieces if ball.sign > 0.0 else pieces[::-1])
            ]
            contact.kind, contact.shape = ContactKind.ball, ball
        contact.frames = Pair(first=sites[0], other=sites[1])
        _, joint_id, frame_id, _ = both[1]
        touched = RobotFrame.of(frame_id, joint_id, robot.model.frames[frame_id].placement)
        self._rub(entry, touched, contact)
        self._core.add_contact(contact)
        return (both[0].joint_id, both[1].joint_id), (both[0].frame_id, both[1].frame_id)


def _site_of(piece: Any) -> Site:
    return Site(RobotFrame.of(piece.parentFrame, piece.parentJoint, piece.placement))


def _ball_of(pieces: Sequence[Any]) -> Ball | None:
    """A ball and what it may touch, if one of two pieces is one."""
    import coal

    sign = 1.0 if isinstance(pieces[0].geometry, coal.Sphere) else -1.0
    ball, other = pieces if sign > 0.0 else pieces[::-1]
    shape = other.geometry
    if not isinstance(ball.geometry, coal.Sphere):
        return None
    if isinstance(shape, coal.Sphere):
        kind, size = BallAgainst.ball, (shape.radius, 0.0, 0.0)
    elif isinstance(shape, coal.Box):
        kind, size = BallAgainst.box, tuple(shape.halfSide)
    elif isinstance(shape, coal.Cylinder):
        kind, size = BallAgainst.cylinder, (shape.radius, shape.halfLength, 0.0)
    elif isinstance(shape, coal.Capsule):
        kind, size = BallAgainst.capsule, (shape.radius, shape.halfLength, 0.0)
    else:
        return None
    if any(piece.geometry.getSweptSphereRadius() for piece in pieces):
        return None
    return Ball(kind=kind, radius=float(ball.geometry.radius), size=np.array(size), sign=sign)
