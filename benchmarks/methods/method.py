"""What a method of the benchmark is, and springs and dampers in place of contacts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import PackageNotFoundError, version

import numpy as np
import pinocchio as pin

from ..problems.problem import Problem
from .mechanism import Mechanism

Answer = Callable[[], np.ndarray]


@dataclass(frozen=True)
class Method:
    """One way to solve problems.

    Attributes:
        name: "impulsekit, solve" or "mujoco, one step". Methods of one name differ in their
            setting; the diagrams join them by a line.
        peer: whether it is another program's or a classical way, not one of ours.
        needs: the packages it imports, by distribution name; where one is missing the
            method is left out, and the report says so.
        suits: whether it can take a problem at all.
        prepare: builds once what may be built once and gives the call that is timed, which
            returns the answer in the problem's own coordinates. One that works in another
            process is a ``TimesItself``.
        states: how many states one call answers; its time is divided by them.
        setting: what is turned up or down along that line, a tolerance, a step or a
            stiffness; None where there is nothing to turn.
        lacks: says what else is missing here and how to get it, "" where nothing is; for
            what is no package of this interpreter.
    """

    name: str
    suits: Callable[[Problem], bool]
    prepare: Callable[..., Answer]
    peer: bool = False
    needs: tuple[str, ...] = ()
    states: int = 1
    setting: float | None = None
    lacks: Callable[[], str] | None = None

    def at(self, settings: Iterable[float]) -> tuple[Method, ...]:
        """The method at each of some settings, which ``prepare`` takes behind the problem."""
        return tuple(
            replace(self, prepare=partial(_prepared, self.prepare, setting), setting=setting)
            for setting in settings
        )

    @property
    def label(self) -> str:
        """Name and setting: "mujoco, soft contacts, 0.001"."""
        return self.name if self.setting is None else f"{self.name}, {self.setting:g}"

    def missing(self) -> str:
        """What keeps it from running here, with the way to get it; "" where nothing does."""
        absent = [name for name in self.needs if not _is_installed(name)]
        if absent:
            return f'{" and ".join(absent)} not installed: pip install ".[peers]"'
        return self.lacks() if self.lacks else ""


def _prepared(prepare: Callable[..., Answer], setting: float, problem: Problem) -> Answer:
    return prepare(problem, setting)


def _is_installed(distribution: str) -> bool:
    try:
        version(distribution)
    except PackageNotFoundError:
        return False
    return True


# The largest damping ratio, where e is 1e-16, and what it is found to: rounding.
MOST_DAMPED, EXACT = 1e8, 1e-15


def restitution_of(ratio: float) -> float:
    """e of a spring with a damper that parts where its force ends, so that it never pulls.

    With ζ the damping ratio, ω = √(1 − ζ²) and the force ending at phase φ, e = exp(−ζ φ/ω),
    φ = atan2(2 ζ ω, 2 ζ² − 1); beyond critical damping the same with hyperbolic functions
    (Schwager & Pöschel 2007, "Coefficient of restitution and linear-dashpot model
    revisited"). It falls from 1 at ζ = 0 towards 0, which it never reaches.

    Example:
        >>> restitution_of(0.0)
        1.0
    """
    if ratio < 1.0:
        swing = math.sqrt(1.0 - ratio * ratio)
        phase = math.atan2(2.0 * ratio * swing, 2.0 * ratio * ratio - 1.0)
        return math.exp(-ratio / swing * phase)
    if ratio == 1.0:
        return math.exp(-2.0)
    swing = math.sqrt(ratio * ratio - 1.0)
    return math.exp(-ratio / swing * 2.0 * math.acosh(ratio))


def damping_ratio(restitution: float) -> float:
    """ζ of the damper that gives ``restitution``, in (0, 1].

    Example:
        >>> round(restitution_of(damping_ratio(0.5)), 12)
        0.5
    """
    from scipy.optimize import brentq

    if restitution == 1.0:
        return 0.0
    return float(
        brentq(lambda ratio: restitution_of(ratio) - restitution, 0.0, MOST_DAMPED, xtol=EXACT)
    )


# Of contacts that do not approach [m/s]: times are over it.
SLOWEST = 1e-12


def approach_speed(problem: Problem, mechanism: Mechanism) -> float:
    """The fastest approach of all contacts [m/s], above zero."""
    rows, _ = normal_rows(problem, mechanism)
    return max(float((-rows @ problem.v).max()), SLOWEST)


def half_swing(problem: Problem, mechanism: Mechanism, stiffness: float) -> float:
    """π √(m/k) [s] of the lightest contact, for springs of k [N/m]."""
    rows, inverse = normal_rows(problem, mechanism)
    lightest = float(np.einsum("ci,ij,cj->c", rows, inverse, rows).max())
    return math.pi / math.sqrt(stiffness * lightest)


def normal_rows(problem: Problem, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """(c, nv) rows of the normal velocities, and the inverse of M."""
    model = problem.scene.robot.model
    data = model.createData()
    inverse = np.array(pin.computeMinverse(model, data, problem.q))
    inverse = np.triu(inverse) + np.triu(inverse, 1).T
    pin.computeJointJacobians(model, data, problem.q)
    rows = np.zeros((len(mechanism.touches), model.nv))
    for row, touch in zip(rows, mechanism.touches, strict=True):
        turning = np.cross(touch.place, touch.normal)
        for body, sign in ((touch.body, 1.0), (touch.other, -1.0)):
            if body >= 0:
                jacobian = pin.getJointJacobian(model, data, body + 1, pin.ReferenceFrame.WORLD)
                jacobian = jacobian.reshape(6, -1)
                row += sign * (touch.normal @ jacobian[:3] + turning @ jacobian[3:])
    return rows, inverse
