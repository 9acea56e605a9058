"""The rows of a scene's constraints and contacts as tables for the kernels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pinocchio as pin

from ..impact.yielding import own_stops
from ..robot import Robot
from ..rows.bodies import bodies_of
from ..rows.entries import FramePair, FunctionRows, Site, frame_pair, rows_of_entry
from ..rows.faint import faintest_mobility
from ..scene import Collision, Contact, JointStop, Scene
from ..scene.at_time import scene_at
from ..scene.constraints import KEPT
from ..scene.contacts import turns
from ..scene.friction import is_plain
from ..scene.restitution import Restitution, RestitutionTable
from .balls import ball_of
from .errors import NoKernelError
from .followers import Follower
from .kernels.layout import (
    ALONG_DOF,
    BODY_FLOATS,
    CONTACT_FLOATS,
    COUPLE,
    EXPONENT,
    FAINTEST,
    FORCE_AT,
    STIFFNESS,
)
from .tree import Tree

__all__ = ["RowMaker", "RowTables", "row_tables"]

# Integers and numbers of a term, see ``layout``.
Term = tuple[tuple[int, int, int, int, int, int], np.ndarray]


@dataclass(eq=False)
class RowTables:
    """Rows, bilateral ones first.

    Attributes:
        terms: of each row, the integers and the six numbers of each term, see ``layout``.
        target, keeps: of each bilateral row.
        contact_ints, contact_floats: one line a contact.
        restitution_tables: (2k,) speeds and values of contacts that have such a table.
        restitution, friction: of each contact.
        meeting_ints, meeting_floats, ways, ball_ints, ball_floats: see ``layout``.
    """

    terms: list[list[Term]] = field(default_factory=list)
    target: list[float] = field(default_factory=list)
    keeps: list[bool] = field(default_factory=list)
    contact_ints: list[tuple[int, ...]] = field(default_factory=list)
    contact_floats: list[np.ndarray] = field(default_factory=list)
    restitution_tables: list[np.ndarray] = field(default_factory=list)
    restitution: list[float] = field(default_factory=list)
    friction: list[float] = field(default_factory=list)
    meeting_ints: list[tuple[int, ...]] = field(default_factory=list)
    meeting_floats: list[np.ndarray] = field(default_factory=list)
    ways: list[int] = field(default_factory=list)
    ball_ints: list[tuple[int, ...]] = field(default_factory=list)
    ball_floats: list[np.ndarray] = field(default_factory=list)


def row_tables(
    scene: Scene,
    tree: Tree,
    *,
    frictional: bool,
    followers: Sequence[Follower] = (),
    places: Mapping[int, int] | None = None,
) -> RowTables:
    """The rows of a scene on its tree, those of joints that follow others before all.

    Args:
        frictional: give every contact its tangent rows, whatever its own friction.
        places: by index of a contact whose point varies, the joint that stands there.

    Raises:
        NoKernelError: an entry that needs the solver of single states.
    """
    tables = RowTables()
    maker = RowMaker(scene.robot, tree, tables)
    for one in followers:
        own, leader = (tree.first_dof(joint_id) for joint_id in (one.joint_id, one.leader_id))
        tables.terms.append([_along(own, 1.0), _along(leader, -one.ratio)])
        tables.target.append(0.0)
        tables.keeps.append(False)
    for constraint in scene_at(scene, 0.0).held:
        rows = maker.constraint(constraint)
        keeps = constraint.velocity == KEPT
        after = np.asarray(0.0 if keeps else constraint.velocity, dtype=float)
        tables.terms.extend(rows)
        tables.target.extend(np.broadcast_to(after, len(rows)).tolist())
        tables.keeps.extend([keeps] * len(rows))
    if own_stops(scene):
        raise NoKernelError("a controlled joint with a stop, which yields where it meets it")
    faintest = faintest_mobility(float(tree.floats.reshape(-1, BODY_FLOATS)[:, 12].sum()))
    for index, contact in enumerate(scene.contacts):
        first = len(tables.terms)
        rows, entry, meeting, numbers = maker.contact(contact, (places or {}).get(index))
        friction = getattr(contact, "friction", 0.0)
        if not is_plain(friction):
            raise NoKernelError("friction other than a number")
        if len(rows) == 3 and not friction and not frictional:
            rows = rows[2:]
        restitution: Any = contact.restitution
        capture = 0.0
        table_at = len(scene.contacts) * CONTACT_FLOATS
        table_at += sum(len(one) for one in tables.restitution_tables)
        points = 0
        if isinstance(restitution, Restitution):
            restitution, capture = restitution.value, restitution.capture_speed
        elif isinstance(restitution, RestitutionTable):
            points = len(restitution.speeds)
            tables.restitution_tables.append(np.array([*restitution.speeds, *restitution.values]))
            restitution = 0.0
        elif callable(restitution):
            raise NoKernelError("a restitution that is a function of one's own")
        numbers[11], numbers[12] = getattr(contact, "tangential_restitution", 0.0), capture
        if scene.law.restitution == "lzb":
            numbers[STIFFNESS], numbers[EXPONENT] = contact.stiffness, scene.law.exponent
        if not isinstance(contact, JointStop):
            numbers[FAINTEST] = faintest
        tables.terms.extend(rows)
        ball = len(tables.ball_ints) - 1 if isinstance(contact, Collision) else -1
        tables.contact_ints.append((first, len(rows), entry, meeting, table_at, points, ball))
        tables.contact_floats.append(numbers)
        tables.restitution.append(restitution)
        tables.friction.append(friction)
    return tables


class RowMaker:
    """Makes rows out of the entries of a scene."""

    def __init__(self, robot: Robot, tree: Tree, tables: RowTables) -> None:
        self._robot, self._tree, self._tables = robot, tree, tables

    def site(self, site: Site) -> tuple[int, np.ndarray, np.ndarray]:
        """The body of a point, it in the body's axes, and the axes of its frame there."""
        body = self._tree.body(site.joint_id) if site.moves else 0
        turn = self._tree.turns[body]
        return body, turn.T @ site.placement.translation, turn.T @ site.placement.rotation

    def dof(self, joint: str) -> tuple[int, int]:
        """The first degree of freedom of a joint, and how many it has."""
        item = self._robot.model.joints[self._robot.joint_id(joint)]
        if item.nv == 0:
            raise NoKernelError(f'what acts in joint "{joint}", which follows another')
        return self._tree.first_dof(self._robot.joint_id(joint)), item.nv

    def constraint(self, entry: Any) -> list:
        """Rows, each a list of terms."""
        said = rows_of_entry(self._robot, entry)
        if isinstance(said, FramePair):
            if said.carrier == "line":
                raise NoKernelError(f"a {type(entry).__name__}")
            return self._pair(said)
        if isinstance(said, FunctionRows):
            raise NoKernelError(f"a {type(entry).__name__}")
        for name in entry.joint_names:
            self.dof(name)
        first_dof = self._tree.first_dof
        return [
            [_along(first_dof(joint_id) + degree, factor) for joint_id, degree, factor in terms]
            for terms in said.terms
        ]

    def _pair(self, said: FramePair) -> list:
        (body, point, axes), (other, other_point, _) = map(self.site, (said.first, said.other))
        meeting = -1
        if other > 0 and said.coincides:
            meeting = self._meeting(body, other, point, None)
        turns = said.carrier == "first"
        around = body if turns else 0
        axes = axes @ said.axes if turns else said.axes
        ends = (body, around, point, -1), (other, around, other_point, meeting)
        return _terms(ends, [(row > 2, axes[:, row % 3]) for row in said.select])

    def _meeting(self, body: int, other: int, point: np.ndarray, normal: np.ndarray | None) -> int:
        """A meeting of two bodies at a point of the first, with a normal of the other."""
        tables, tree = self._tables, self._tree
        way, other_way = tree.path(body), tree.path(other)
        while way and other_way and way[0] == other_way[0]:
            del way[0], other_way[0]
        begin = len(tables.ways)
        tables.ways.extend((*way, *other_way))
        middle = begin + len(way)
        tables.meeting_ints.append(
            (body, other, begin, middle, len(tables.ways), int(normal is not None))
        )
        along = np.zeros(3) if normal is None else normal
        tables.meeting_floats.append(np.concatenate([point, along]))
        return len(tables.meeting_ints) - 1

    def contact(self, entry: Any, place: int | None = None) -> tuple[list, int, int, np.ndarray]:
        """Rows t₁, t₂, n of a contact (one of a stop), entry of q of a stop, meeting, numbers.

        ``place``: the joint at its point, where that varies.
        """
        numbers = np.zeros(CONTACT_FLOATS)
        if isinstance(entry, JointStop):
            numbers[9:11] = entry.limits(self._robot)
            rows = self.constraint(entry)
            return rows, self._robot.model.idx_qs[self._robot.joint_id(entry.joint)], -1, numbers
        if getattr(entry, "adhesion", 0.0):
            raise NoKernelError("contacts that adhere")
        if turns(entry):
            raise NoKernelError("contacts that resist rolling or spin")
        if isinstance(entry, Collision):
            return self._ball(entry)
        if not isinstance(entry, Contact):
            raise NoKernelError(f"a {type(entry).__name__}")
        said = frame_pair(self._robot, entry)
        if place is not None:
            said = replace(
                said, first=replace(said.first, joint_id=place, placement=pin.SE3.Identity())
            )
        if said.other.moves:
            return self._on_moving_plane(said)
        numbers[:9] = said.axes.ravel()
        return self._pair(said), -1, -1, numbers

    def _on_moving_plane(self, said: FramePair) -> tuple[list, int, int, np.ndarray]:
        (body, point, _), (other, _, axes) = map(self.site, (said.first, said.other))
        meeting = self._meeting(body, other, point, axes @ said.axes[:, 2])
        ends = (body, 0, point, -1), (other, 0, point, meeting)
        rows = _terms(ends, [(False, along) for along in np.eye(3)], meeting)
        return rows, -1, meeting, np.zeros(CONTACT_FLOATS)

    def _ball(self, entry: Collision) -> tuple[list, int, int, np.ndarray]:
        """A ball and what may touch it; its point and normal are found state by state."""
        ball = ball_of(self._robot, entry)
        tree, tables = self._tree, self._tables
        body, other = (tree.body(i) if i > 0 else 0 for i in ball.joint_ids)
        turn, other_turn = tree.turns[body], tree.turns[other]
        centre = turn.T @ ball.centre
        meeting = self._meeting(body, other, centre, None)
        # A second one, for the arm on the ball's own body.
        self._meeting(body, other, centre, None)
        tables.ball_ints.append((body, other, meeting, ball.kind, ball.sign))
        placement = (other_turn.T @ ball.rotation).ravel(), other_turn.T @ ball.translation
        tables.ball_floats.append(np.concatenate([centre, [ball.radius], *placement, ball.sizes]))
        ends = (body, 0, centre, meeting + 1), (other, 0, ball.translation, meeting)
        rows = _terms(ends, [(False, ball.sign * along) for along in np.eye(3)], meeting)
        numbers = np.zeros(CONTACT_FLOATS)
        numbers[9] = bodies_of(self._robot, entry).margin
        return rows, -1, meeting, numbers


def _along(dof: int, factor: float) -> Term:
    return (ALONG_DOF, 0, 0, dof, -1, -1), np.array([0.0, 0.0, 0.0, factor, 0.0, 0.0])


def _terms(
    ends: Sequence[tuple[int, int, np.ndarray, int]],
    directions: Iterable[tuple[bool, np.ndarray]],
    axes: int = -1,
) -> list[list[Term]]:
    """Rows of the first end against the other, each a list of terms.

    Args:
        ends: the body, the one in whose axes directions are, the point, the meeting with the arm.
        directions: of each row, whether it turns about it, and (3,) the direction.
        axes: the meeting in whose axes directions are instead; -1 for none.
    """
    rows: list[list[Term]] = []
    for turns_about, direction in directions:
        kind, terms = COUPLE if turns_about else FORCE_AT, []
        for sign, (body, around, point, arm) in zip((1.0, -1.0), ends, strict=True):
            if body > 0:
                numbers = np.concatenate([point, sign * direction])
                terms.append(((kind, body, around, 0, arm, axes), numbers))
        rows.append(terms)
    return rows
