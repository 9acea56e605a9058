"""All problems, by family. They are made one by one as they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from impulsekit.errors import UnknownNameError

from . import balls, blocks, chains, feet, linkages, motions, robots, rods, trees
from .problem import Problem

__all__ = ["FAMILIES", "problem_named", "problems"]

FAMILIES: dict[str, Callable[[bool], Iterator[Problem]]] = {
    "struck chain": chains.struck_chains,
    "struck pendulum": chains.struck_pendulums,
    "random tree": trees.random_trees,
    "struck robot": robots.struck_robots,
    "held robot": robots.held_robots,
    "closed chain": linkages.closed_chains,
    "falling rod": rods.falling_rods,
    "smooth rod": rods.smooth_rods,
    "rod along its path": rods.rods_along_the_path,
    "cradle": balls.cradles,
    "rocking block": blocks.rocking_blocks,
    "landing block": blocks.landing_blocks,
    "foot": feet.single_feet,
    "feet": feet.feet,
    "smooth feet": feet.smooth_feet,
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
