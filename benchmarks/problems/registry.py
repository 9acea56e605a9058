"""All problems, by family. They are made one by one as they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from impulsekit.errors import UnknownNameError

from . import blows, contacts, motions
from .problem import Problem

FAMILIES: dict[str, Callable[[bool], Iterator[Problem]]] = {
    "struck chain": blows.struck_chains,
    "struck pendulum": blows.struck_pendulums,
    "random tree": blows.random_trees,
    "struck robot": blows.struck_robots,
    "held robot": blows.held_robots,
    "closed chain": blows.closed_chains,
    "falling rod": contacts.falling_rods,
    "smooth rod": contacts.smooth_rods,
    "rod along its path": contacts.rods_along_the_path,
    "cradle": contacts.cradles,
    "rocking block": contacts.rocking_blocks,
    "landing block": contacts.landing_blocks,
    "foot": contacts.single_feet,
    "feet": contacts.feet,
    "smooth feet": contacts.smooth_feet,
    "swing": motions.swings,
    "flight": motions.flights,
    "sliding block": motions.sliding_blocks,
}


def problems(quick: bool = False, families: Iterable[str] = ()) -> Iterator[Problem]:
    """The problems of some families, or of all.

    Args:
        quick: only the small ones, a few of each.
        families: keys of ``FAMILIES``.

    Raises:
        UnknownNameError: it carries the nearest names.
    """
    chosen = list(families) or list(FAMILIES)
    for name in chosen:
        if name not in FAMILIES:
            raise UnknownNameError.among("family of problems", name, FAMILIES)
    for name in chosen:
        yield from FAMILIES[name](quick)


def problem_named(family: str, name: str) -> Problem:
    """One problem, by the key of its family and its name.

    Raises:
        UnknownNameError: it carries the nearest names.
    """
    names = []
    for problem in problems(families=[family]):
        if problem.name == name:
            return problem
        names.append(problem.name)
    raise UnknownNameError.among("problem", name, names)
