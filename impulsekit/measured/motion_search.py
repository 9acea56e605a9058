"""Least points of losses: quadratics through few evaluations, least squares without impacts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import pinocchio as pin

from ..motion.record.status import MotionStatus
from ..scene import Scene
from .rollouts import Rollouts, State
from .segments import MEDIAN_TO_SIGMA

# A surrogate needs its constant, slopes and curvatures, and some points more.
RIDGE = 1e-6
# A loss that differs by less over a box is flat there [relative].
FLAT = 1e-3


def design_points(
    low: np.ndarray, high: np.ndarray, count: int, seed: int, centre: np.ndarray | None = None
) -> np.ndarray:
    """Return (count, P) points of Sobol's sequence in a box, ``centre`` first where given."""
    import warnings

    from scipy.stats import qmc

    sampler = qmc.Sobol(len(low), scramble=True, seed=seed)
    with warnings.catch_warnings():
        # Counts that are no power of two are balanced well enough here.
        warnings.simplefilter("ignore", UserWarning)
        unit = sampler.random(count)
    points = low + unit * (high - low)
    if centre is not None:
        points[0] = centre
    return np.asarray(points)


def least_of(
    points: np.ndarray,
    losses: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    counts: np.ndarray | None = None,
) -> np.ndarray:
    """Return (P,) where the squared loss, as a quadratic of the parameters, is least within a box.

    A mean of distances has the form √(c² + k² (x − x₀)²) about its least point: its square is
    the quadratic. Points of large loss count less, since the quadratic holds near the least.

    Args:
        points: (K, P). losses: (K,), above zero. low, high: (P,) the box.
        counts: (K,) how much each point counts; all alike by default.
    """
    from scipy.optimize import lsq_linear, minimize

    unit = 2.0 * (points - low) / (high - low) - 1.0
    count = unit.shape[1]
    pairs = [(i, j) for i in range(count) for j in range(i, count)]
    if len(points) < 1 + count + len(pairs):
        # Too few for products: curvatures of single parameters alone.
        pairs = [(i, i) for i in range(count)]
    basis = np.column_stack(
        [np.ones(len(unit)), unit, *(unit[:, i] * unit[:, j] for i, j in pairs)]
    )
    squares = (losses / losses.min()) ** 2
    weights = (1.0 if counts is None else np.sqrt(counts)) / squares
    bounds = np.full(basis.shape[1], -np.inf)
    for k, (i, j) in enumerate(pairs):
        if i == j:
            # No curvature below zero: the least point would be a corner of the box.
            bounds[1 + count + k] = 0.0
    ridge = np.sqrt(RIDGE * len(unit)) * np.eye(basis.shape[1])
    found = lsq_linear(
        np.vstack([basis * weights[:, None], ridge]),
        np.concatenate([squares * weights, np.zeros(len(ridge))]),
        bounds=(bounds, np.inf),
    ).x

    slope, curvature = found[1 : 1 + count], np.zeros((count, count))
    for (i, j), own in zip(pairs, found[1 + count :], strict=True):
        curvature[i, j] += own
        curvature[j, i] += own

    def value(x: np.ndarray) -> tuple[float, np.ndarray]:
        bent = curvature @ x
        return float(x @ (slope + 0.5 * bent)), slope + bent

    starts = [unit[int(np.argmin(losses))], np.zeros(count)]
    # scipy's L-BFGS-B wakes all threads of BLAS at each step, 20 times the work of so small a sum.
    ends = [
        minimize(value, start, jac=True, bounds=[(-1.0, 1.0)] * count, method="TNC")
        for start in starts
    ]
    best = min(ends, key=lambda end: end.fun).x
    return np.asarray(low + 0.5 * (best + 1.0) * (high - low))


def resampled_least(
    points: np.ndarray,
    losses: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    count: int,
    seed: int,
) -> np.ndarray:
    """Return the (count, P) least points of resampled recordings' means (Efron 1979).

    Points count by random weights besides (Rubin 1981): motions with many impacts are rough
    functions of their coefficients, and the few points of a quadratic feel it.

    Args:
        points: (K, P). losses: (K, R) by point and recording.
    """
    rng = np.random.default_rng(seed)
    recordings = losses.shape[1]
    found = np.empty((count, points.shape[1]))
    for k in range(count):
        chosen = rng.integers(recordings, size=recordings)
        mean = losses[:, chosen].mean(axis=1)
        if mean.max() - mean.min() <= FLAT * mean.max():
            # A loss that is the same everywhere has its least point anywhere.
            found[k] = low + rng.random(len(low)) * (high - low)
            continue
        counts = rng.exponential(size=len(points))
        found[k] = least_of(points, mean, low, high, counts)
    return found


# Derivatives are differences over this share of the box of an unknown, or over this change of a
# state [rad, m, 1/s]; motions are followed to a ten-thousandth of it.
STEP, CLOSE = 1e-4, {"rtol": 1e-8, "atol": 1e-10}
# Residuals beyond so many deviations count as in a sum of sizes, not of squares (Huber 1964).
HUBER_OF_SMOOTH = 2.0
MOST_STEPS = 8
# On either side of an interval of 95 %.
TAIL = 0.025
# Residuals [m, rad] are over at least this.
LEAST = 1e-12
# Residuals, in deviations, where motions have impacts or do not come to their ends.
OUT_OF_REACH = 1e6


def smooth_fit(
    rollouts: Rollouts,
    scene_of: Callable[[np.ndarray], Scene],
    start: np.ndarray,
    box: np.ndarray,
    which: Sequence[int],
    resamples: tuple[int, int],
) -> tuple[np.ndarray, np.ndarray] | None:
    """Fit the configurations at the samples by least squares, with Huber's weights.

    Args:
        scene_of: the scene with the values (P,) of the unknowns.
        start: (P,). box: (2, P), which steps do not leave.
        which: of the recordings.
        resamples: how many, by the linear model at the least point (bootstrap, Efron 1979), and
            their seed.

    Returns:
        (P,) unknowns where the sum is least, and (S, P) those of resampled recordings. None where
        motions have impacts or do not come to their ends, or do not depend on an unknown.
    """
    from scipy.optimize import least_squares

    problem = _Smooth(rollouts.with_settings(**CLOSE), scene_of, which, box)
    z = np.concatenate([start, np.zeros(len(which) * problem.width)])
    # Of an unknown whose end-to-end effect is below a deviation nothing is determined.
    if not problem.begin(z) or (problem.information(z)[0].sum(0).diagonal() < 1.0).any():
        return None
    ends = np.full((2, len(z)), np.inf) * [[-1.0], [1.0]]
    ends[:, : len(start)] = box
    found = least_squares(
        problem.residuals, z, problem.jacobian, bounds=ends, x_scale="jac", loss="huber",
        f_scale=HUBER_OF_SMOOTH, max_nfev=MOST_STEPS,
    ).x  # fmt: skip
    x = found[: len(start)]
    samples = x + _resampled(*problem.information(found), *resamples) * (box[1] - box[0])
    return x, np.clip(samples, *box)


class _Smooth:
    """Recordings against motions; unknown are what all share, and the change of each first state.

    Attributes:
        width: how many unknowns each recording has of its own.
    """

    def __init__(
        self,
        rollouts: Rollouts,
        scene_of: Callable[[np.ndarray], Scene],
        which: Sequence[int],
        box: np.ndarray,
    ) -> None:
        self._rollouts, self._scene_of, self._which, self._box = rollouts, scene_of, which, box
        self._model = rollouts.recordings[0].robot.model
        self.width, self._scale = 2 * self._model.nv, np.ones(self._model.nv)
        counts = [len(rollouts.recordings[k].t) * self._model.nv for k in which]
        self._ends = np.cumsum([0, *counts]).tolist()

    def begin(self, z: np.ndarray) -> bool:
        """Take the deviations of the residuals from those at a start; False if it has none."""
        first = self.residuals(z).reshape(-1, self._model.nv)
        if (first == OUT_OF_REACH).all():
            return False
        self._scale = np.maximum(np.median(np.abs(first), axis=0) / MEDIAN_TO_SIGMA, LEAST)
        return True

    def residuals(self, z: np.ndarray) -> np.ndarray:
        """Return the differences on the tangents of all samples, over their deviations."""
        count = len(z) - len(self._which) * self.width
        changes = z[count:].reshape(-1, self.width)
        starts = [
            _moved(self._model, self._rollouts.starts[k], change)
            for k, change in zip(self._which, changes, strict=True)
        ]
        found = []
        rows = self._rollouts.rows(self._scene_of(z[:count]), self._which, starts=starts)
        for k, row in zip(self._which, rows, strict=True):
            if row.status is not MotionStatus.FINISHED or len(row.impacts["time"]):
                return np.full(self._ends[-1], OUT_OF_REACH)
            pairs = zip(self._rollouts.recordings[k].q, row.q, strict=True)
            off = np.array([pin.difference(self._model, a, b) for a, b in pairs])
            found.append((off / self._scale).ravel())
        return np.concatenate(found)

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """Return the derivatives of the residuals by differences, all first states at once."""
        count = self._box.shape[1]
        here, found = self.residuals(z), np.zeros((self._ends[-1], len(z)))
        for i, step in enumerate(STEP * (self._box[1] - self._box[0])):
            # Away from the edge of the box.
            own = -step if z[i] + step > self._box[1, i] else step
            found[:, i] = (self.residuals(z + own * np.eye(len(z))[i]) - here) / own
        for j in range(self.width):
            moved = z.copy()
            moved[count + j :: self.width] += STEP
            change = (self.residuals(moved) - here) / STEP
            for k, (begin, end) in enumerate(pairwise(self._ends)):
                found[begin:end, count + k * self.width + j] = change[begin:end]
        return found

    def information(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the normal equations of the shared unknowns, over their boxes, by recording.

        (R, P, P) and (R, P), each recording's first state eliminated, with Huber's weights.
        """
        count, left, slopes = self._box.shape[1], self.residuals(z), self.jacobian(z)
        roots = np.sqrt(np.minimum(1.0, HUBER_OF_SMOOTH / np.maximum(np.abs(left), LEAST)))
        left, slopes = left * roots, slopes * roots[:, None]
        normals, rights = [], []
        for k, (begin, end) in enumerate(pairwise(self._ends)):
            own = slice(count + k * self.width, count + (k + 1) * self.width)
            common = slopes[begin:end, :count] * (self._box[1] - self._box[0])
            basis, _ = np.linalg.qr(slopes[begin:end, own])
            free = common - basis @ (basis.T @ common)
            normals.append(free.T @ free)
            rights.append(free.T @ left[begin:end])
        return np.array(normals), np.array(rights)


def _resampled(normals: np.ndarray, rights: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Return (count, P) changes of what is shared where recordings are drawn again.

    Few recordings spread too little (by (n − 1)/n), with Student's quantiles at the ends.
    """
    from scipy import stats

    rng, n = np.random.default_rng(seed), len(normals)
    found = []
    for _ in range(count):
        chosen = rng.integers(n, size=n)
        found.append(-np.linalg.pinv(normals[chosen].sum(0)) @ rights[chosen].sum(0))
    ends = stats.t.isf(TAIL, n - 1) / stats.norm.isf(TAIL)
    return np.sqrt(n / (n - 1.0)) * ends * np.array(found)


def _moved(model: pin.Model, state: State, change: np.ndarray) -> State:
    (q, v), nv = state, model.nv
    return np.array(pin.integrate(model, q, np.ascontiguousarray(change[:nv]))), v + change[nv:]
