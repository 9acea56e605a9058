"""Restitution, friction and inertias from measured velocity jumps, with their uncertainty.

Least squares on v⁺ by scipy, with derivatives by central differences. The covariance
is that of the linear model at the fit, s² (JᵀJ)⁻¹ (Bates & Watts 1988); where the noise is not
given or larger than given, no less than what the measurements differ by among themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import (
    InputError,
    NotFiniteError,
    RangeError,
    ShapeError,
    a_thing,
    check_kind,
    quoted,
)
from ..errors.calls import public
from ..robot.arrays import array_of, floats, lock
from ..scene import Scene
from ..tolerances import NONZERO
from .fit_result import (
    ROBUST,
    UNSEEN,
    Fit,
    block_weights,
    bounds_reached,
    is_misfit,
    not_seen,
    outliers,
    spread_of_measurements,
    whitening,
    widened,
)
from .parameters import Measurement, checked_sigma, groups_of, parameters_of
from .solved import SolvedImpacts

# A start this far inside its bounds: at a bound the solver could not take a first step.
INSIDE = 1e-6
# Changes of parameters, of the cost and of its slope, relative, behind which a fit has ended.
CONVERGED = 1e-12
# [of the largest] An eigenvalue below minus this is negative, and not a rounded 0.
INDEFINITE = 1e-9
# [of the square of a direction] Parameters with more than this in what no measurement determines.
BLIND = 1e-6

# Weights and values follow from each other in so many rounds at most, or until values settle.
MOST_ROUNDS, SETTLED = 12, 1e-6
# Steps of the least squares in a round.
FEW_STEPS = 3
# A parameter near zero is as well known as one of this size.
LEAST_SIZE = 1e-3
# Frictions from which a fit starts as well: dry contacts have 0.1 to 1. A third apart, since
# above the friction of the fastest slip every contact sticks, and below it all may slide.
FRICTIONS = tuple(0.02 * 1.36**k for k in range(15))


@public
def fit_impacts(
    measurements: Sequence[Measurement],
    *,
    restitution: Sequence[str | Sequence[str]] = (),
    friction: Sequence[str | Sequence[str]] = (),
    inertias: Mapping[str, Sequence[str]] | None = None,
    robust: str = "none",
    by_group: bool | Sequence[str] = False,
    stiffness_ratio: Sequence[str | Sequence[str]] = (),
) -> Fit:
    """Fit coefficients and inertias to measured impacts.

    All measurements share the parameters: contacts and joints are the same by name. A
    ``RestitutionTable`` in the scene is e by approach speed: its values are fitted. The fit starts
    from the values in the first measurement's scene. If a friction coefficient has no effect at
    the end (a contact that sticks does not depend on µ), the fit is repeated from a better start.
    Measurements of one scene are solved as a batch, with derivatives by differences.

    Args:
        measurements: the impacts, in one scene or in several with one robot.
        restitution, friction: names of contacts whose coefficient is fitted; a pattern such as
            ``corner_*`` or a tuple of names is one coefficient that all of these share.
        inertias: by joint, the fitted ones of ``INERTIA_PARAMETERS`` of the body behind it,
            about the joint's origin, in its frame.
        stiffness_ratio: names of contacts whose κ is fitted, under ``Law(slip="compliant")``.
            Start from a guess on its side of full reversal, beyond which speeds come back alike.
        robust: "none"; "huber" weighs down measurements that are off the others, "biweight"
            leaves out those that are far off.
        by_group: a restitution of its own for the measurements of each ``group``, such as impacts
            on a corner, an edge and a face; or which coefficients a group has of its own, such as
            ["restitution", "friction"].

    Raises:
        InputError: nothing to fit, too few numbers for the parameters, a restitution that
            is not a number, or as for ``derivatives``.
        UnknownNameError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5, name="floor")])
        >>> seen = [Measurement(scene, ball.neutral(), [0, 0, -w, 0, 0, 0],
        ...                     [0, 0, 0.8 * w, 0, 0, 0]) for w in (1.0, 2.0)]
        >>> round(fit_impacts(seen, restitution=["floor"])["floor: restitution"], 9)
        0.8
    """
    if robust not in ROBUST:
        raise RangeError.of("robust", quoted(robust), ", ".join(quoted(each) for each in ROBUST))
    problem = _Problem(
        measurements, restitution, friction, inertias or {}, by_group, stiffness_ratio
    )
    return problem.fit(robust)


class _Problem:
    """Measurements and parameters."""

    def __init__(
        self,
        measurements: Sequence[Measurement],
        restitution: Sequence[str | Sequence[str]],
        friction: Sequence[str | Sequence[str]],
        inertias: Mapping[str, Sequence[str]],
        by_group: bool | Sequence[str],
        stiffness_ratio: Sequence[str | Sequence[str]] = (),
    ) -> None:
        self._measurements = _all_measurements(measurements)
        if not self._measurements:
            raise InputError("fit_impacts: no measurements; give one or more")
        scenes = [measurement.scene for measurement in self._measurements]
        self._parameters = parameters_of(
            scenes,
            restitution,
            friction,
            inertias,
            *groups_of(self._measurements, by_group),
            stiffness_ratio,
        )
        if not self._parameters:
            raise InputError(
                "fit_impacts: nothing to fit; name contacts in restitution or friction, "
                "or joints in inertias"
            )
        self.names = tuple(parameter.name for parameter in self._parameters)
        self._start = np.array([parameter.start for parameter in self._parameters])
        self._low = np.array([parameter.low for parameter in self._parameters])
        self._high = np.array([parameter.high for parameter in self._parameters])
        self._read_measured()
        self._solved = SolvedImpacts(self._measurements, self._parameters)

    def _read_measured(self) -> None:
        self._after, self._seen = [], []
        self._whiteners: list[np.ndarray] = []
        self._covariances: dict[int, np.ndarray] = {}
        given = [m.sigma is not None or m.covariance is not None for m in self._measurements]
        if any(given) and not all(given):
            raise InputError("fit_impacts: give sigma for all measurements or for none")
        self._estimated = not any(given)
        for i, m in enumerate(self._measurements):
            nv = m.scene.robot.nv
            after = floats(m.v_after, f"measurements[{i}]: v_after")
            if after.shape != (nv,):
                raise ShapeError.of(f"measurements[{i}]: v_after", (nv,), after.shape)
            sigma = checked_sigma(
                1.0 if m.sigma is None else m.sigma, nv, f"measurements[{i}]: sigma"
            )
            sigma = np.broadcast_to(sigma, (nv,))
            if np.isinf(after).any():
                raise NotFiniteError.of(f"measurements[{i}]: v_after", "an entry", "an infinity")
            seen = ~np.isnan(after)
            self._after.append(after[seen])
            self._seen.append(seen)
            self._whiteners.append(np.diag(1.0 / sigma[seen]))
            if m.covariance is not None:
                self._covariances[i] = _checked_covariance(m, i, nv)
        self._factors = np.ones(len(self._measurements))
        count = sum(len(after) for after in self._after)
        self._freedom = count - len(self.names)
        if self._freedom < (1 if self._estimated else 0):
            raise InputError(
                f"fit_impacts: {count} measured numbers are too few for {len(self.names)} "
                "parameters and the noise"
            )

    def fit(self, robust: str) -> Fit:
        """Run the least squares; weights follow from its residuals, and it from them."""
        found = None
        start = self._start
        noisy = bool(self._covariances)
        rounds = MOST_ROUNDS if noisy or robust != "none" else 1
        if noisy:
            self._carry_noise(start)
        for turn in range(rounds):
            # Weights that leave out what is far off need a fit that is near already.
            kind = "huber" if robust == "biweight" and turn < 2 else robust
            # Weights change the sum: it is not worth its exact minimum before they have settled.
            found = self._least_squares(start, FEW_STEPS if rounds > 1 else None)
            moved = np.abs(found.x - start) > SETTLED * np.maximum(np.abs(found.x), LEAST_SIZE)
            start = found.x
            if turn + 1 == rounds or (turn > 2 and not moved.any()):
                break
            if noisy:
                self._carry_noise(start)
            if robust != "none":
                self._factors[:] = 1.0
                residual = self._both(start)[0]
                self._factors = np.sqrt(block_weights(kind, self._blocks_of(residual)))
        return self._result(self._least_squares(start) if rounds > 1 else found, robust)

    def _carry_noise(self, x: np.ndarray) -> None:
        """Whiten residuals v⁺ − f(q, v⁻) by the noise of all three, f linear about what was seen.

        The effective variance of Orear (1982): the first order of errors in variables.
        """
        for i, (by_q, by_v) in self._solved.slopes(x).items():
            own, seen = self._covariances[i], self._seen[i]
            to_residual = np.hstack([np.nan_to_num(by_q), np.nan_to_num(by_v), -np.eye(len(by_v))])
            to_residual = to_residual[seen]
            self._whiteners[i] = whitening(to_residual @ own @ to_residual.T)

    def _blocks_of(self, rows: np.ndarray) -> list[np.ndarray]:
        """Return rows by measurement."""
        return np.split(rows, np.cumsum([len(after) for after in self._after])[:-1])

    def _least_squares(self, first: np.ndarray, steps: int | None = None) -> Any:
        from scipy.optimize import least_squares

        size = np.maximum(np.abs(self._start), LEAST_SIZE)
        # Off the bounds, where a coefficient could not move both ways.
        inside = np.clip(
            first,
            np.where(np.isfinite(self._low), self._low + INSIDE, -np.inf),
            np.where(np.isfinite(self._high), self._high - INSIDE, np.inf),
        )

        def from_start(start: np.ndarray) -> Any:
            return least_squares(
                lambda x: self._both(x)[0],
                start,
                lambda x: self._both(x)[1],
                bounds=(self._low, self._high),
                x_scale=size,
                xtol=CONVERGED,
                ftol=CONVERGED,
                gtol=CONVERGED,
                max_nfev=steps,
            )

        found = from_start(inside)
        other = self._other_start(found.x)
        if other is not None:
            found = min(found, from_start(other), key=lambda fit: fit.cost)
        return found

    def _result(self, found: Any, robust: str) -> Fit:
        size = np.maximum(np.abs(self._start), LEAST_SIZE)
        residual, jacobian = self._both(found.x)
        noise = float(np.sqrt(residual @ residual / max(self._freedom, 1)))
        covariance = _covariance(jacobian * size) * np.outer(size, size)
        notes = not_seen(self.names, covariance)
        # Another friction may be seen, and fit better: unlike with inertias, that is no end.
        unseen = any(
            parameter.kind == "friction" and not np.isfinite(covariance[i, i])
            for i, parameter in enumerate(self._parameters)
        )
        notes += bounds_reached(self.names, found.x, self._low, self._high)
        left_out = self._factors**2 < 0.5
        freedom = self._freedom - sum(
            len(after) for after, out in zip(self._after, left_out, strict=True) if out
        )
        misfit = not self._estimated and is_misfit(residual, max(freedom, 1))
        if left_out.any():
            notes.append(
                f"{int(left_out.sum())} of {len(left_out)} measurements are off the others and "
                "count less than half"
            )
        if misfit:
            notes.append(
                f"the residuals are {noise:.3g} times the given sigma: the law, the contacts or "
                "sigma do not fit the measurements; the intervals rest on the residuals"
            )
        notes += outliers(residual, [len(after) for after in self._after])
        if self._estimated or misfit or robust != "none":
            # What is not seen stays so, however small the residuals are.
            if self._estimated or misfit:
                covariance[np.isfinite(covariance)] *= noise**2
            spread = spread_of_measurements(
                jacobian * size, residual, [len(after) for after in self._after]
            )
            covariance = widened(covariance, spread * size)
        values, bounds = found.x.copy(), np.stack([self._low, self._high], 1)
        weights = self._factors**2
        lock(values, covariance, residual, bounds, weights)
        return Fit(
            self.names,
            values,
            covariance,
            noise,
            self._freedom,
            residual,
            bool(found.success) and not unseen,
            str(found.message),
            self._estimated or misfit,
            not self._estimated,
            bounds,
            tuple(notes),
            weights,
            tuple(self._parameters),
            tuple(zip(self._blocks_of(jacobian), self._blocks_of(residual), strict=True)),
        )

    def _other_start(self, x: np.ndarray) -> np.ndarray | None:
        """Return a start with the best friction of a ladder, if no measurement sees it; or None."""
        jacobian = self._both(x)[1]
        better = x.copy()
        for i, parameter in enumerate(self._parameters):
            if parameter.kind == "friction" and not jacobian[:, i].any():
                costs = []
                for mu in (x[i], *FRICTIONS):
                    better[i] = mu
                    residual = self._both(better)[0]
                    costs.append((float(residual @ residual), mu))
                better[i] = min(costs)[1]
        return None if np.array_equal(better, x) else better

    def _both(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return residuals (N,), fitted less measured, over sigma, and their Jacobian (N, P)."""
        residuals, rows = [], []
        whiteners = [w * f for w, f in zip(self._whiteners, self._factors, strict=True)]
        for (v_after, columns), after, seen, whiten in zip(
            self._solved.at(x), self._after, self._seen, whiteners, strict=True
        ):
            residuals.append(whiten @ (v_after[seen] - after))
            rows.append(whiten @ columns[seen])
        return np.concatenate(residuals), np.concatenate(rows)


def _all_measurements(given: Any) -> tuple[Measurement, ...]:
    try:
        measurements = tuple(given)
    except TypeError:
        raise InputError(
            f"fit_impacts takes a list of Measurement objects, not {a_thing(given)}"
        ) from None
    for i, each in enumerate(measurements):
        if not isinstance(each, Measurement):
            raise InputError(f"measurements[{i}] must be a Measurement, not {a_thing(each)}")
        check_kind(each.scene, Scene, f"measurements[{i}]")
    return measurements


def _checked_covariance(m: Measurement, index: int, nv: int) -> np.ndarray:
    what = f"measurements[{index}]: covariance"
    if m.sigma is not None:
        raise InputError(f"{what} and sigma are both given; give one")
    covariance = array_of(m.covariance, (3 * nv, 3 * nv), what)
    values = np.linalg.eigvalsh(0.5 * (covariance + covariance.T))
    if values[0] < -INDEFINITE * max(values[-1], 0.0) or not values[-1] > 0.0:
        raise RangeError.of(what, f"eigenvalues from {values[0]:.3g}", "positive semidefinite")
    return covariance


def _covariance(jacobian: np.ndarray) -> np.ndarray:
    """Return (JᵀJ)⁻¹, with infinite variance for what is not seen."""
    _, values, ways = np.linalg.svd(jacobian, full_matrices=False)
    seen = values > UNSEEN * max(values[0], NONZERO)
    covariance = (ways[seen].T / values[seen] ** 2) @ ways[seen]
    blind = (ways[~seen] ** 2).sum(axis=0) > BLIND
    covariance[blind, blind] = np.inf
    return covariance
