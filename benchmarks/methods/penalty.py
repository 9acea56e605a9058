"""Penalty contact: no impulse, but stiff springs, followed in time until all have let go.

The classical alternative. As the stiffness k goes up the contact gets shorter, bodies move less
while it lasts, and what comes out goes to an impulsive answer as k^(-1/2). Which one:

- one contact, with friction or without: Stronge's restitution with slip along the path (Routh);
  without friction that is Newton's and Poisson's as well;
- one contact that slides one way throughout: all laws, as they agree there;
- several contacts at once: an answer of the springs' own, which depends on the ratios of their
  stiffnesses whatever their size. It agrees with a law of simultaneous impacts only where
  symmetry leaves no choice, so on most such problems the error stays where it is.

It never goes to Newton's law with slip at the end where slip stops on the way.

Two ways through the contact: LSODA, which steps as its tolerance asks, and semi-implicit Euler
with √k steps, what a simulator with fixed steps does. Tolerance and creep speed go down with k,
so that no setting but k is left.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pinocchio as pin

from impulsekit.motion.tree.chart import Chart

from ..problems.problem import Problem
from .mechanism import Mechanism, is_landing, mechanism_of
from .method import Answer, Method
from .springs import PressedContact, Pressing, Springs
from .swing import approach_speed, half_swing

__all__ = ["METHODS"]

# N/m. Euler's steps go with the root of it, and so does its time.
ADAPTIVE = (1e3, 1e5, 1e7, 1e9, 1e11)
FIXED = (1e3, 1e5, 1e7)
# A contact that comes on more slowly than this, against the fastest, does no more.
SLOW = 1e-9
# A resting contact is pressed once it is so far in, against what the fastest goes in.
SLACK = 1e-6
# So long, in half swings, and so many changes of phase, before it is given up.
LONGEST, MOST_PHASES = 100.0, 100
# The loosest relative tolerance, and the first step in half swings.
LOOSEST, FIRST = 1e-3, 1e-3
# Of contacts; more take seconds, and go to no law's answer anyway.
MOST_CONTACTS = 4


def _suits(problem: Problem) -> bool:
    return is_landing(problem) and len(problem.scene.contacts) <= MOST_CONTACTS


class _Setting:
    """What does not depend on the state: springs, the time scale, the sizes of things."""

    def __init__(self, problem: Problem, stiffness: float) -> None:
        self.mechanism: Mechanism = mechanism_of(problem)
        self.model = pin.Model(problem.scene.robot.model)
        self.model.gravity.setZero()
        self.q, self.v, self.stiffness = problem.q, problem.v, stiffness
        self.approach = approach_speed(problem, self.mechanism)
        self.half_swing = half_swing(problem, self.mechanism, stiffness)

    def springs(self, creep: float) -> Springs:
        """All contacts as they are at first: those that approach are pressed."""
        slack = SLACK * self.approach * self.half_swing
        springs = Springs(self.model, self.mechanism, self.stiffness, creep, slack)
        springs.acceleration(self.q, self.v)
        for contact in springs.contacts:
            contact.print = contact.depth
            if contact.speed > SLOW * self.approach:
                springs.press(contact)
        return springs


def _by_lsoda(problem: Problem, stiffness: float) -> Answer:
    from scipy.integrate import solve_ivp

    setting = _Setting(problem, stiffness)
    chart, nv = Chart(setting.model), setting.model.nv
    tolerance = min(LOOSEST, 0.03 / math.sqrt(stiffness))
    slow = SLOW * setting.approach
    size = float(np.abs(setting.v).max())
    small = np.repeat([size * setting.half_swing, size], nv) * tolerance

    def velocity_after() -> np.ndarray:
        springs = setting.springs(setting.approach / math.sqrt(stiffness))
        y = np.concatenate([chart.centred(setting.q), setting.v])

        def rates(t: float, y: np.ndarray) -> np.ndarray:
            x, v = y[:nv], y[nv:]
            q = chart.configuration(x)
            return np.concatenate([chart.rate(x, q, v), springs.acceleration(q, v)])

        now, end = 0.0, LONGEST * setting.half_swing
        for _ in range(MOST_PHASES):
            rates(now, y)
            if springs.is_over(slow):
                return y[nv:]
            events = [_change(springs, contact, rates) for contact in springs.contacts]
            run = solve_ivp(
                rates,
                (now, end),
                y,
                method="LSODA",
                rtol=tolerance,
                atol=small,
                events=events,
                first_step=FIRST * setting.half_swing,
            )
            now, y = float(run.t[-1]), run.y[:, -1]
            rates(now, y)
            if run.status != 1:
                # Nothing changes any more, or it takes longer than an impact does.
                return y[nv:] if springs.is_over(math.inf) else np.full(nv, np.nan)
            for contact, times in zip(springs.contacts, run.t_events, strict=True):
                if len(times):
                    springs.next_phase(contact)
            # What ends at the same instant is not told of.
            springs.pass_on()
        return np.full(nv, np.nan)

    return velocity_after


def _change(
    springs: Springs, contact: PressedContact, rates: Callable[[float, np.ndarray], np.ndarray]
) -> Callable[[float, np.ndarray], float]:
    """The event that ends the phase of a contact."""

    def event(t: float, y: np.ndarray) -> float:
        rates(t, y)
        return springs.margin(contact)

    event.terminal = True  # type: ignore[attr-defined]
    event.direction = 1.0 if contact.at is Pressing.FREE else -1.0  # type: ignore[attr-defined]
    return event


def _by_euler(problem: Problem, stiffness: float) -> Answer:
    setting = _Setting(problem, stiffness)
    steps = math.sqrt(stiffness)
    step = setting.half_swing / steps
    slow = SLOW * setting.approach
    # Less would have friction turn the slip about within a step.
    rough = max(touch.friction for touch in setting.mechanism.touches)
    creep = setting.approach * 10.0 * max(1.0, rough) / steps

    def velocity_after() -> np.ndarray:
        springs = setting.springs(creep)
        q, v = setting.q, setting.v
        for _ in range(int(LONGEST * steps)):
            acceleration = springs.acceleration(q, v)
            springs.pass_on()
            if springs.is_over(slow):
                return v
            v = v + step * acceleration
            q = pin.integrate(setting.model, q, step * v)
        return v if springs.is_over(math.inf) else np.full_like(v, np.nan)

    return velocity_after


METHODS: tuple[Method, ...] = (
    *Method("penalty contact, LSODA", _suits, _by_lsoda, peer=True).at(ADAPTIVE),
    *Method("penalty contact, Euler", _suits, _by_euler, peer=True).at(FIXED),
)
