"""Contacts one after the other, and the limit of hits that go on without end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...laws.progress import path_memory
from ...laws.sequence import (
    COUNT,
    GOES_ON,
    LONG,
    REFUSED,
    TIED,
    WORST,
    Contacts,
    Sequence,
    advance_sequence,
    end_code,
    sequence_of,
)
from ...laws.status import BY_CODE, Status
from ...laws.words import END, PATH
from ...scene.law import RESTITUTIONS, Law
from .limit import Hits, find_limit, is_at_rest
from .problem import ContactProblem, ContactSolution, in_order
from .single import refuse_tangential

__all__ = ["hits_of", "solve_sequential"]

# The limit of a series of hits is looked for after LONG hits, and again each time there are this
# many times as many. Shorter series end by themselves, as do most of those with ratios below 0.7.
LATER = 1.5


class _Steps:
    """A sequence, and the way to go on with it."""

    def __init__(self, problem: ContactProblem, law: Law) -> None:
        self.state: Sequence = sequence_of(len(problem.friction))
        self.hits: Hits = []
        self._law, self._memory = law, path_memory()
        # One contact alone is Stronge's, whatever its stiffness.
        word = "stronge" if law.restitution == "lzb" else law.restitution
        self._before = in_order(problem.velocity_before)
        self.contacts = Contacts(
            in_order(problem.delassus),
            in_order(problem.velocity_free),
            in_order(problem.restitution),
            in_order(problem.friction),
            in_order(problem.tangential_restitution),
            RESTITUTIONS.index(word),
            END if law.slip == "end" else PATH,
        )

    def advance(self, until: int) -> tuple[bool, Status]:
        """Whether it goes on, and the status so far.

        Raises:
            InputError: tangential restitution where it has no meaning.
        """
        count = int(self.state.now[COUNT])
        room = max(until - count, 1)
        who, hits = np.empty(room, np.int64), np.empty((room, 3))
        step, code = advance_sequence(
            self.state, self.contacts, self._before, until, who, hits, self._memory
        )
        if step == REFUSED:
            refuse_tangential(self._law)
        new = int(self.state.now[COUNT]) - count
        self.hits += zip(who[:new].tolist(), map(tuple, hits[:new].tolist()), strict=True)
        return step == GOES_ON, BY_CODE[code]


def solve_sequential(problem: ContactProblem, law: Law) -> ContactSolution:
    """Single hits, each with the velocities that the last one left, and the limit of such.

    Raises:
        InputError: tangential restitution under any but Newton's law with slip at the end.
    """
    steps = _Steps(problem, law)
    state, until = steps.state, LONG
    while True:
        goes_on, status = steps.advance(until)
        if not goes_on:
            break
        until = int(LATER * until)
        jump = find_limit(problem, state.velocity, steps.hits)
        if jump is not None:
            works = jump.impulse * (state.velocity + 0.5 * jump.change)
            state.velocity[:] += jump.change
            state.impulse[:] += jump.impulse
            state.normal[:] += works[2::3]
            state.friction[:] += works[0::3] + works[1::3]
            steps.hits.clear()
            if is_at_rest(problem, state.velocity, jump.off):
                status = BY_CODE[end_code(state, steps.contacts, len(problem.friction))]
                break
    return ContactSolution(
        state.impulse,
        problem.delassus @ state.impulse + problem.velocity_free,
        status,
        float(state.now[WORST]),
        None if state.unique.all() else state.unique,
        problem.velocity_free,
        state.normal,
        state.friction,
        int(state.now[COUNT]),
        bool(state.now[TIED]),
    )


def hits_of(problem: ContactProblem, law: Law) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """The hits in order: which contact, (3n,) all velocities before it, its impulse (3,)."""
    steps = _Steps(problem, law)
    velocity, goes_on = problem.velocity_free, True
    while goes_on:
        count = len(steps.hits)
        goes_on, _ = steps.advance(count + 1)
        if len(steps.hits) > count:
            i, impulse = steps.hits[-1]
            yield i, velocity, np.array(impulse)
        velocity = steps.state.velocity.copy()
