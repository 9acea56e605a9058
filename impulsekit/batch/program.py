"""``Program``: a scene as the kernels take it, made once for all states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..impact.singular import has_uneven_masses
from ..laws.words import END, LZB, NEWTON, SEQUENTIAL, STRONGE
from ..robot.massless import is_always_regular
from ..rows.entries import Site
from ..rows.reach import branch_of, touched_joints
from ..scene import Law, Scene
from .errors import NoKernelError
from .followers import Follower, freed_model, pointed_model
from .kernels import given as by_name
from .kernels import layout
from .kernels.words import words_of
from .rows import row_tables
from .tables import in_world, known_tables, load_tables, path_mask, row_arrays, tree_tables
from .tree import KINDS, Tree, tree_of

__all__ = ["BatchPlan", "Program", "compiled"]


@dataclass(frozen=True)
class BatchPlan:
    """How a batch is solved.

    Attributes:
        kernel: whether compiled kernels do it; False: ``solve``, one row after the other, as
            with a restitution that is a function of one's own, or a ``Collision`` of other
            shapes than a ball with a ball, box, cylinder or capsule. Threads gain nothing
            there, the workers of a client do.
        rows: how many rows of constraints and contacts a state has.
        why: a sentence for each choice.
    """

    kernel: bool
    rows: int
    why: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Program:
    """The tables of a scene; see ``kernels.given`` for the tuples.

    Attributes:
        own_rows: how many rows are not the scene's: those of joints that follow others.
        columns: of each known impulse by entry name: first column and how many.
        given: (columns,) the impulses of the scene itself.
        restitution, friction: (contacts,) those of the scene itself.
        words: of the law, see ``laws.words``.
    """

    tree: Tree
    sizes: by_name.Sizes
    tables: by_name.Tree
    sets: by_name.Sets
    known: by_name.Known
    loads: tuple[np.ndarray, ...]
    rows: by_name.Rows
    meetings: tuple[np.ndarray, ...]
    balls: tuple[np.ndarray, ...]
    held: tuple[np.ndarray, ...]
    contacts: tuple[np.ndarray, ...]
    columns: dict[str, tuple[int, int]]
    given: np.ndarray
    restitution: np.ndarray
    friction: np.ndarray
    own_rows: int
    words: tuple[int, int, int]

    @property
    def needs_law(self) -> bool:
        """Whether there is more to the rows than one contact on a plane under ``Law()``."""
        if len(self.rows.first) == 1:
            return False
        ints = self.contacts[0]
        alone = len(self.held[0]) == 0 and len(ints) == layout.CONTACT_INTS and ints[2] < 0
        return not (alone and ints[5] == 0 and ints[6] < 0 and self.words == words_of(Law()))

    def touch(self, contacts: tuple[np.ndarray, ...]) -> by_name.Touch | None:
        """Rows, with the tables of contacts that count; None where there are none."""
        if len(self.rows.first) == 1:
            return None
        ints, floats = contacts
        held, words = self.held, self.words
        return by_name.Touch(self.rows, self.meetings, self.balls, held, ints, floats, words)

    def moving(self) -> by_name.Moving:
        """The robot, and what acts on it from outside."""
        return by_name.Moving(
            self.tables, self.sizes, self.places(), self.sets, self.loads, self.known
        )

    def places(self) -> layout.Places:
        """Where in the work array things begin."""
        tree, rows = self.tree, len(self.rows.first) - 1
        loads = len(set(self.loads[0][:: layout.LOAD_INTS].tolist()))
        meetings = len(self.meetings[0]) // layout.MEETING_INTS
        terms = len(self.rows.term_ints) // layout.TERM_INTS
        balls = len(self.balls[0]) // layout.BALL_INTS
        return layout.places(tree.bodies, tree.nq, tree.nv, rows, loads, meetings, terms, balls)


def compiled(
    scene: Scene, *, frictional: bool, links: Sequence[str] = (), pointed: Sequence[int] = ()
) -> tuple[Program | None, BatchPlan]:
    """The program of a scene, or None where the kernels do not know how, and the plan.

    Args:
        frictional: whether frictions are given that may be more than 0 where the scene's are 0.
        links: those whose masses vary.
        pointed: indices of the contacts whose points vary.
    """
    try:
        program = _program(scene, frictional, links, pointed)
    except NoKernelError as reason:
        return None, BatchPlan(False, 0, (f"state by state: {reason}",))
    count = len(program.rows.first) - 1
    moving = program.tree.bodies - len(pointed)
    why = [
        f"kernel: articulated bodies over {moving} joints, "
        f"{scene.robot.model.njoints - 1 - moving} left out"
    ]
    if count:
        why.append(f"{count} rows of constraints and contacts, Delassus matrix by response")
    return program, BatchPlan(True, count, tuple(why))


def _program(
    scene: Scene, frictional: bool, links: Sequence[str], pointed: Sequence[int]
) -> Program:
    robot = scene.robot
    words = words_of(scene.law if scene.contacts else Law())
    model, followers, joints = _moved(scene)
    sites = [Site.of(robot, scene.contacts[index].frame_names[0]) for index in pointed]
    if not all(site.moves for site in sites):
        raise NoKernelError("points that vary on what is fixed")
    own_joints = model.njoints
    model = pointed_model(model, [(site.joint_id, site.placement) for site in sites])
    places = dict(zip(pointed, range(own_joints, model.njoints), strict=True))
    tree = tree_of(model, [*joints, *places.values()], robot.model)
    loads = load_tables(scene, tree, links)
    tables = row_tables(scene, tree, frictional=frictional, followers=followers, places=places)
    known, given, columns, struck = known_tables(scene, tree, tables)
    rows, passed = row_arrays(tree, tables)
    refines = tree.has_points
    if refines:
        struck = set(range(1, tree.bodies + 1))
    loaded = path_mask(tree, struck | passed)
    sets = by_name.Sets(
        loaded,
        np.flatnonzero(loaded),
        path_mask(tree, struck),
        np.flatnonzero(path_mask(tree, struck | passed)),
        path_mask(tree, in_world(known, rows, tables)),
    )
    is_part = len(set(tree.q_index.tolist())) < robot.nq + 3 * len(pointed)
    sizes = by_name.Sizes(
        tree.bodies,
        tree.nq,
        tree.nv,
        robot.nq,
        robot.nv,
        len(given),
        len(links),
        int(is_part),
        int(refines),
    )
    return Program(
        tree,
        sizes,
        by_name.Tree(*tree_tables(tree, robot.model, followers)),
        sets,
        by_name.Known(*known),
        loads,
        by_name.Rows(*rows),
        (
            np.array(tables.meeting_ints, dtype=np.int64).ravel(),
            np.concatenate([*tables.meeting_floats, np.zeros(0)]),
            np.array(tables.ways, dtype=np.int64),
        ),
        (
            np.array(tables.ball_ints, dtype=np.int64).ravel(),
            np.concatenate([*tables.ball_floats, np.zeros(0)]),
        ),
        (np.array(tables.target), np.array(tables.keeps, dtype=bool)),
        (
            np.array(tables.contact_ints, dtype=np.int64).ravel(),
            np.concatenate([*tables.contact_floats, *tables.restitution_tables, np.zeros(0)]),
        ),
        columns,
        given,
        np.array(tables.restitution, dtype=float),
        np.array(tables.friction, dtype=float),
        len(followers),
        _plainer(words, tables.contact_ints, is_struck=len(given) + len(tables.target) > 0),
    )


def _moved(scene: Scene) -> tuple[pin.Model, tuple[Follower, ...], list[int]]:
    """The model without joints that follow others, these, and the joints that anything moves.

    Raises:
        NoKernelError: the kernels do not know such a robot.
    """
    try:
        model, followers = freed_model(scene.robot.model)
    except KeyError as kind:
        raise NoKernelError(f"joints of the kind {kind.args[0]}") from None
    unknown = {joint.shortname() for joint in list(model.joints)[1:]} - KINDS.keys()
    if unknown:
        raise NoKernelError(f"joints of the kind {', '.join(sorted(unknown))}")
    branches = {branch_of(model, joint_id) for joint_id in touched_joints(scene)} - {0}
    joints = [
        j
        for j in range(1, model.njoints)
        if (branches and followers) or branch_of(model, j) in branches
    ]
    if not joints:
        raise NoKernelError("nothing acts")
    if not is_always_regular(model):
        raise NoKernelError("joints without inertia of their own, whose pivots are watched")
    if has_uneven_masses(model):
        raise NoKernelError("very light beside very heavy bodies, where answers are refined")
    return model, followers, joints


def _plainer(
    words: tuple[int, int, int], contact_ints: list, *, is_struck: bool
) -> tuple[int, int, int]:
    """The words of the simplest law that is the same where no contact can rub.

    Args:
        is_struck: whether blows or bilateral rows act at the same instant: along the path
            they come first, and under Newton's law with slip at the end all come together.
    """
    restitution, _, order = words
    if restitution == NEWTON and order != SEQUENTIAL and is_struck:
        return words
    if restitution in (STRONGE, LZB) or any(ints[1] > 1 for ints in contact_ints):
        return words
    return restitution, END, order
