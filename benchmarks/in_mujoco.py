"""The cost of ``impulsekit.mujoco.Impacts`` beside ``mj_step``, in processor time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Literal

import mujoco
import numpy as np

from impulsekit.mujoco import Impacts

from .landing_rank import CROUCHED, solo12

# Runs of two seconds, and boxes dropped.
ROUNDS, DROPS = 5, 200
BOX = """<mujoco><option integrator="RK4"/><worldbody><geom type="plane" size="5 5 .1"/>
<body pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1"/></body></worldbody></mujoco>"""


def _trot(data: Any) -> None:
    """Lift diagonal legs in turn, 1.8 times a second, by position control."""
    lift = 0.35 * np.sin(2 * np.pi * 1.8 * data.time) * np.array([1.0, -1.0, -1.0, 1.0])
    pose = CROUCHED.reshape(4, 3).copy()
    bend = np.maximum(lift, 0.0) * [1.0, 1.0, -1.0, -1.0]
    pose[:, 1] += bend
    pose[:, 2] -= 2.0 * bend
    data.qfrc_applied[6:] = 6.0 * (pose.ravel() - data.qpos[7:]) - 0.15 * data.qvel[6:]


def _processor_time(step: Callable[[], object], data: Any) -> float:
    """Time of the steps of two seconds of a trot [s]."""
    spent = 0.0
    while data.time < 2.0:
        _trot(data)
        begin = time.thread_time()
        step()
        spent += time.thread_time() - begin
    return spent


def running() -> list[float]:
    """Solo12 trots with some eight impacts a second, RK4 at 2 ms: with impacts over without."""
    model = solo12()
    model.opt.timestep, model.opt.integrator = 0.002, mujoco.mjtIntegrator.mjINT_RK4

    def run(with_impacts: bool) -> float:
        data = mujoco.MjData(model)
        data.qpos[2], data.qpos[7:] = 0.26, CROUCHED
        impacts = Impacts(model, 0.0)
        return _processor_time(
            (lambda: impacts.step(data)) if with_impacts else lambda: mujoco.mj_step(model, data),
            data,
        )

    return [run(True) / run(False) for _ in range(ROUNDS)]


def impact_cost(instant: Literal["exact", "step"]) -> list[float]:
    """What an impact of a box on four contacts takes beyond a step without one [µs]."""
    model = mujoco.MjModel.from_xml_string(BOX)
    data = mujoco.MjData(model)
    impacts = Impacts(model, 0.5, instant=instant)
    costs = []
    for i in range(DROPS):
        mujoco.mj_resetData(model, data)
        data.qpos[2], data.qvel[2] = 0.1051 + 1e-4 * (i % 7), -1.0
        spent: list[float] = []
        while not spent or not impacts.last:
            begin = time.thread_time()
            impacts.step(data)
            spent.append(time.thread_time() - begin)
        costs.append(1e6 * (spent[-1] - spent[-2]))
    return costs
