"""Bodies in a plane with up to four contacts, against all modes that the law allows.

An answer that is called valid has to be one of those that fractions find (``enumerated``), and
where they find another v⁺ that gains no energy either, the answer has to say that there are
several, or under Poisson's law at least not that it is the only one. Bodies are free, slide along
a line, or turn about a point: pairs with one relative motion are among them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, Literal

import numpy as np
from scipy.optimize import linprog

from benchmarks.truths.elimination import generalized_inverse
from benchmarks.truths.enumerated import After, PlaneProblem, whole_answers
from benchmarks.truths.numbers import EPS, truth_numbers
from impulsekit.impact import solve
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import Contact, Law, Scene

from ..urdf import joint_text, link_text, robot_text
from .judge import AGREED, BOUND
from .methods import Told, told, told_by_batch
from .sweep import STATES, Point, Sweep, seen

FRICTIONS, RESTITUTIONS = (0.0, 0.3, 0.6, 1.0, 3.0, 10.0), (0.0, 0.3, 0.5, 1.0)
# Limits of slides [m].
FAR = 9.0
# v⁺ that are closer than this, of all speeds, are not told apart.
APART = 1e-6
# Answers of larger condition hang on the rounding of rows that are dependent.
UNDETERMINED = 1e9
# [relative] Speeds below this count as none.
LEFT = 1e-9
# [relative] To which a linear programme is solved.
SHARED = 1e-6
# The same of a lone phase, whose programme is solved as exactly as its solver can.
SHARED_EXACTLY, FEASIBLE = 1e-8, 1e-10
# [relative] Singular values of rows below this are rounding of rows that depend on each other.
DEPENDENT = 1e-13


@dataclass(frozen=True, eq=False)
class PlaneScene:
    """A scene in a plane, and what its contacts are made of.

    Attributes:
        scene: of the bodies at their neutral pose, where their axes are those of the world.
        rows: (2n, nv) tangent and normal of each contact.
        terms: (2n, nv) the size of what they add up.
        inverse_masses: (nv,).
        friction, restitution: (n,).
    """

    scene: Scene
    rows: np.ndarray
    terms: np.ndarray
    inverse_masses: list[float]
    friction: list[float]
    restitution: list[float]

    def after(self, v: np.ndarray) -> list[After]:
        """All v⁺ that the law allows."""
        problem = PlaneProblem(
            self.rows.tolist(),
            self.inverse_masses,
            v.tolist(),
            self.friction,
            self.restitution,
            self.terms.tolist(),
        )
        return whole_answers(problem, self.scene.law.restitution)


@dataclass(frozen=True, eq=False)
class _Body:
    """A body and what its speeds do to a point of it: (3, nv) of vx, vy and turning."""

    robot: Robot
    moves: np.ndarray
    inverse_masses: list[float] = field(default_factory=list)


def _body(rng: np.random.Generator, decades: float) -> _Body:
    mass = float(10.0 ** rng.uniform(-decades, 0.0))
    inertia = mass * float(rng.uniform(0.02, 1.0))
    link = link_text("b", mass, (1.0, 1.0, inertia))
    kind = str(rng.choice(["free", "free", "slide", "hinge"]))
    if kind == "free":
        robot = Robot.from_urdf(robot_text("b", link), root="planar")
        return _Body(robot, np.eye(3), [1 / mass, 1 / mass, 1 / inertia])
    angle = float(rng.uniform(0.0, 2.0 * np.pi))
    way = np.array([math.cos(angle), math.sin(angle), 0.0])
    axis, joint = (way, "prismatic") if kind == "slide" else ((0, 0, 1), "continuous")
    moved = joint_text("j", joint, "base", "b", axis, far=FAR)
    robot = Robot.from_urdf(robot_text("b", link_text("base"), link, moved))
    if kind == "slide":
        return _Body(robot, way[:, None], [1 / mass])
    return _Body(robot, np.array([[0.0], [0.0], [1.0]]), [1 / inertia])


def plane_scene(count: int, law: Law, rng: np.random.Generator) -> PlaneScene:
    """One or two bodies in a plane with that many contacts."""
    bodies = [_body(rng, float(rng.integers(0, 4))) for _ in range(int(rng.integers(1, 3)))]
    firsts = np.cumsum([0] + [body.moves.shape[1] for body in bodies])
    rows, terms = np.zeros((2, 2 * count, firsts[-1]))
    contacts = []
    friction = rng.choice(FRICTIONS, count).tolist()
    restitution = rng.choice(RESTITUTIONS, count).tolist()
    for i in range(count):
        a, other = rng.integers(len(bodies), size=2).tolist()
        angle = float(rng.uniform(0.0, 2.0 * np.pi)) if rng.random() < 0.7 else 0.0
        c, s = math.cos(angle), math.sin(angle)
        x, y = rng.uniform(-1.0, 1.0, 2).tolist()
        own = np.array([[c, s, x * s - y * c], [-s, c, x * c + y * s]])
        across, along = abs(x * s) + abs(y * c), abs(x * c) + abs(y * s)
        sizes = np.array([[abs(c), abs(s), across], [abs(s), abs(c), along]])
        against = "world"
        terms[2 * i : 2 * i + 2, firsts[a] : firsts[a + 1]] = sizes @ np.abs(bodies[a].moves)
        rows[2 * i : 2 * i + 2, firsts[a] : firsts[a + 1]] = own @ bodies[a].moves
        if other != a and rng.random() < 0.7:
            rows[2 * i : 2 * i + 2, firsts[other] : firsts[other + 1]] = -own @ bodies[other].moves
            terms[2 * i : 2 * i + 2, firsts[other] : firsts[other + 1]] = sizes @ np.abs(
                bodies[other].moves
            )
            against = f"b{other}/b"
        contacts.append(
            Contact(
                f"b{a}/b",
                at=[x, y, 0.0],
                normal=[-s, c, 0.0],
                origin=[x, y, 0.0],
                against=against,
                restitution=restitution[i],
                friction=friction[i],
            )
        )
    world = combine({f"b{k}": body.robot for k, body in enumerate(bodies)})
    inverse = [x for body in bodies for x in body.inverse_masses]
    scene = Scene(world, contacts=contacts, law=law)
    return PlaneScene(scene, rows, terms, inverse, friction, restitution)


def judged(
    case: PlaneScene, lawful: Sequence[After], v: np.ndarray, told: Told
) -> tuple[str, str, float, float, float]:
    """Status, verdict, error and condition of an answer, and the error over 1 condition eps."""
    after = v if told.after is None else told.after
    scale = max(float(np.abs(v).max()), float(np.abs(after).max()))
    quiet = [one for one in lawful if not one.gains and one.slack.max() < UNDETERMINED * scale]
    different: list[After] = []
    for one in quiet:
        if all(np.abs(one.velocity - x.velocity).max() > APART * scale for x in different):
            different.append(one)
    if not told.valid:
        status = told.status
        if len(different) == 1 or (different and status == "ENERGY_GAIN"):
            status += " though one exists"
        return status, "said so", math.nan, 1.0, math.nan
    nearest = min(lawful, key=lambda one: float(np.abs(one.velocity - after).max()), default=None)
    error = condition = share = math.inf
    if nearest is not None:
        error = float(np.abs(nearest.velocity - after).max()) / scale
        condition = max(1.0, float(nearest.slack.max()) / scale)
        share = error / (condition * EPS)
    if nearest is None or (share > BOUND and error > AGREED):
        if _is_shared(case, v, after):
            return told.status, "right", math.nan, 1.0, math.nan
        why = " off the law" if lawful else " though none exists"
        return told.status + why, "wrong", error, condition, share
    if nearest.gains:
        return told.status + " gains energy", "wrong", error, condition, share
    # Newton's law has all its modes tried, Poisson's one release for each compression.
    said = ("several",) if case.scene.law.restitution == "newton" else ("several", "not proven")
    if len(different) > 1 and told.others not in said:
        return told.status + " of several", "wrong", error, condition, share
    return told.status, "right", error, condition, share


def _is_shared(case: PlaneScene, v: np.ndarray, after: np.ndarray) -> bool:
    """Whether the law allows a v⁺ by loads that are no mode's own.

    Under Poisson's law by some share of the load of its compression, with the velocities at the
    end of compression known (those of the impact with e = 0). Under Newton's where rows depend on
    each other up to their rounding: fractions see rows that are independent, and loads beyond all
    bounds. With the velocities given, all that a law says of the impulses is linear in them: a
    linear programme tells.
    """
    law = case.scene.law
    W = case.rows * np.array(case.inverse_masses) @ case.rows.T
    unit = 1.0 / np.sqrt(W.diagonal())
    W = W * unit * unit[:, None]
    if law.restitution != "poisson":
        if not _hangs_on_rounding(case, unit, v, after):
            return False
        return _misfit(case, W, unit, [v, after]) <= SHARED_EXACTLY
    still = [replace(contact, restitution=0.0) for contact in case.scene.contacts]
    scene = Scene(case.scene.robot, contacts=still, law=law)
    impact = solve(scene, scene.robot.neutral(), v)
    return _misfit(case, W, unit, [v, impact.v_after, after]) <= SHARED


def _hangs_on_rounding(
    case: PlaneScene, unit: np.ndarray, v: np.ndarray, after: np.ndarray
) -> bool:
    """Whether rows that hold under Newton's law are dependent but for their rounding."""
    rows = case.rows * unit[:, None]
    goal = np.zeros(len(rows))
    goal[1::2] = np.array(case.restitution) * np.minimum(rows[1::2] @ v, 0.0)
    scale = max(float(np.abs(rows @ one).max()) for one in (v, after))
    holds = np.abs(rows @ after + goal) <= LEFT * scale
    holds[::2] &= np.array(case.friction) > 0.0
    kept = np.flatnonzero(holds).tolist()
    some = (part for size in range(2, len(kept) + 1) for part in combinations(kept, size))
    return any(_loses_rank(case, list(part)) for part in some)


def _loses_rank(case: PlaneScene, kept: list[int]) -> bool:
    """Whether rows are dependent in doubles that are independent as their digits stand."""
    rows = case.rows[kept] / np.linalg.norm(case.rows[kept], axis=1)[:, None]
    values = np.linalg.svd(rows * np.sqrt(case.inverse_masses), compute_uv=False)
    rank = int(np.count_nonzero(values > DEPENDENT * values[0]))
    numbers = truth_numbers()
    exact = numbers.array(case.rows[kept])
    W = (exact * numbers.array(case.inverse_masses)) @ exact.T
    return rank < generalized_inverse(numbers, W)[1]


def _misfit(
    case: PlaneScene, W: np.ndarray, unit: np.ndarray, velocities: Sequence[np.ndarray]
) -> float:
    """What the law of a lone phase or of compression and release lacks at best, of all speeds.

    Args:
        W: (2n, 2n) of rows in units that make its diagonal one.
        unit: (2n,) those units.
        velocities: (nv,) each, before the phases and behind each.
    """
    speeds = [unit * (case.rows @ one) for one in velocities]
    scale = max(float(np.abs(one).max()) for one in speeds)
    speeds = [one / scale for one in speeds]
    size, phases = len(W), len(velocities) - 1
    is_newton = phases == 1
    # Unknown: the impulses of each phase, and the largest misfit s.
    rows: list[np.ndarray] = []
    bounds: list[float] = []

    def at_most(terms: dict[int, float], bound: float = 0.0) -> None:
        row = np.zeros(phases * size + 1)
        for place, factor in terms.items():
            row[place] += factor
        rows.append(row)
        bounds.append(bound)

    for phase in range(phases):
        first = phase * size
        for r, given in enumerate((speeds[phase + 1] - speeds[phase]).tolist()):
            for sign in (1.0, -1.0):
                terms = {first + c: sign * float(W[r, c]) for c in range(size)}
                at_most({**terms, phases * size: -1.0}, sign * given)
        for i, (mu, e) in enumerate(zip(case.friction, case.restitution, strict=True)):
            t, n = first + 2 * i, first + 2 * i + 1
            own_mu = mu * float(unit[2 * i + 1] / unit[2 * i])
            # P_n above its floor, and no more than that where the contact parts.
            floor = {2 * i + 1: e} if phase else {}
            at_most({**floor, n: -1.0})
            slip, parts = (float(speeds[phase + 1][2 * i + k]) for k in (0, 1))
            if is_newton:
                parts += e * min(float(speeds[0][2 * i + 1]), 0.0)
                if parts < -LEFT:
                    return math.inf
            if parts > LEFT:
                at_most({**dict.fromkeys(floor, -e), n: 1.0})
            for sign in (1.0, -1.0):
                at_most({t: sign, n: -own_mu})
                # Where it slips, friction is all of it, against the slip.
                if own_mu and sign * slip > LEFT:
                    at_most({t: sign, n: own_mu})
    goal = np.zeros(phases * size + 1)
    goal[-1] = 1.0
    free = [(None, None)] * (phases * size) + [(0.0, None)]
    options = {"primal_feasibility_tolerance": FEASIBLE} if is_newton else {}
    found = linprog(goal, np.array(rows), np.array(bounds), bounds=free, options=options)
    return float(found.fun) if found.success else math.inf


def _points(restitution: Literal["newton", "poisson"]) -> Any:
    law = Law(restitution=restitution)

    def points(value: float, rng: np.random.Generator) -> list[Point]:
        case = plane_scene(int(value), law, rng)
        speeds = rng.normal(size=(STATES, case.rows.shape[1]))
        q = case.scene.robot.neutral()
        batch = told_by_batch(case.scene, np.tile(q, (STATES, 1)), speeds)
        found = []
        for i, v in enumerate(speeds):
            lawful = case.after(v)
            alone = told(lambda v=v: solve(case.scene, q, v), others=True)  # type: ignore[misc]
            for method, one in (("solve", alone), ("batch", batch[i])):
                status, verdict, error, condition, share = judged(case, lawful, v, one)
                found.append(
                    seen(i, method, status, verdict, one.seconds, error=error,
                         condition=condition, share=share)
                )  # fmt: skip
        return found

    points.__doc__ = (
        f"One or two bodies in a plane that strike at so many points, {restitution.capitalize()}'s "
        "law, µ up to 10: against all modes, in fractions."
    )
    return points


CONTACTS = (1.0, 2.0, 3.0, 4.0)
SWEEPS = tuple(
    Sweep(f"plane-{law}", "contacts", CONTACTS, _points(law), 500, logarithmic=False)
    for law in ("newton", "poisson")
)
