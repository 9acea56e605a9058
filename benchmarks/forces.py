"""Peak force of an impact, beside MuJoCo's soft contact at the step that gives it to 1 %.

MuJoCo begins at the instant of touch and ends with the contact, in the fewest steps of its fastest
integrator that keep the peak within 1 %, and the time to read forces off its states is not counted:
it knows beforehand when the impact comes and how long it lasts. Both have a spring without losses,
F = k δ, and give the peak and the whole impulse.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from impulsekit.compliance.curves import PowerCurve
from impulsekit.compliance.history import force_history
from impulsekit.compliance.peaks import peak_forces
from impulsekit.impact import solve
from impulsekit.robot import Robot
from impulsekit.scene import Contact, Scene

from .methods.mechanism import mechanism_of
from .methods.method import normal_rows
from .methods.mujoco_model import CONTACT_TIME, Turned, mujoco_configuration, mujoco_model
from .problems.problem import Problem
from .timing import Times, in_turn
from .urdf import one_body

# The moment of inertia [kg m²] of the ball.
INERTIA = 0.004
# Largest relative error of a peak.
ALLOWED = 0.01
# Numbers of steps that are tried.
FEWEST, MOST = 3, 60
# States of a batch, and how often batches are timed.
STATES, ROUNDS = 4096, 21


def _ball() -> Problem:
    ball = one_body("ball", 1, INERTIA)
    v = ball.velocity(root_joint=[0.3, 0.0, -1.0, 0.0, 0.0, 0.0])
    return _struck(ball, ball.neutral(), v, Contact("ball", at=[0, 0, -0.1], restitution=1.0))


def _panda() -> Problem:
    panda = Robot.from_example("panda")
    q = panda.configuration(panda_joint2=0.3, panda_joint4=-1.8)
    v = panda.velocity(panda_joint2=0.8, panda_joint4=-0.5)
    return _struck(panda, q, v, Contact("panda_hand", at=[0, 0, 0.1], restitution=1.0))


def _talos() -> Problem:
    talos = Robot.from_example("talos", root="freeflyer")
    v = np.zeros(talos.nv)
    v[2] = -1.0
    return _struck(talos, talos.neutral(), v, Contact("left_sole_link", restitution=1.0))


STRUCK: dict[str, Callable[[], Problem]] = {"ball": _ball, "Panda": _panda, "Talos": _talos}


def _struck(robot: Robot, q: np.ndarray, v: np.ndarray, contact: Contact) -> Problem:
    scene = Scene(robot, contacts=[contact], gap_bound=math.inf)
    return Problem("struck", robot.nv, scene, q, v, lambda: v, "a spring")


def single_forces(name: str) -> Times:
    """One state after the other: ``solve`` and ``force_history`` against a run of steps."""
    import mujoco

    problem = STRUCK[name]()
    theirs = _Theirs(problem, 1)
    model, data = theirs.model, theirs.data[0]

    def run() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos, data.qvel = theirs.qpos, theirs.qvel[0]
        mujoco.mj_step(model, data, theirs.steps)

    return in_turn(one_peak(problem), run)


def batch_of_forces(name: str) -> Times:
    """Many states on one thread: ``peak_forces`` against ``mujoco.rollout``."""
    problem = STRUCK[name]()
    theirs = _Theirs(problem, STATES)
    return in_turn(many_peaks(problem, theirs.v), theirs.run, rounds=ROUNDS)


def one_peak(problem: Problem) -> Callable[[], float]:
    """The peak force of a state, as a call."""
    curve = spring_of(problem)
    return lambda: force_history(solve(problem.scene, problem.q, problem.v), curve).peak_force


def many_peaks(problem: Problem, v: np.ndarray) -> Callable[[], object]:
    """The peak forces at some velocities, as a call; a configuration for each, as theirs have."""
    states, curve = np.repeat(problem.q[None], len(v), axis=0), spring_of(problem)
    return partial(peak_forces, problem.scene, states, v, curve, threads=1)


def spring_of(problem: Problem) -> PowerCurve:
    """k of a half swing of MuJoCo's ``CONTACT_TIME`` with the contact's effective mass."""
    history = force_history(solve(problem.scene, problem.q, problem.v), PowerCurve(1.0, 1.0))
    mass = history.stored / (0.5 * float(_normal(problem) @ problem.v) ** 2)
    return PowerCurve(float(mass) * (math.pi / CONTACT_TIME) ** 2, 1.0)


def _normal(problem: Problem) -> np.ndarray:
    """(nv,) the normal row of the contact."""
    rows, _ = normal_rows(problem, mechanism_of(problem))
    return rows[0]


class _Theirs:
    """The same states of MuJoCo, and the fewest steps that keep the peak within 1 %.

    Attributes:
        steps: how many they take in and out.
        v: (states, nv) velocities before, in Pinocchio's axes.
    """

    def __init__(self, problem: Problem, states: int) -> None:
        import mujoco
        from mujoco import rollout

        mechanism = mechanism_of(problem)
        turned = Turned(mechanism)
        factors = np.linspace(0.5, 2.0, states) if states > 1 else np.ones(1)
        self.v = factors[:, None] * problem.v
        self.qvel = np.array([turned.to(v) for v in self.v])
        normal = turned.to(_normal(problem))
        peak = factors * spring_peak(problem)
        for steps in range(FEWEST, MOST):
            # The force of a step is that of the state it begins with: the deepest is the last.
            step = 0.5 * CONTACT_TIME / (steps - 1)
            self.steps, self.model = steps, mujoco_model(mechanism, step)
            self.qpos = mujoco_configuration(mechanism, self.model)
            self.data = [mujoco.MjData(self.model)]
            places = np.repeat(self.qpos[None], states, axis=0)
            self._start = np.hstack([np.zeros((states, 1)), places, self.qvel])
            with rollout.Rollout(nthread=0) as engine:
                path, _ = engine.rollout(self.model, self.data, self._start, nstep=steps)
            speeds = np.hstack([self._start[:, None], path])[:, :, 1 + self.model.nq :] @ normal
            mass = peak / (np.abs(speeds[:, 0]) * math.pi / CONTACT_TIME)
            found = np.abs(np.diff(speeds, axis=1)).max(axis=1) * mass / step
            if np.abs(found / peak - 1.0).max() <= ALLOWED:
                break
        # And as many out again.
        self.steps = 2 * self.steps - 1
        self._engine = rollout.Rollout(nthread=0)

    def run(self) -> None:
        """All states."""
        self._engine.rollout(self.model, self.data, self._start, nstep=self.steps)


def spring_peak(problem: Problem) -> float:
    """The peak force of ``spring_of`` [N]."""
    impact = solve(problem.scene, problem.q, problem.v)
    return force_history(impact, spring_of(problem)).peak_force
