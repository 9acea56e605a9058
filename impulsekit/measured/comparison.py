"""``compare_laws``: which law of contact predicts impacts best that took no part in its fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..design.fit import fit_impacts
from ..design.fit_result import Fit
from ..design.parameters import Measurement, scene_of
from ..design.solved import SolvedImpacts
from ..errors import ImpulsekitError, InputError
from ..errors.calls import public
from ..formatting import Displayed, one_line, table
from ..impact.flat.model import flat_model_of
from ..robot.arrays import lock
from ..scene import JointLock, Law, RestitutionTable, Scene
from ..scene.numbers import whole
from ..tolerances import NONZERO

# e by speed is fitted at these percentiles of the speeds of the impacts' fastest contacts.
PERCENTILES = (10.0, 50.0, 90.0)
# A speed this near to the next [share of the fastest] is no point of its own.
TOO_NEAR = 0.05
# Impacts whose speeds determine the percentiles; more change them by little.
MOST_LOOKED_AT = 200


@public
@dataclass(frozen=True)
class LawCandidate:
    """One way to predict impacts.

    Attributes:
        name: in the table.
        law: in place of the scene's; None: the scene's own.
        speeds: e by approach speed, at these speeds [m/s]; none: the scene's own.
        by_group: e of its own for each ``Measurement.group``; or the names of the coefficients
            that a group has of its own, "restitution" and "friction".
        group_of: the group of an impact by what is known before it, in place of
            ``Measurement.group``.
        locked, controlled: joints that keep their velocity, as a lock with velocity="kept" or in
            ``Scene.controlled``; the others are as in the scene.

    Raises:
        InputError: no name, or speeds that do not rise.

    Example:
        >>> from impulsekit import Law
        >>> LawCandidate("Stronge", Law("stronge", "path")).law.slip
        'path'
    """

    name: str
    law: Law | None = None
    speeds: tuple[float, ...] = ()
    by_group: bool | Sequence[str] = False
    group_of: Callable[[Measurement], str] | None = None
    locked: tuple[str, ...] = ()
    controlled: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.name or not isinstance(self.name, str):
            raise InputError("LawCandidate: name must be text that is not empty")
        for each in ("speeds", "locked", "controlled"):
            object.__setattr__(self, each, tuple(getattr(self, each)))
        if self.speeds:
            # The table says what is wrong with them.
            RestitutionTable(self.speeds, (0.0,) * len(self.speeds))

    def scene(self, scene: Scene) -> Scene:
        """Return a scene under this candidate.

        Raises:
            InputError, UnknownNameError: as ``Scene``.
        """
        contacts: list[Any] = list(scene.contacts)
        for k, entry in enumerate(scene.contacts):
            if self.speeds and isinstance(entry.restitution, float):
                values = (entry.restitution,) * len(self.speeds)
                table = RestitutionTable(self.speeds, values)
                contacts[k] = replace(entry, restitution=table)
        locks = [JointLock(joint, velocity="kept") for joint in self.locked]
        return replace(
            scene,
            contacts=contacts,
            law=self.law or scene.law,
            constraints=[*scene.constraints, *locks],
            controlled=[*scene.controlled, *self.controlled],
        )


def usual_candidates(measurements: Sequence[Measurement]) -> list[LawCandidate]:
    """Return Newton, Poisson and Stronge, both slips, and e by speed and by group.

    Along the path only where no impact has more than one contact, as the laws have it; e by
    group only where there are several.
    """
    found = [
        LawCandidate("Newton, slip at the end", Law()),
        LawCandidate("Poisson, slip at the end", Law("poisson")),
    ]
    alone = all(len(m.scene.contacts) == 1 for m in measurements)
    if alone:
        found += [
            LawCandidate(f"{law.capitalize()}, along the path", Law(law, "path"))
            for law in ("newton", "poisson", "stronge")
        ]
    speeds = _speeds(measurements)
    if len(speeds) > 1:
        found.append(LawCandidate("Newton, e by speed", Law(), speeds=speeds))
        if alone:
            law = Law("poisson", "path")
            found.append(LawCandidate("Poisson, along the path, e by speed", law, speeds=speeds))
    if len({m.group for m in measurements}) > 1:
        found.append(LawCandidate("Newton, e by contact type", Law(), by_group=True))
    return found


def _speeds(measurements: Sequence[Measurement]) -> tuple[float, ...]:
    """Return the speeds at which e is fitted: rounded percentiles of the approach speeds."""
    from ..impact.solver import solve_without_warnings

    found = []
    for m in measurements[:: max(1, len(measurements) // MOST_LOOKED_AT)]:
        impact = solve_without_warnings(scene_of(m, [], np.zeros(0), {}), m.q, m.v_before)
        found += [
            -float(contact.points[0].normal @ contact.velocity_before)
            for contact in impact.contacts
            if contact.points and contact.points[0].normal is not None
        ]
    approaching = [speed for speed in found if speed > 0.0]
    if not approaching:
        return ()
    points = [float(f"{p:.2g}") for p in np.percentile(approaching, PERCENTILES)]
    kept: list[float] = []
    for point in points:
        if not kept or point - kept[-1] > TOO_NEAR * points[-1]:
            kept.append(point)
    return tuple(kept)


# Impacts for each fold at least, to fit and to be compared with.
FEWEST_A_FOLD = 2
# Resamples determine a probability to some 0.01.
RESAMPLES = 4000
# A table lists so many coefficients of a law.
MOST_SHOWN = 8
# A law as good as the best one with more than this probability is not distinguished from it.
NOT_DISTINGUISHED = 0.05


@public
@dataclass(frozen=True, eq=False, repr=False)
class LawComparison(Displayed):
    """Predictions of laws for impacts that took no part in their fits; arrays are read-only.

    Sizes of velocities are in the metric of the kinetic energy, |v| = √(vᵀ M v), so that metres
    and radians go together.

    Attributes:
        names: (K,) the candidates, the best first.
        errors: (K, N) |v⁺ predicted − measured| over |v⁻|, of each impact when it was held out.
        of_after, of_change: (K,) the median of the same over |v⁺| and over |v⁺ − v⁻|.
        better: (K, K) the probability that the mean error of one is less than that of another,
            by resampled impacts (bootstrap of the differences).
        fits: (K,) the fit of each to all impacts.
        left_out: candidates that could not be compared, and why.
        notes: what to look at.

    Example:
        >>> import impulsekit as ik
        >>> ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5, name="floor")])
        >>> seen = [ik.measured.Measurement(scene, ball.neutral(), [0, 0, -w, 0, 0, 0],
        ...                                 [0, 0, 0.8 * w, 0, 0, 0]) for w in (1, 2, 3, 4, 5, 6)]
        >>> laws = [ik.measured.LawCandidate("Newton"),
        ...         ik.measured.LawCandidate("Poisson", ik.Law("poisson"))]
        >>> found = compare_laws(seen, laws, restitution=["floor"], folds=3)
        >>> bool(found.errors.max() < 1e-6), found.better.shape
        (True, (2, 2))
    """

    names: tuple[str, ...]
    errors: np.ndarray = field(repr=False)
    of_after: np.ndarray
    of_change: np.ndarray
    better: np.ndarray = field(repr=False)
    fits: tuple[Fit, ...] = field(repr=False)
    left_out: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        pairs = zip(self.names, np.median(self.errors, axis=1), strict=True)
        medians = [f"{name}: {100 * error:.3g} %" for name, error in pairs]
        return one_line("LawComparison", f"{self.errors.shape[1]} impacts", *medians)

    def table(self) -> tuple[tuple[str, ...], list[list[str]]]:
        """Return titles and rows: errors in per cent, probabilities, coefficients."""
        head = ("law", "mean", "median", "of v after", "of change", "better than the best",
                "coefficients")  # fmt: skip
        rows = []
        for k, (name, fit) in enumerate(zip(self.names, self.fits, strict=True)):
            values = zip(fit.names, fit.values, fit.sigma, strict=True)
            own = self.errors[k]
            numbers = (own.mean(), np.median(own), self.of_after[k], self.of_change[k])
            found = ", ".join(f"{n} = {value:.3g} ± {s:.1g}" for n, value, s in values)
            if len(fit.names) > MOST_SHOWN:
                found = f"{len(fit.names)} coefficients, in fits[{k}]"
            better = "" if k == 0 else f"{self.better[k, 0]:.3f}"
            rows.append([name, *(f"{100.0 * x:.2f} %" for x in numbers), better, found])
        return head, rows

    def report(self) -> str:
        """Return the table as text."""
        lines: list[str] = list(table(*self.table()))
        lines += [f"left out: {name}: {why}" for name, why in self.left_out]
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines) + "\n"

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers of the table, ready for JSON."""
        return {
            "impacts": int(self.errors.shape[1]),
            "laws": [
                {
                    "name": name,
                    "mean_error": float(self.errors[k].mean()),
                    "median_error": float(np.median(self.errors[k])),
                    "median_of_after": float(self.of_after[k]),
                    "median_of_change": float(self.of_change[k]),
                    "better_than": dict(zip(self.names, self.better[k].tolist(), strict=True)),
                    "parameters": dict(zip(fit.names, fit.values.tolist(), strict=True)),
                }
                for k, (name, fit) in enumerate(zip(self.names, self.fits, strict=True))
            ],
            "left_out": dict(self.left_out),
            "notes": list(self.notes),
        }


@public
def compare_laws(
    measurements: Sequence[Measurement],
    candidates: Sequence[LawCandidate] | None = None,
    *,
    restitution: Sequence[str | Sequence[str]] = (),
    friction: Sequence[str | Sequence[str]] = (),
    robust: str = "huber",
    folds: int = 5,
    progress: Callable[[int, int], object] | None = None,
    seed: int = 0,
) -> LawComparison:
    """Fit each law to a part of measured impacts, and predict the others with it.

    All impacts are held out once (cross-validation, Stone 1974), all laws in the same folds.
    Impacts of one recording (``Measurement.recording``) are held out together: they share its
    errors, so that one predicts the others.

    Args:
        measurements: the impacts; ``FoundImpacts.measurements`` gives them.
        candidates: what to compare; by default Newton's, Poisson's and Stronge's law, slip at
            the end and along the path, e by speed, and e by ``Measurement.group``.
        restitution, friction, robust: as for ``fit_impacts``.
        folds: how many parts.
        progress: called with fits done and in all.
        seed: of folds and resamples.

    Raises:
        InputError: too few impacts, names twice, no candidate that can be compared, or as
            ``fit_impacts`` has it.
        RangeError: ``folds`` is below 2.

    Example:
        >>> import impulsekit as ik
        >>> file = ik.load_scene("examples/cube_tosses.toml")
        >>> tosses = ik.measured.load_recordings("examples/cube_tosses.npz", file.scene.robot)
        >>> seen = ik.measured.find_impacts(tosses, file.scene).measurements(file.scene)
        >>> print(compare_laws(seen, restitution=["corner_*"]).report())  # doctest: +SKIP
    """
    seen = list(measurements)
    folds = whole(folds, "compare_laws: folds", 2)
    if len(seen) < FEWEST_A_FOLD * folds:
        raise InputError(
            f"compare_laws: too few impacts; {folds} folds need {FEWEST_A_FOLD * folds} or more, "
            f"got {len(seen)}"
        )
    chosen = usual_candidates(seen) if candidates is None else list(candidates)
    if len({each.name for each in chosen}) < len(chosen):
        raise InputError("compare_laws: two candidates have one name")
    parts = _dealt(seen, folds, whole(seed, "seed", 0))
    options = {"restitution": restitution, "friction": friction, "robust": robust}
    sizes = _sizes(seen)
    rows, fits, left_out = [], [], []
    done, total = 0, len(chosen) * (folds + 1)
    for candidate in chosen:
        try:
            misses, fit = _held_out(seen, candidate, parts, sizes[0], options)
            rows.append((candidate.name, misses))
            fits.append(fit)
        except ImpulsekitError as error:
            left_out.append((candidate.name, str(error)))
        done += folds + 1
        if progress is not None:
            progress(done, total)
    if not rows:
        raise InputError(f"compare_laws: no law could be compared; {left_out[0][1]}")
    return _judged(rows, fits, left_out, sizes, seed)


def _dealt(seen: Sequence[Measurement], folds: int, seed: int) -> np.ndarray:
    """Return the (N,) fold of each impact, one for all impacts of a recording; folds of like sizes.

    Raises:
        InputError: fewer recordings than folds.
    """
    own: dict[str, list[int]] = {}
    for k, m in enumerate(seen):
        own.setdefault(m.recording or f"\0{k}", []).append(k)
    if len(own) < folds:
        raise InputError(
            f"compare_laws: {folds} folds need as many recordings, got {len(own)}; impacts of one "
            "recording are held out together"
        )
    several = list(own.values())
    order = np.random.default_rng(seed).permutation(len(own)).tolist()
    parts, counts = np.empty(len(seen), dtype=int), np.zeros(folds, dtype=int)
    # Long ones first, each to the smallest fold.
    for run in sorted((several[k] for k in order), key=len, reverse=True):
        parts[run] = part = int(np.argmin(counts))
        counts[part] += len(run)
    return parts


def _sizes(seen: Sequence[Measurement]) -> tuple[list[np.ndarray], np.ndarray]:
    """Return W with WᵀW = M of each impact, and (3, N) |v⁻|, |v⁺|, |v⁺ − v⁻|."""
    roots, sizes = [], np.empty((3, len(seen)))
    for k, m in enumerate(seen):
        nv = m.scene.robot.nv
        mass = flat_model_of(m.scene.robot).core.mass_matrix(np.array(m.q, dtype=float))
        roots.append(np.linalg.cholesky(mass.reshape(nv, nv)).T)
        before, after = np.array(m.v_before, dtype=float), np.array(m.v_after, dtype=float)
        for i, v in enumerate((before, after, after - before)):
            sizes[i, k] = np.linalg.norm(roots[-1] @ np.nan_to_num(v))
    return roots, np.maximum(sizes, NONZERO)


def _held_out(
    seen: Sequence[Measurement],
    candidate: LawCandidate,
    parts: np.ndarray,
    roots: list[np.ndarray],
    options: dict[str, Any],
) -> tuple[np.ndarray, Fit]:
    """Return the (N,) size of what the prediction of each impact is off, and the fit to all."""
    scenes = {id(m.scene): candidate.scene(m.scene) for m in seen}
    own = [replace(m, scene=scenes[id(m.scene)]) for m in seen]
    if candidate.group_of is not None:
        own = [replace(m, group=str(candidate.group_of(m))) for m in own]
    misses = np.empty(len(own))

    for part in range(int(parts.max()) + 1):
        held = np.flatnonzero(parts == part).tolist()
        others = [own[k] for k in np.flatnonzero(parts != part)]
        fit = fit_impacts(others, **options, by_group=candidate.by_group)
        found = SolvedImpacts([own[k] for k in held], fit.parameters).v_after(fit.values)
        for k, after in zip(held, found, strict=True):
            off = np.nan_to_num(np.array(own[k].v_after, dtype=float) - after)
            misses[k] = np.linalg.norm(roots[k] @ off)
    return misses, fit_impacts(own, **options, by_group=candidate.by_group)


def _judged(
    rows: Sequence[tuple[str, np.ndarray]],
    fits: Sequence[Fit],
    left_out: Sequence[tuple[str, str]],
    sizes: tuple[list[np.ndarray], np.ndarray],
    seed: int,
) -> LawComparison:
    before, after, change = sizes[1]
    misses = np.array([own for _, own in rows])
    order = np.argsort((misses / before).mean(axis=1), kind="stable")
    misses, names = misses[order], [rows[k][0] for k in order]
    errors = misses / before
    rng = np.random.default_rng(seed)
    drawn = rng.integers(errors.shape[1], size=(RESAMPLES, errors.shape[1]))
    means = np.array([own[drawn].mean(axis=1) for own in errors])
    less = (means[:, None] < means[None]).mean(axis=2)
    better = less + 0.5 * (means[:, None] == means[None]).mean(axis=2)
    close = [
        name for name, p in zip(names[1:], better[1:, 0], strict=True) if p > NOT_DISTINGUISHED
    ]
    notes = [f"not significantly worse than {names[0]}: {'; '.join(close)}"] if close else []
    ordered = [fits[k] for k in order]
    for name, fit in zip(names, ordered, strict=True):
        notes += [f"{name}: {note}" for note in fit.notes if "not determined" in note]
    of_after, of_change = (np.median(misses / size, axis=1) for size in (after, change))
    lock(errors, better, of_after, of_change)
    lists = (tuple(each) for each in (ordered, left_out, notes))
    return LawComparison(tuple(names), errors, of_after, of_change, better, *lists)
