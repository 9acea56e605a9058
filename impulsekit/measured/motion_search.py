"""Least points of losses: quadratics through few evaluations, Gauss-Newton without impacts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

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
    """(count, P) points of Sobol's sequence in a box; the first is ``centre`` where it is given."""
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
    """(P,) where the squared loss, as a quadratic of the parameters, is least within a box.

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
    """(count, P) the least points of means over resampled recordings (bootstrap, Efron 1979).

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
# Steps are halved so often where the sum does not fall, and end at this share of a deviation.
MOST_STEPS, HALVINGS, CONVERGED = 8, 4, 0.02
# On either side of an interval of 95 %.
TAIL = 0.025
# Residuals [m, rad] are over at least this.
LEAST = 1e-12


def smooth_fit(
    rollouts: Rollouts,
    scene_of: Callable[[np.ndarray], Scene],
    start: np.ndarray,
    box: np.ndarray,
    which: Sequence[int],
    resamples: int,
    seed: int,
) -> tuple[np.ndarray, np.ndarray] | None:
    """Least squares of the configurations at the samples, Huber's weights.

    Args:
        scene_of: the scene with the values (P,) of the unknowns.
        start: (P,). box: (2, P), which steps do not leave.
        which: of the recordings.
        resamples: how many; by the linear model at the least point (bootstrap, Efron 1979).

    Returns:
        (P,) unknowns where the sum is least, and (S, P) those of resampled recordings. None where
        motions have impacts or do not come to their ends, or do not depend on an unknown.
    """
    close = rollouts.with_settings(**CLOSE)
    states = [rollouts.starts[k] for k in which]
    residuals = _Residuals(close, scene_of, which)
    x = start
    left = residuals.at(x, states)
    if left is None:
        return None
    scale = np.maximum(np.median(np.abs(np.vstack(left)), axis=0) / MEDIAN_TO_SIGMA, LEAST)
    for _ in range(MOST_STEPS):
        linear = residuals.linear(x, states, left, scale, box)
        if linear is None or linear.blind(box):
            return None
        step, changes, deviations = linear.step()
        for _ in range(HALVINGS):
            after = np.clip(x + step, *box)
            moved = [_moved(residuals.model, s, c) for s, c in zip(states, changes, strict=True)]
            then = residuals.at(after, moved)
            if then is not None and _cost(then, scale) < _cost(left, scale):
                break
            step, changes = 0.5 * step, [0.5 * each for each in changes]
        else:
            break
        x, states, left = after, moved, then
        if (np.abs(step) <= CONVERGED * deviations).all():
            break
    linear = residuals.linear(x, states, left, scale, box)
    if linear is None:
        return None
    samples = linear.resampled(resamples, seed)
    return x, np.clip(x + samples, *box)


class _Residuals:
    """(T, nv) differences of each recording from its motion, on the tangents of its samples."""

    def __init__(
        self, rollouts: Rollouts, scene_of: Callable[[np.ndarray], Scene], which: Sequence[int]
    ) -> None:
        self._rollouts, self._scene_of, self._which = rollouts, scene_of, which
        self.model = rollouts.recordings[0].robot.model

    def at(self, x: np.ndarray, states: Sequence[State]) -> list[np.ndarray] | None:
        rows = self._rollouts.rows(self._scene_of(x), self._which, starts=states)
        found = []
        for k, row in zip(self._which, rows, strict=True):
            if row.status is not MotionStatus.FINISHED or len(row.impacts["time"]):
                return None
            pairs = zip(self._rollouts.recordings[k].q, row.q, strict=True)
            found.append(np.array([pin.difference(self.model, a, b) for a, b in pairs]))
        return found

    def linear(
        self,
        x: np.ndarray,
        states: Sequence[State],
        left: list[np.ndarray],
        scale: np.ndarray,
        box: np.ndarray,
    ) -> _Linear | None:
        """The residuals and their derivatives, over their deviations and with Huber's weights."""
        # How far each unknown is moved, and all of them then.
        moves: list[tuple[float, np.ndarray, Sequence[State]]] = []
        for i, step in enumerate(STEP * (box[1] - box[0])):
            # Away from the edge of the box.
            own = -step if x[i] + step > box[1, i] else step
            moves.append((own, x + own * np.eye(len(x))[i], states))
        for change in STEP * np.eye(2 * self.model.nv):
            moves.append((STEP, x, [_moved(self.model, state, change) for state in states]))
        columns: list[list[np.ndarray]] = [[] for _ in left]
        for own, values, starts in moves:
            ahead = self.at(values, starts)
            if ahead is None:
                return None
            for column, there, here in zip(columns, ahead, left, strict=True):
                column.append((there - here) / own)
        blocks = []
        for column, here in zip(columns, left, strict=True):
            weights = np.sqrt(_weights(here / scale)) / scale
            slopes = np.stack([(each * weights).ravel() for each in column], axis=1)
            blocks.append(((here * weights).ravel(), slopes[:, : len(x)], slopes[:, len(x) :]))
        return _Linear(blocks)


class _Linear:
    """Blocks (residual, A, B) of recordings: A for what all share, B for each one's first state."""

    def __init__(self, blocks: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> None:
        self._blocks = blocks
        self._normals, self._rights = [], []
        for left, common, own in blocks:
            basis, _ = np.linalg.qr(own)
            free = common - basis @ (basis.T @ common)
            self._normals.append(free.T @ free)
            self._rights.append(free.T @ left)

    def blind(self, box: np.ndarray) -> bool:
        """Return whether an unknown changes residuals by less than a deviation from end to end."""
        return bool((np.diagonal(sum(self._normals)) * (box[1] - box[0]) ** 2 < 1.0).any())

    def step(self) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
        """(P,) for what is shared, (2 nv,) for each first state, and (P,) deviations."""
        normal = sum(self._normals)
        inverse = np.linalg.pinv(np.asarray(normal))
        step = -inverse @ sum(self._rights)
        changes = [
            -np.linalg.lstsq(own, left + common @ step, rcond=None)[0]
            for left, common, own in self._blocks
        ]
        return step, changes, np.sqrt(np.diagonal(inverse))

    def resampled(self, count: int, seed: int) -> np.ndarray:
        """(count, P) changes of what is shared where recordings are drawn again.

        Few recordings spread too little (by (n − 1)/n), with Student's quantiles at the ends.
        """
        from scipy import stats

        rng, found = np.random.default_rng(seed), []
        normals, rights = np.array(self._normals), np.array(self._rights)
        n = len(normals)
        for _ in range(count):
            chosen = rng.integers(n, size=n)
            found.append(-np.linalg.pinv(normals[chosen].sum(0)) @ rights[chosen].sum(0))
        ends = stats.t.isf(TAIL, n - 1) / stats.norm.isf(TAIL)
        return np.sqrt(n / (n - 1.0)) * ends * np.array(found)


def _moved(model: pin.Model, state: State, change: np.ndarray) -> State:
    (q, v), nv = state, model.nv
    return np.array(pin.integrate(model, q, np.ascontiguousarray(change[:nv]))), v + change[nv:]


def _weights(sizes: np.ndarray) -> np.ndarray:
    return np.minimum(1.0, HUBER_OF_SMOOTH / np.maximum(np.abs(sizes), LEAST))


def _cost(left: list[np.ndarray], scale: np.ndarray) -> float:
    """Huber's sum."""
    total = 0.0
    for each in left:
        sizes = np.abs(each / scale)
        inside = 0.5 * np.minimum(sizes, HUBER_OF_SMOOTH) ** 2
        total += float((inside + HUBER_OF_SMOOTH * np.maximum(sizes - HUBER_OF_SMOOTH, 0.0)).sum())
    return total
