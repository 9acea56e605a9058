"""Every claim about time: one table of what is timed against what, and the bound it is held to.

Run with ``python -m benchmarks.claims [SECTION ...]``; the exit status is 1 if one is not kept. The
section "guard" is what every change has to pass, by ratios to bare Pinocchio, never by times.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from impulsekit.errors import UnknownNameError

from . import forces, jobs, motions
from .methods.registry import method_labelled
from .problems.registry import problem_named
from .timing import Claim, Times, in_turn


class _Row(Protocol):
    @property
    def section(self) -> str: ...

    def claims(self) -> Iterator[Claim]: ...


@dataclass(frozen=True)
class OfProblem:
    """Two methods on one problem whose answer is known; times are per state.

    Attributes:
        problem: its family's key, and its size as part of its name.
        ours, theirs: labels of methods.
        bound: of ours over theirs; where ``at_least``, of theirs over ours.
    """

    section: str
    family: str
    problem: str
    ours: str
    theirs: str
    bound: float
    at_least: bool = False

    def claims(self) -> Iterator[Claim]:
        """The claim; none where another program is not installed."""
        ours, theirs = method_labelled(self.ours), method_labelled(self.theirs)
        if ours.missing() or theirs.missing():
            return
        problem = problem_named(self.family, self.problem)
        call, other = ours.prepare(problem), theirs.prepare(problem)
        error = problem.error(np.asarray(call()))
        rounds = ROUNDS if ours.states == 1 else jobs.ROUNDS
        times = in_turn(call, other, ours.states, theirs.states, rounds)
        above, below = (theirs, ours) if self.at_least else (ours, theirs)
        claim = Claim.of_ratio(
            f"{problem.name}: {above.label} / {below.label}",
            times,
            self.bound,
            at_least=self.at_least,
            note=f"ours is off by {error:.0e}",
        )
        # What misses the answer is not quick.
        yield claim if error <= problem.tolerance else replace(claim, value=float("nan"))


@dataclass(frozen=True)
class OfJob:
    """A job that is no problem of the benchmark: two calls in turn, or figures of one.

    Attributes:
        measured: gives what was found, to be held to a bound.
        needs: another program; nothing is claimed where it is not installed.
    """

    section: str
    label: str
    measured: Callable[[], Times | list[float]]
    bound: float
    unit: str = ""
    at_least: bool = False
    needs: str = ""

    def claims(self) -> Iterator[Claim]:
        """The claim."""
        if self.needs and importlib.util.find_spec(self.needs) is None:
            return
        found = self.measured()
        if isinstance(found, Times):
            yield Claim.of_ratio(self.label, found, self.bound, at_least=self.at_least)
        elif found:
            yield Claim.of_values(self.label, found, self.bound, self.unit, self.at_least)


def _in_mujoco(name: str, *given: str) -> list[float]:
    """A job of ``benchmarks.in_mujoco``, which needs MuJoCo."""
    from . import in_mujoco

    found: list[float] = getattr(in_mujoco, name)(*given)
    return found


SOLVE, BATCH, LARGE = "impulsekit, solve", "impulsekit, batch", "impulsekit, large batch"
CRBA, DYNAMICS = "pinocchio, crba + cholesky", "pinocchio, impulseDynamics"
ADMM, MUJOCO = "pinocchio, ADMM, 1e-06", "mujoco, batch"

# How often single states are timed, and what is above its bound: the machine may be loaded.
ROUNDS, TRIES = 501, 3

TABLE: tuple[_Row, ...] = (
    OfProblem("known blow", "struck robot", "struck robot 9", SOLVE, CRBA, 1.5),
    OfProblem("known blow", "struck robot", "struck robot 38", SOLVE, CRBA, 1.5),
    OfJob("known blow", "one of four Pandas / lone Panda", jobs.one_of_four, 1.3),
    *(
        OfJob("known blow", f"{what} / {jobs.PINOCCHIO}", partial(jobs.importing, what), bound)
        for what, bound in ((jobs.BARE, 0.5), (jobs.NAMES, 1.15))
    ),
    OfProblem("constraints", "held robot", "held robot 12", SOLVE, DYNAMICS, 2.0),
    OfProblem("contacts", "foot", "foot that slides 38", SOLVE, DYNAMICS, 3.0),
    OfProblem("contacts", "foot", "foot that sticks 38", SOLVE, DYNAMICS, 3.0),
    OfProblem("contacts", "feet", "feet 8", SOLVE, ADMM, 1.3),
    OfJob(
        "contacts", "one compliant contact: solve / along the path", jobs.compliant_contacts, 2.0
    ),
    OfJob("contacts", "four feet: new Scene and first solve", jobs.first_solve, 150.0, "µs"),
    *(
        OfJob("beside bare calls", f"{label}: solve / calls by hand", times, bound)
        for label, times, bound in jobs.BESIDE_BARE
    ),
    *(
        # Both run in the core, which solves in a third of the time that it took in Python.
        OfJob("derivatives", f"{label}: derivatives / solve", times, 30.0)
        for label, times in jobs.DERIVATIVES.items()
    ),
    *(
        OfJob("derivatives", f"{name}, {what}: {label}", partial(job, name, touches), bound, unit)
        for name, (_, _, one, row) in jobs.GRADIENTS.items()
        for what, touches in (("a blow", False), ("contacts", True))
        for label, job, bound, unit in (
            ("all derivatives", jobs.all_derivatives, one, "µs"),
            ("vjp of a row, two cores", jobs.gradient_of_a_row, row, "µs"),
            ("vjp / solve_batch", jobs.gradient_of_batch, 4.0, ""),
        )
    ),
    OfProblem("batch", "struck robot", "struck robot 9", LARGE, CRBA, 30.0, at_least=True),
    OfProblem("batch", "struck robot", "struck robot 38", LARGE, CRBA, 15.0, at_least=True),
    OfProblem("batch", "foot", "foot that sticks 18", LARGE, DYNAMICS, 20.0, at_least=True),
    OfProblem("batch", "feet", "feet 8", BATCH, ADMM, 5.0, at_least=True),
    *(
        OfProblem("batch", "landing block", f"landing block {n}", BATCH, ADMM, 1.0, at_least=True)
        for n in (16, 32)
    ),
    *(
        OfProblem("batch", "struck robot", f"struck robot {nv}", LARGE, MUJOCO, 5.0, at_least=True)
        for nv in (9, 18, 38)
    ),
    *(
        OfJob(
            "batch",
            f"Solo12, {what}: solve / batch",
            partial(jobs.batch_of, feet, law),
            bound,
            at_least=True,
        )
        for what, feet, law, bound in jobs.LAWS
    ),
    OfJob(
        "batch",
        "joint reactions of Talos on its hands: solve / batch",
        jobs.reactions_of_a_fall,
        20.0,
        "",
        True,
    ),
    *(
        OfJob(
            "forces",
            f"{name}, {states}: peak by mujoco to 1 % / {calls}",
            partial(timed, name),
            100.0,
            at_least=True,
            needs="mujoco",
        )
        for states, calls, timed in (
            ("many states", "peak_forces", forces.batch_of_forces),
            ("one state", "solve, force_history", forces.single_forces),
        )
        for name in forces.STRUCK
    ),
    *(
        claim
        for where, in_plane, ratio, most in (
            ("in a plane", True, 3.0, 30.0),
            ("in space", False, 6.0, 200.0),
        )
        for claim in (
            OfJob(
                "outcomes",
                f"two contacts {where}: 4096 outcomes / 4096 sequences",
                partial(jobs.outcomes_of_two, in_plane),
                ratio,
            ),
            OfJob(
                "outcomes",
                f"two contacts {where}: 4096 outcomes, two cores",
                partial(jobs.time_of_outcomes, in_plane),
                most,
                "ms",
            ),
        )
    ),
    OfJob(
        "in MuJoCo",
        "Solo12 trots: Impacts.step / mj_step",
        partial(_in_mujoco, "running"),
        1.3,
        needs="mujoco",
    ),
    *(
        OfJob(
            "in MuJoCo",
            f"impact on four contacts, {instant}",
            partial(_in_mujoco, "impact_cost", instant),
            bound,
            "µs",
            needs="mujoco",
        )
        for instant, bound in (("exact", 150.0), ("step", 25.0))
    ),
    OfJob("motion", "tosses of a cube / mujoco, 1 ms", motions.tosses, 1.5),
    OfJob("motion", "box drawn to and fro, 2 s / mujoco, 1 ms", motions.drawn_box, 2.0),
    OfJob("motion", "five dominoes, 0.3 s / mujoco, 1 ms", motions.dominoes, 3.0),
    OfJob("motion", "ten boxes dropped on each other, 1 s / mujoco, 1 ms", motions.ten_boxes, 5.0),
    OfJob("motion", "boxes with rolling friction / without", motions.rolling, 2.0),
    OfJob(
        "motion",
        "100 tosses, one thread / two",
        motions.threads,
        1.9,
        at_least=True,
    ),
    OfJob("motion", "Solo12 standing, 1000 steps / simulate", motions.stepped, 1.5),
    OfJob("motion", "PD loop of Solo12 at 1 kHz / mujoco", motions.controlled, 3.0),
    OfJob("motion", "block shaken at its sole for 8.1 s", motions.shaken_block, 1.0, "s"),
    OfProblem("guard", "struck robot", "struck robot 9", SOLVE, CRBA, 1.6),
    OfProblem("guard", "struck robot", "struck robot 38", SOLVE, CRBA, 1.3),
    OfProblem("guard", "held robot", "held robot 12", SOLVE, DYNAMICS, 2.0),
    OfProblem("guard", "foot", "foot that sticks 38", SOLVE, DYNAMICS, 3.0),
    OfProblem("guard", "feet", "feet 8", SOLVE, ADMM, 0.3),
    *(
        OfJob("guard", f"{what} / {jobs.PINOCCHIO}", partial(jobs.importing, what), bound)
        for what, bound in ((jobs.BARE, 0.2), (jobs.SOLVING, 2.0))
    ),
    OfJob("whole jobs", "second check of Talos against Kane", jobs.second_check, 0.2, "s"),
    OfJob("whole jobs", "page of 10 s of Talos at 60 Hz", jobs.page, 10.0, "s"),
    OfJob("whole jobs", "long chains, 10³ to 10⁶ links: slope of time", jobs.growth, 1.05),
)
SECTIONS = tuple(dict.fromkeys(row.section for row in TABLE))
# Those that take a minute or more.
LONG_SECTIONS = ("batch", "motion", "whole jobs")


def claims(sections: Iterable[str] = ()) -> Iterator[tuple[str, Claim]]:
    """Section and claim, of some sections or all.

    Raises:
        UnknownNameError: no such section.
    """
    chosen = list(sections) or list(SECTIONS)
    for section in chosen:
        if section not in SECTIONS:
            raise UnknownNameError.among("section of claims", section, SECTIONS)
    for section in chosen:
        for row in TABLE:
            if row.section == section:
                yield from ((section, claim) for claim in _measured(row))


def _measured(row: _Row) -> list[Claim]:
    for _ in range(TRIES):
        found = list(row.claims())
        if all(claim.met for claim in found):
            break
    return found


def main(sections: list[str]) -> int:
    """Measure and write the rows; 1 if one stays above its bound."""
    title, kept = "", True
    for section, claim in claims(sections):
        if section != title:
            title = section
            sys.stdout.write(f"{section}\n")
        sys.stdout.write(f"  {claim.line()}")
        sys.stdout.flush()
        kept = kept and claim.met
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
