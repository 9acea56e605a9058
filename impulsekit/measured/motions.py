"""``fit_motion``: coefficients that make whole simulated motions follow recorded ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..design.parameters import (
    Parameter,
    changed_scene,
    force_parameters_of,
    parameters_of,
)
from ..errors import InputError, RangeError, UnknownNameError
from ..errors.calls import public
from ..formatting import OneLine, one_line
from ..scene import Scene
from ..scene.motion import MotionSettings
from ..scene.numbers import number, whole
from ..tolerances import NONZERO
from .motion_search import design_points, least_of, resampled_least, smooth_fit
from .recording import Recording, as_recordings
from .rollouts import QUICK, Rollouts

# Where a friction is looked for: dry contacts have 0.1 to 1; on a logarithmic scale.
FRICTION = (0.03, 1.5)
RESTITUTION = (0.0, 0.95)
# An inertia is looked for within this share of the scene's value, on either side; first moments and
# products, which may be zero, within this share of the mass times the radius of gyration.
INERTIA = 0.5
# A stiffness, damping or torque is looked for up to so many times the scene's value, and down to as
# small a share of it; on a logarithmic scale.
FORCE = 5.0
LOGARITHMIC = ("friction", "force")
# Stages: evaluations for each unknown besides two, share of the recordings, resamples.
STAGES = ((5, 0.12, 60), (4, 0.4, 60), (4, 1.0, 200))
FEWEST_RECORDINGS = 8
# A box shrinks to this many times the spread of resampled least points, and no further at once
# than to a share of itself.
WIDENED, LEAST_SHARE = 1.2, 0.12
# As a share of the last box: a value nearer to its edge may be best beyond it.
EDGE = 0.02
# As a share of the first box: nearer to its edge a value lies on it.
AT_EDGE = 1e-6
# Distances [m] and angles [rad] that losses are over are at least this.
LEAST_SIZE = 1e-12
# Of the first box: an interval that is wider leaves a parameter weakly determined.
WEAK = 0.1


@public
@dataclass(frozen=True, eq=False, repr=False)
class MotionFit(OneLine):
    """The result of a fit to whole motions, P parameters; arrays are read-only.

    Attributes:
        names: (P,) such as ``corner_*: friction``.
        values: (P,) where the mean loss over the fitted recordings is least.
        samples: (S, P) values of fits to resampled recordings (bootstrap).
        searched: (P, 2) the first box; what lies outside was never tried.
        box: (P, 2) the last one, within which values and samples lie.
        points: (K, P) all parameters that were tried, losses: (K,) the mean loss of each over
            those recordings that it was tried on, stage: (K,) in which round.
        errors: (F, 2) mean distance [m] and angle [rad] of the links over each fitted recording,
            at ``values``.
        held_out: (H, 2) the same of recordings that took no part in the fit.
        held_names: (H,) their names.
        scene: the scene with the values.
        notes: parameters that the recordings hardly determine, bounds reached, motions that
            did not come to their end.

    Example:
        >>> import impulsekit as ik
        >>> file = ik.load_scene("examples/cube_tosses.toml")
        >>> tosses = ik.measured.load_recordings("examples/cube_tosses.npz", file.scene.robot)
        >>> fit = fit_motion(tosses, file.scene, friction=["corner_*"])  # doctest: +SKIP
        >>> fit["corner_*: friction"], fit.intervals(), fit.held_out.mean(0)  # doctest: +SKIP
    """

    names: tuple[str, ...]
    values: np.ndarray
    samples: np.ndarray = field(repr=False)
    searched: np.ndarray = field(repr=False)
    box: np.ndarray = field(repr=False)
    points: np.ndarray = field(repr=False)
    losses: np.ndarray = field(repr=False)
    stage: np.ndarray = field(repr=False)
    errors: np.ndarray = field(repr=False)
    held_out: np.ndarray = field(repr=False)
    held_names: tuple[str, ...] = field(repr=False)
    scene: Scene = field(repr=False)
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> float:
        """Return the value of one parameter by name.

        Raises:
            UnknownNameError.
        """
        if name not in self.names:
            raise UnknownNameError.among("parameter", name, self.names, "fit_motion")
        return float(self.values[self.names.index(name)])

    def __repr__(self) -> str:
        ends = self.intervals()
        values = [
            f"{name} = {value:.4g} ({low:.3g} to {high:.3g})"
            for name, value, (low, high) in zip(self.names, self.values, ends, strict=True)
        ]
        return one_line("MotionFit", *values, notes=len(self.notes))

    def intervals(self, level: float = 0.95) -> np.ndarray:
        """Return (P, 2) percentiles of the resampled fits.

        Raises:
            RangeError: the level is not between 0 and 1.
        """
        if not 0.0 < level < 1.0:
            raise RangeError.of("level", level, "between 0 and 1")
        tail = 50.0 * (1.0 - level)
        return np.percentile(self.samples, [tail, 100.0 - tail], axis=0).T


@public
def fit_motion(
    recordings: Sequence[Recording],
    scene: Scene,
    *,
    restitution: Sequence[str | Sequence[str]] = (),
    friction: Sequence[str | Sequence[str]] = (),
    inertias: Mapping[str, Sequence[str]] | None = None,
    forces: Mapping[str, Sequence[str]] | None = None,
    held_out: float = 0.25,
    settings: MotionSettings | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
    seed: int = 0,
) -> MotionFit:
    """Fit coefficients so that simulated motions follow the recorded ones.

    Each recording is followed from the state at its first sample, which a fit to its first
    flight gives. The loss of a recording is the mean distance and the mean angle of its links, each
    over the median of the first round. It is evaluated at points of a box (Sobol's sequence), first
    on few recordings; a quadratic through the squares of the mean losses has the least point;
    least points of resampled recordings (bootstrap) give the next box, and the intervals. No
    derivative is needed: motions with many impacts have none of use. Motions without impacts have,
    and Gauss-Newton steps then end the search, with the first state of each recording unknown too.

    Args:
        recordings: calibrated, in the world of the scene.
        scene: where the fit starts from; ``values`` may lie anywhere in the box.
        restitution, friction: names of contacts, patterns (``corner_*``) or tuples of names that
            share one coefficient.
        inertias: as for ``fit_impacts``, within half of the scene's values.
        forces: "stiffness", "damping" or "torque" by the name of a force, such as ``{"bearing":
            ["damping"]}``; from a fifth to five times the scene's value.
        held_out: share of the recordings that takes no part, evenly taken.
        settings: of the motions; by default quick ones.
        threads: how many; None for all cores.
        progress: called with evaluations done and in all.
        seed: of points and resamples; the same seed gives the same fit.

    Raises:
        InputError: nothing to fit, too few recordings, no motion comes to its end.
        UnknownNameError, RangeError.

    Example:
        >>> import impulsekit as ik
        >>> file = ik.load_scene("examples/cube_tosses.toml")
        >>> tosses = ik.measured.load_recordings("examples/cube_tosses.npz", file.scene.robot)
        >>> fit = fit_motion(tosses, file.scene, friction=["corner_*"])  # doctest: +SKIP
        >>> print(fit, *fit.notes, sep="\\n")  # doctest: +SKIP
    """
    several = as_recordings(recordings, "fit_motion")
    check_choices(held_out, threads, seed)
    parameters = parameters_of(scene, restitution, friction, inertias or {})
    parameters += force_parameters_of(scene, forces or {})
    if not parameters:
        raise InputError("fit_motion: nothing to fit; name contacts in restitution or friction")
    apart = _evenly(len(several), held_out)
    fitted = [k for k in range(len(several)) if k not in apart]
    if len(fitted) < FEWEST_RECORDINGS:
        raise InputError(
            f"fit_motion: {len(fitted)} recordings to fit are too few, "
            f"give {FEWEST_RECORDINGS} or more"
        )
    rollouts = Rollouts(several, scene, settings or QUICK, threads)
    search = _Search(scene, parameters, rollouts, fitted, seed, progress)
    return search.result(several, sorted(apart))


def check_choices(held_out: float, threads: int | None, seed: int) -> None:
    """Refuse what ``fit_motion`` does not take, before anything long begins.

    Raises:
        RangeError, NotFiniteError: what is wrong.
    """
    if not 0.0 <= number(held_out, "held_out") < 1.0:
        raise RangeError.of("held_out", held_out, "0 or more and below 1")
    if threads is not None:
        whole(threads, "threads", 1)
    whole(seed, "seed", 0)


def _evenly(count: int, share: float) -> set[int]:
    """Return indices of about a share of all, evenly spread."""
    return set(np.flatnonzero(np.diff(np.floor(share * np.arange(count + 1)))).tolist())


class _Search:
    """Boxes that shrink about the least point of the loss."""

    refined = False

    def __init__(
        self,
        scene: Scene,
        parameters: Sequence[Parameter],
        rollouts: Rollouts,
        fitted: Sequence[int],
        seed: int,
        progress: Callable[[int, int], object] | None,
    ) -> None:
        self._scene, self._parameters, self._rollouts = scene, parameters, rollouts
        self._fitted, self._seed = np.array(fitted), seed
        self._progress, self._done = progress, 0
        self._log = np.array([each.kind in LOGARITHMIC for each in parameters])
        self._searched = self._inner(np.array([_searched(each) for each in parameters]).T).T
        self._kept: list[tuple[int, np.ndarray, float]] = []
        self._sizes = np.ones(2)
        self._failed = 0
        self._run()

    def _inner(self, values: np.ndarray) -> np.ndarray:
        """Return the coordinates of the search: logarithms of frictions and of forces."""
        return np.where(self._log, np.log(np.maximum(values, NONZERO)), values)

    def _outer(self, inner: np.ndarray) -> np.ndarray:
        return np.where(self._log, np.exp(inner), inner)

    def _run(self) -> None:
        count = len(self._parameters)
        plan = [(n * count + 2, max(FEWEST_RECORDINGS, round(share * len(self._fitted))), resamples)
                for n, share, resamples in STAGES]  # fmt: skip
        self._total = sum(n * r for n, r, _ in plan)
        low, high = self._searched.T
        centre: np.ndarray | None = None
        rng = np.random.default_rng(self._seed)
        for stage, (points, recordings, resamples) in enumerate(plan):
            chosen = np.sort(rng.permutation(self._fitted)[:recordings])
            inner = design_points(low, high, points, self._seed + stage, centre)
            losses = self._losses(inner, chosen, stage)
            mean = losses.mean(axis=1)
            self.samples = resampled_least(inner, losses, low, high, resamples, self._seed + stage)
            centre = least_of(inner, mean, low, high)
            self.low, self.high, self.centre = low, high, centre
            if stage == 0:
                # One point in a wide box is as good a guide as its quadratic.
                self.samples = np.vstack([self.samples, inner[np.argsort(mean)[:2]]])
            low, high = self._next_box(low, high, centre)
        self._refine(plan[-1][2])

    def _refine(self, resamples: int) -> None:
        """Take least-squares steps from the least point where motions have no impacts."""
        found = smooth_fit(
            self._rollouts, self._scene_of, self.centre, np.asarray(self._searched.T),
            self._fitted.tolist(), (resamples, self._seed),
        )  # fmt: skip
        self.refined = found is not None
        if found is not None:
            self.centre, self.samples = found
            self.low = np.minimum(self.low, self.centre)
            self.high = np.maximum(self.high, self.centre)

    def _scene_of(self, inner: np.ndarray) -> Scene:
        return changed_scene(self._scene, self._parameters, self._outer(inner))

    def _next_box(
        self, low: np.ndarray, high: np.ndarray, centre: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        ends = np.percentile(self.samples, [5.0, 95.0], axis=0)
        reach = WIDENED * np.maximum(ends[1] - centre, centre - ends[0])
        reach = np.maximum(reach, LEAST_SHARE * (high - low))
        first_low, first_high = self._searched.T
        return np.maximum(centre - reach, first_low), np.minimum(centre + reach, first_high)

    def _losses(self, inner: np.ndarray, chosen: np.ndarray, stage: int) -> np.ndarray:
        """Return (K, R) losses of points on recordings; a motion that fails counts as the worst."""
        errors = np.empty((len(inner), len(chosen), 2))
        for k, point in enumerate(inner):
            errors[k] = self._rollouts.errors(self._scene_of(point), chosen.tolist())
            self._done += len(chosen)
            if self._progress is not None:
                self._progress(self._done, self._total)
        failed = ~np.isfinite(errors).all(axis=2)
        self._failed += int(failed.sum())
        if failed.all():
            raise InputError(
                "fit_motion: no motion comes to its end from the recordings' first states; "
                "simulate one with the scene and look at its status"
            )
        if stage == 0:
            self._sizes = np.maximum(np.median(errors[~failed], axis=0), LEAST_SIZE)
        losses = (errors / self._sizes).sum(axis=2)
        losses[failed] = losses[~failed].max()
        for point, row in zip(inner, losses, strict=True):
            self._kept.append((stage, self._outer(point), float(row.mean())))
        return losses

    def result(self, recordings: Sequence[Recording], apart: Sequence[int]) -> MotionFit:
        """Return the fit, with the errors at its values on all recordings."""
        values = self._outer(self.centre)
        scene = self._scene_of(self.centre)
        errors = self._rollouts.errors(scene, self._fitted.tolist())
        held = self._rollouts.errors(scene, apart) if apart else np.empty((0, 2))
        samples = self._outer(self.samples)
        searched = self._outer(self._searched.T).T
        box = self._outer(np.stack([self.low, self.high])).T
        stages, points, losses = zip(*self._kept, strict=True)
        stage_of, tried = np.array(stages), np.array(points)
        found = MotionFit(
            names=tuple(each.name for each in self._parameters),
            values=values,
            samples=samples,
            searched=searched,
            box=box,
            points=tried,
            losses=np.array(losses),
            stage=stage_of,
            errors=errors,
            held_out=held,
            held_names=tuple(recordings[k].name for k in apart),
            scene=scene,
            notes=tuple(self._notes(errors, held)),
        )
        for value in vars(found).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        return found

    def _notes(self, errors: np.ndarray, held: np.ndarray) -> list[str]:
        notes = []
        ends = np.percentile(self.samples, [2.5, 97.5], axis=0)
        first_low, first_high = self._searched.T
        shown = np.stack([self._outer(end) for end in ends])
        for i, name in enumerate(each.name for each in self._parameters):
            low, high = shown[:, i]
            if ends[1, i] - ends[0, i] > WEAK * (first_high[i] - first_low[i]):
                found = f"resampled recordings give {low:.3g} to {high:.3g}"
                notes.append(f"{name} is weakly determined: {found}")
            for edge, word in ((first_low[i], "least"), (first_high[i], "largest")):
                if abs(self.centre[i] - edge) < AT_EDGE * (first_high[i] - first_low[i]):
                    notes.append(f"{name} is the {word} value that was searched")
            near = EDGE * (self.high[i] - self.low[i])
            if not self.refined and (
                (first_low[i] < self.low[i] and self.centre[i] - self.low[i] < near)
                or (self.high[i] < first_high[i] and self.high[i] - self.centre[i] < near)
            ):
                low, high = (self._outer(end)[i] for end in (self.low, self.high))
                notes.append(
                    f"{name} lies at the edge of the last box, {low:.3g} to {high:.3g}: its best "
                    "value may lie beyond; try another seed, or fewer unknowns"
                )
        if self._failed:
            notes.append(f"{self._failed} motions on the way did not come to their end")
        for what, own in (("fitted", errors), ("held-out", held)):
            lost = int((~np.isfinite(own).all(axis=1)).sum()) if len(own) else 0
            if lost:
                notes.append(f"{lost} {what} recordings are not followed to their end")
        return notes


def _searched(parameter: Parameter) -> tuple[float, float]:
    if parameter.kind == "friction":
        return FRICTION
    if parameter.kind == "restitution":
        return RESTITUTION
    if parameter.kind == "force":
        return parameter.start / FORCE, parameter.start * FORCE
    reach = INERTIA * parameter.scale
    return max(parameter.start - reach, parameter.low), parameter.start + reach
