"""What ``block.solve_blocks`` is given, by name: the tables of a scene and the arrays of a batch.

Tables are flat arrays, as ``layout`` says; a list by row has its beginnings beside it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

__all__ = [
    "Contact", "Inputs", "Known", "Lanes", "Moving", "Outputs", "Posed", "Rows", "Sets", "Sizes",
    "Span", "Touch", "Tree",
]  # fmt: skip


class Span(NamedTuple):
    """The blocks to solve.

    Attributes:
        begin, end: the first, and the one behind the last.
        states: how many there are in all, at least as many as go side by side.
        code: (lanes,) buffer for the status codes of a block.
    """

    begin: int
    end: int
    states: int
    code: np.ndarray


class Tree(NamedTuple):
    """The bodies, and what their vectors have to do with the robot's.

    Attributes:
        ints, floats: of the bodies; dofs: of the degrees of freedom; armature: of each.
        q_index, v_index: entries of q and of v in the whole vectors.
        v_out: of v where they are written, −1 for nowhere.
        angles, straight: which entries of q and of v are angles.
        units: unit vectors in q, first entry and how many.
        follow: joints that follow others: entry of q, degree of freedom and that of the leader.
        ratios: their ratios and offsets.
    """

    ints: np.ndarray
    floats: np.ndarray
    dofs: np.ndarray
    armature: np.ndarray
    q_index: np.ndarray
    v_index: np.ndarray
    v_out: np.ndarray
    angles: np.ndarray
    straight: np.ndarray
    units: np.ndarray
    follow: np.ndarray
    ratios: np.ndarray


class Sizes(NamedTuple):
    """How many there are.

    Attributes:
        bodies, nq, nv: of the tree; whole_q, whole_v: of the whole robot.
        columns: of the known impulses; factors: on masses.
        is_part: whether the tree is but a part of the robot.
        refines: whether Δv is refined, for which all bodies have to count as loaded.
    """

    bodies: int
    nq: int
    nv: int
    whole_q: int
    whole_v: int
    columns: int
    factors: int
    is_part: int
    refines: int


class Sets(NamedTuple):
    """Bodies by what is asked of them.

    Attributes:
        loaded, loaded_list: mask and list of those that anything acts on.
        known_mask: of those that known impulses load.
        twist_list: those whose twist before the impact is wanted.
        placed: mask of those that have to do with the world's axes.
    """

    loaded: np.ndarray
    loaded_list: np.ndarray
    known_mask: np.ndarray
    twist_list: np.ndarray
    placed: np.ndarray


class Known(NamedTuple):
    """Known impulses: tables of those on bodies, and kicks in joints."""

    ints: np.ndarray
    floats: np.ndarray
    kicks: np.ndarray


class Rows(NamedTuple):
    """Rows of constraints and contacts.

    Attributes:
        term_ints, term_floats: of their terms; first: where those of each row begin.
        alike: what rows share; reach, reach_first: bodies that a row passes, and
            reach_mask: the mask of those; dof_list, dof_first: degrees of freedom that it
            moves, and reach_dofs: the mask of those.
        lever: (rows · nv,) what each degree of freedom moves the terms of each row by at most.
    """

    term_ints: np.ndarray
    term_floats: np.ndarray
    first: np.ndarray
    alike: np.ndarray
    reach: np.ndarray
    reach_first: np.ndarray
    reach_mask: np.ndarray
    dof_list: np.ndarray
    dof_first: np.ndarray
    reach_dofs: np.ndarray
    lever: np.ndarray


class Touch(NamedTuple):
    """Constraints and contacts.

    Attributes:
        rows: of both, those of constraints first.
        meetings: ints, floats, ways; balls: ints, floats (see ``meetings`` and ``balls``).
        held: velocities of the bilateral rows that are brought about, and which keep their own.
        ints, floats: of the contacts.
        words: of the law, see ``words``.
    """

    rows: Rows
    meetings: tuple[np.ndarray, ...]
    balls: tuple[np.ndarray, ...]
    held: tuple[np.ndarray, ...]
    ints: np.ndarray
    floats: np.ndarray
    words: tuple[int, int, int]


class Moving(NamedTuple):
    """The robot, and what acts on it from outside.

    Attributes:
        at: where in the work array things begin, see ``layout.Places``.
        loads: ints and floats of the links whose masses vary.
    """

    tree: Tree
    sizes: Sizes
    at: Any
    sets: Sets
    loads: tuple[np.ndarray, ...]
    known: Known


class Inputs(NamedTuple):
    """Flat arrays of a batch, each with its stride; 0 gives all states the same.

    Attributes:
        given: the known impulses; e, mu: of the contacts; m: factors on masses.
        codes: those to begin with.
    """

    q: np.ndarray
    q_step: int
    v: np.ndarray
    v_step: int
    given: np.ndarray
    given_step: int
    e: np.ndarray
    e_step: int
    mu: np.ndarray
    mu_step: int
    m: np.ndarray
    m_step: int
    codes: np.ndarray


class Outputs(NamedTuple):
    """Flat arrays, empty where an output was not requested; codes are always written.

    Attributes:
        normals: (states, contacts, 3) normal velocity before and after, and normal impulse.
    """

    dv: np.ndarray
    v: np.ndarray
    sum: np.ndarray
    contacts: np.ndarray
    rows: np.ndarray
    energy: np.ndarray
    normals: np.ndarray
    codes: np.ndarray


class Contact(NamedTuple):
    """The numbers of a lone contact on a plane, in one state.

    Attributes:
        capture: below it e is 0 [m/s]. faintest: see ``left.is_faint`` [1/kg].
    """

    capture: float
    e_t: float
    e: float
    mu: float
    faintest: float


class Posed(NamedTuple):
    """What the law is told of all states: rows, contacts, and their coefficients.

    Attributes:
        rows: how many, the bilateral ones first.
        target: (count,) velocities that these are brought to; keeps: which keep their own.
        lever: as in ``Rows``.
        first, listed: where the part of each row in a list begins, and that list, of the degrees
            of freedom that it passes through.
        ints, floats: of the contacts.
        q, e, mu: flat arrays of the batch, each with its stride.
        words: of the law, see ``words``.
    """

    rows: int
    target: np.ndarray
    keeps: np.ndarray
    lever: np.ndarray
    first: np.ndarray
    listed: np.ndarray
    ints: np.ndarray
    floats: np.ndarray
    q: np.ndarray
    q_step: int
    e: np.ndarray
    e_step: int
    mu: np.ndarray
    mu_step: int
    words: tuple[int, int, int]


class Lanes(NamedTuple):
    """The states of a block side by side: number k of a lane stands in ``work[k · w + lane]``.

    Attributes:
        base: the state in the first lane. w: how many lanes there are.
        digits: binary digits of the numbers in ``work``.
        code: (w,) status codes.
        delassus, before, free, p, dof, reduced: where in ``work`` these stand, see ``layout``.
    """

    base: int
    w: int
    digits: int
    work: np.ndarray
    code: np.ndarray
    delassus: int
    before: int
    free: int
    p: int
    dof: int
    reduced: int
