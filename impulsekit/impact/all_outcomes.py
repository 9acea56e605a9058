"""``Outcomes``: every v⁺ that contacts may leave when they compress in any order and shares."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from .._core import find_outcomes
from ..errors import InputError, RangeError, ShapeError
from ..errors.calls import public
from ..formatting import OneLine, one_line
from ..named import ByName
from ..robot.arrays import lock, read_only
from ..scene.law import Law
from ..scene.numbers import whole
from .contact_law import find_others, solve_contacts
from .flat.links import flat_links_of
from .joint_loads import joint_loads
from .status import Status
from .uniqueness import problem_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .contact_law import ContactProblem, ContactSolution
    from .outcome import Outcome
    from .touched import TouchedAnswer

Kind = TypeVar("Kind", bound="TouchedAnswer")

__all__ = ["LAWS", "Outcomes", "one_outcome", "outcome_bounds", "outcomes_of"]

# Laws whose answers are shown among the outcomes, if they accept the contacts.
LAWS = {
    "newton": Law(),
    "poisson": Law(restitution="poisson"),
    "sequence": Law(restitution="poisson", slip="path", order="sequential"),
    "lzb": Law(restitution="lzb"),
}
# Changes of a process that are tried on the way to an extreme.
TRIES = 256
# Processes and changes of them for a row of a batch, where time counts.
BATCH_SAMPLES, BATCH_TRIES = 512, 64
# Seeds that the core takes.
MOST_SEED = 2**63 - 1
# Singular values of a cloud below this share of the largest are rounding: it is flat there.
FLAT = 1e-9
# A point is nearest where no outcome is nearer by this share, and so many are looked for.
CLOSE = 1e-6
MOST_CLIMBS = 30


class _ContactSpace(NamedTuple):
    """An impact in contact space.

    Attributes:
        problem: of its contacts. outcome, contacts: by the scene's law.
        moved, multipliers: (nv, r), (m, r) Δv and λ by unit impulses.
        start: (nv,) v⁺ without contacts.
    """

    problem: ContactProblem
    outcome: Outcome
    contacts: ContactSolution
    moved: np.ndarray
    multipliers: np.ndarray
    start: np.ndarray


@public
@dataclass(frozen=True, eq=False, repr=False)
class Outcomes(OneLine):
    """Velocities, impulses and loads that an impact may end with, whatever its order and shares.

    While contacts approach, their normal impulses grow in any shares: dP_n = λ ds, λ ≥ 0, with
    λ_i = 0 where u_n,i > 0, and friction opposes the slip at every instant (Routh 1860; Halm &
    Posa 2019). After the compression each contact receives e P_n more, in any shares (Poisson).

    Proven: each sample and each extreme obeys this process to rounding, parts with an approach
    below 1e-10 of the velocities, and gains no energy. Sampled: that there are no further ones;
    ``bounds`` and hulls lie inside the true ones.

    Attributes:
        impact: the answer of the scene's own law. Whatever it is, all outcomes are found alike.
        impulses: (S, r) P along the rows of ``impact.jacobian`` [N s], sample after sample.
        velocities_after: (S, nv) v⁺.
        energy: (S,) kinetic energy after the impact [J].
        extremes: (2 nv, nv) the v⁺ with the smallest entry 0, 1, …, then with the largest ones.
        laws: v⁺ (nv,) of the laws that accept the contacts: "newton", "poisson", "sequence" (path,
            Poisson), "lzb" where they have stiffnesses, and "newton 2", … of its further answers
            among all complementary cases of up to four contacts (Remy 2017). Laws with slip at
            the end of the impact, and sequences with e > 0, need not be outcomes.
        jammed: samples left out since friction jams a contact, or compression has no end.
        gained: samples left out since their expansion would gain energy.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, outcomes
        >>> rod = Robot.from_urdf("models/rod.urdf", root="freeflyer")
        >>> ends = [Contact("rod", at=[x, 0, 0], name=name) for x, name in ((0, "a"), (1, "b"))]
        >>> fall = [0, 0, -1, 0, 0, 0]
        >>> found = outcomes(Scene(rod, contacts=ends), rod.neutral(), fall, samples=64)
        >>> found.extremes[8].round(6).tolist()  # one end stays, the other one goes up
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        >>> found.distance(found.laws["newton"]) < 1e-6
        True
    """

    impact: TouchedAnswer
    impulses: np.ndarray
    velocities_after: np.ndarray
    energy: np.ndarray
    extremes: np.ndarray
    laws: Mapping[str, np.ndarray]
    jammed: int
    gained: int
    seed: int
    _extreme_impulses: np.ndarray = field(repr=False)
    _space: _ContactSpace = field(repr=False)

    def __repr__(self) -> str:
        left = f"{self.jammed} jammed, {self.gained} gained energy"
        return one_line("Outcomes", f"{len(self)} samples", left, f"laws {', '.join(self.laws)}")

    def __len__(self) -> int:
        return len(self.velocities_after)

    @cached_property
    def bounds(self) -> np.ndarray:
        """(2, nv) the smallest and the largest entries of v⁺ that were found: inner bounds."""
        return read_only(_range(np.vstack([self.velocities_after, self.extremes])))

    def extreme(self, weights: ArrayLike) -> np.ndarray:
        """Return (nv,) the outcome v⁺ with the largest weights·v⁺ that is found.

        From the best sample on, changes of the order and the shares of the process are tried.

        Args:
            weights: (nv,).

        Raises:
            ShapeError: not of nv weights.
        """
        w = self._weights(weights, "weights")
        found, states = _found(
            self._space.problem, len(self), (w @ self._space.moved)[None], self.seed
        )
        if states[-1]:
            raise InputError("outcomes: no process comes to its end in this direction")
        return read_only(self._space.start + self._space.moved @ found[-1])

    def hull(self, coordinates: Sequence[int] | ArrayLike) -> np.ndarray:
        """Return (K, k) the corners of the convex hull of all v⁺ in k coordinates.

        Args:
            coordinates: entries of v, or (k, nv) weights of them. In a plane the corners go
                around. Where the outcomes are flat the hull is that of their line or plane.

        Raises:
            RangeError: an entry that v does not have.
        """
        points = self._in(coordinates)
        centre = points.mean(axis=0)
        _, sizes, axes = np.linalg.svd(points - centre, full_matrices=False)
        rank = int((sizes > FLAT * np.abs(self.velocities_after).max()).sum())
        flat = (points - centre) @ axes[:rank].T
        if rank == 0:
            return points[:1]
        if rank == 1:
            return points[[flat[:, 0].argmin(), flat[:, 0].argmax()]]
        from scipy.spatial import ConvexHull

        return points[ConvexHull(flat).vertices]

    def distance(self, v_after: ArrayLike) -> float:
        """Return how far v⁺ (nv,) lies from the convex hull of all outcomes [√J].

        (dᵀ M d)^½ of the difference d to the nearest point; outcomes towards v⁺ are looked for
        until it is inside or none lies farther out (Gilbert 1966). Below 1e-9 of the speeds it is
        rounding. The hull is convex and the set of outcomes need not be: inside is no proof.

        Raises:
            ShapeError: not nv velocities.
        """
        from scipy.optimize import nnls

        goal = self._weights(v_after, "v_after")
        root = np.linalg.cholesky(self.impact.mechanics.mass_matrix)
        near = (np.vstack([self.velocities_after, self.extremes]) - goal) @ root
        scale = max(float(np.abs(near).max()), np.finfo(float).tiny)
        for _ in range(MOST_CLIMBS):
            rows = np.vstack([near.T / scale, np.ones(len(near))])
            shares, _ = nnls(rows, np.append(np.zeros(len(root)), 1.0), maxiter=20 * len(near))
            point = shares @ near / shares.sum()
            least = float(np.linalg.norm(point))
            if least <= FLAT * scale:
                return least
            found = (self.extreme(-(root @ point)) - goal) @ root
            if found @ point >= least * least * (1.0 - CLOSE):
                return least
            near = np.vstack([near, found])
        return least

    @cached_property
    def joint_loads(self) -> Mapping[str, np.ndarray]:
        """By joint name (2, 6): the smallest and largest force [N s], moment [N m s] found.

        In the axes of the joint, as ``Impact.joint_loads``; over samples and extremes.
        """
        found = {name: _range(loads) for name, loads in self.loads.items()}
        return ByName({name: read_only(each) for name, each in found.items()}, "joint")

    @cached_property
    def loads(self) -> Mapping[str, np.ndarray]:
        """By joint name (S + 2 nv, 6): force and moment of every sample and extreme."""
        P = np.vstack([self.impulses, self._extreme_impulses])
        start, slopes = self._load_map
        found = {name: start[name] + P @ slopes[name] for name in start}
        lock(*found.values())
        return ByName(found, "joint")

    def impact_with(self, impulses: ArrayLike) -> TouchedAnswer:
        """Return the ``Impact`` with other contact impulses (r,), as a row of ``impulses``."""
        return _with_impulses(self.impact, self._space, np.array(impulses, dtype=float))

    def _weights(self, given: ArrayLike, what: str) -> np.ndarray:
        numbers, shape = np.asarray(given, dtype=float), self.impact.v_after.shape
        if numbers.shape != shape:
            raise ShapeError.of(what, shape, numbers.shape)
        return numbers

    def _in(self, coordinates: Sequence[int] | ArrayLike) -> np.ndarray:
        points = np.vstack([self.velocities_after, self.extremes])
        given = np.asarray(coordinates)
        if given.ndim == 2:
            return points @ given.astype(float).T
        nv = points.shape[1]
        whole_numbers = given.ndim == 1 and given.dtype.kind in "iu"
        if not (whole_numbers and ((given >= 0) & (given < nv)).all()):
            raise RangeError.of("coordinates", coordinates, f"entries of v, 0 to {nv - 1}")
        return points[:, given]

    @cached_property
    def _load_map(self) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """By joint the loads (6,) without contacts, and their slopes (r, 6) by P."""
        size = self.impulses.shape[1]

        def loads(P: np.ndarray) -> dict[str, np.ndarray]:
            impact = self.impact_with(P)
            own = joint_loads(impact, flat_links_of(impact.scene.robot).reactions(impact.loads))
            return {name: np.concatenate([each.force, each.moment]) for name, each in own.items()}

        start = loads(np.zeros(size))
        ends = [loads(row) for row in np.eye(size)]
        return start, {n: np.array([end[n] - start[n] for end in ends]) for n in start}


def _with_impulses(impact: Kind, own: _ContactSpace, P: np.ndarray) -> Kind:
    """The impact with other contact impulses P (r,)."""
    free = own.problem.velocity_free
    u = free + own.problem.delassus @ P
    works = 0.5 * (P * (free + u)).reshape(-1, 3)
    contacts = replace(
        own.contacts, impulse=P, velocity_after=u, status=Status.SOLVED, residual=0.0,
        unique=None, velocity_start=free, normal_work=works[:, 2],
        friction_work=works[:, :2].sum(axis=1),
    )  # fmt: skip
    multipliers = own.outcome.constraint_impulses + own.multipliers @ (P - own.contacts.impulse)
    outcome = replace(own.outcome, constraint_impulses=multipliers, contacts=contacts)
    dv = own.start + own.moved @ P - impact.v_before
    return type(impact)(impact.scene, np.array(impact.q), np.array(impact.v_before), dv, outcome)


def _range(rows: np.ndarray) -> np.ndarray:
    return np.array([rows.min(axis=0), rows.max(axis=0)])


def _found(
    problem: ContactProblem, samples: int, directions: np.ndarray, seed: int, tries: int = TRIES
) -> tuple[np.ndarray, np.ndarray]:
    """(S + K, r) impulses, (S + K,) states."""
    threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    found = find_outcomes(
        np.ascontiguousarray(problem.delassus), np.ascontiguousarray(problem.velocity_free),
        problem.contacts(), samples, np.ascontiguousarray(directions), tries, seed, threads,
    )  # fmt: skip
    return found.impulses.reshape(-1, len(problem.velocity_free)), found.states.astype(int)


def outcomes_of(impact: TouchedAnswer, samples: int = 4096, seed: int = 0) -> Outcomes:
    """Return the outcomes of an impact; see ``outcomes``."""
    samples = whole(samples, "samples", 1)
    if whole(seed, "seed", 0) > MOST_SEED:
        raise RangeError.of("seed", seed, "a whole number, 0 to 2**63 - 1")
    space = _space_of(impact)
    moved = space.moved
    P, states = _found(space.problem, samples, np.vstack([-moved, moved]), seed)
    own, best = states[:samples], P[samples:][states[samples:] == 0]
    kept = P[:samples][own == 0]
    if not len(kept):
        raise InputError(
            "outcomes: no sample comes to its end without a gain of energy; friction jams the "
            "contacts, or their restitution is too large for it"
        )
    after, extremes = space.start + kept @ moved.T, space.start + best @ moved.T
    energy = 0.5 * np.einsum("si,ij,sj->s", after, impact.mechanics.mass_matrix, after)
    lock(kept, after, extremes, energy, best)
    jammed, gained = (int((own == state).sum()) for state in (2, 1))
    laws = ByName(_answers(space), "law")
    return Outcomes(impact, kept, after, energy, extremes, laws, jammed, gained, seed, best, space)


def _space_of(impact: TouchedAnswer) -> _ContactSpace:
    """The contact problem of an impact, and how its impulses move the robot.

    Raises:
        InputError: nothing touches, or contacts that the process is not defined for.
    """
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        raise InputError("outcomes: no contact takes part; give the scene contacts that touch")
    names = impact.scene.entry_names("contacts")
    if any(touch.turns >= 0 for touch in outcome.touches):
        raise InputError("outcomes: not for contacts that resist rolling or torsion; set them to 0")
    if outcome.contacts.friction is not None:
        raise InputError("outcomes: friction must be a number at every contact")
    jacobian = np.vstack([touch.jacobian for touch in outcome.touches])
    moved, multipliers, delassus = impact.mechanics.responses(jacobian)
    problem = problem_of(impact, jacobian, delassus)
    for wrong, what in (
        (problem.adhesion, "adhesion"),
        (problem.tangential_restitution * (problem.friction > 0.0), "tangential restitution"),
    ):
        if wrong is not None and wrong.any():
            name = names[outcome.touches[int(np.flatnonzero(wrong)[0])].entry]
            raise InputError(f'outcomes: "{name}" has {what}, which the process has no place for')
    start = impact.v_after - moved @ outcome.contacts.impulse
    return _ContactSpace(problem, outcome, outcome.contacts, moved, multipliers, start)


def one_outcome(impact: Kind, seed: int) -> Kind | None:
    """Return an impact with one outcome in its place; None if friction jams or energy is gained."""
    if impact.outcome is None or impact.outcome.contacts is None:
        return impact
    space = _space_of(impact)
    P, states = _found(space.problem, 1, np.zeros((0, len(space.contacts.impulse))), seed)
    return None if states[0] else _with_impulses(impact, space, P[0])


def outcome_bounds(impact: TouchedAnswer) -> np.ndarray:
    """(2, nv) the least and largest v⁺ found in a short search; NaN where no process ends."""
    if impact.outcome is None or impact.outcome.contacts is None:
        return np.array([impact.v_after, impact.v_after])
    space = _space_of(impact)
    directions = np.vstack([-space.moved, space.moved])
    P, states = _found(space.problem, BATCH_SAMPLES, directions, 0, BATCH_TRIES)
    if states.all():
        return np.full((2, len(space.start)), np.nan)
    return _range(space.start + P[states == 0] @ space.moved.T)


def _answers(space: _ContactSpace) -> dict[str, np.ndarray]:
    found: dict[str, np.ndarray] = {}
    for name, law in LAWS.items():
        try:
            own = solve_contacts(space.problem, law)
        except InputError:
            continue
        impulses = [own.impulse] if own.status.valid else []
        if name == "newton":
            impulses += find_others(space.problem, law, own).impulses
        for k, P in enumerate(impulses):
            found[name if k == 0 else f"{name} {k + 1}"] = read_only(space.start + space.moved @ P)
    return found
