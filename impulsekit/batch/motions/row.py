"""One row of a batch of motions: its scene, its motion, and what is kept of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import ImpulsekitError
from ...impact.contact_results import contact_impulses
from ...impact.status import Status
from ...motion.record.status import MotionStatus
from ...motion.simulate import simulate
from ...scene import Scene
from ...scene.motion import MotionSettings
from ..inputs import BatchInputs
from ..rows import scene_of_row, varies

if TYPE_CHECKING:
    from ...motion.record.trajectory import Trajectory

__all__ = ["RowResult", "followed_row", "motion_of_row", "row_without"]


@dataclass(frozen=True, eq=False)
class RowResult:
    """What is kept of a motion.

    Attributes:
        status: how it ended. detail: what else there is to say.
        end: up to when it was followed [s]; NaN where it was refused.
        q: (T, nq) at the sample times, NaN after the end. v: (T, nv).
        q_end: (nq,) at the end. v_end: (nv,).
        impacts: by column of ``ImpactTable``, one entry for each impact.
        rests: (contact, start [s], end [s]).
        evaluations: of the accelerations.
    """

    status: MotionStatus
    detail: str
    end: float
    q: np.ndarray
    v: np.ndarray
    q_end: np.ndarray
    v_end: np.ndarray
    impacts: dict[str, np.ndarray]
    rests: tuple[tuple[str, float, float], ...]
    evaluations: int


def motion_of_row(
    scene: Scene,
    inputs: BatchInputs,
    row: int,
    settings: MotionSettings,
    times: np.ndarray,
) -> Trajectory:
    """The motion of a row, as ``simulate`` gives it.

    Raises:
        ImpulsekitError: it is refused.
    """
    own = scene_of_row(scene, inputs, row) if varies(scene, inputs) else scene
    q, v = (array[row if len(array) > 1 else 0] for array in (inputs.q, inputs.v))
    return simulate(own, q, v, settings=settings, samples=times)


def followed_row(
    scene: Scene,
    inputs: BatchInputs,
    settings: MotionSettings,
    times: np.ndarray,
    impacts: bool = True,
) -> RowResult:
    """Follow the only row of ``inputs``; a row that is refused is told as such.

    Args:
        impacts: whether they are kept; half of the work where motions are short.

    Raises:
        ImpulsekitError: a function of the scene is at fault, which is no fault of the row.
    """
    if inputs.codes[0] != Status.SOLVED:
        return row_without(
            scene, times, MotionStatus.REFUSED, str(Status(int(inputs.codes[0])).value)
        )
    try:
        motion = motion_of_row(scene, inputs, 0, settings, times)
    except ImpulsekitError as error:
        if error.from_function:
            raise
        return row_without(scene, times, MotionStatus.REFUSED, str(error))
    return _kept(motion, times, impacts)


def row_without(
    scene: Scene, times: np.ndarray, status: MotionStatus, detail: str = ""
) -> RowResult:
    """A row of which nothing is known."""
    robot, count = scene.robot, len(times)
    return RowResult(
        status,
        detail,
        np.nan,
        np.full((count, robot.nq), np.nan),
        np.full((count, robot.nv), np.nan),
        np.full(robot.nq, np.nan),
        np.full(robot.nv, np.nan),
        impact_columns(scene, ()),
        (),
        0,
    )


def _kept(motion: Trajectory, times: np.ndarray, impacts: bool) -> RowResult:
    robot = motion.scene.robot
    q = np.full((len(times), robot.nq), np.nan)
    v = np.full((len(times), robot.nv), np.nan)
    # A motion that was stopped lists the state at its end besides.
    count = int(np.searchsorted(times, motion.t[-1], side="right"))
    q[:count], v[:count] = motion.q[:count], motion.v[:count]
    q_end, v_end = motion.at(motion.duration)
    return RowResult(
        motion.status,
        motion.detail,
        motion.duration,
        q,
        v,
        q_end,
        v_end,
        impact_columns(motion.scene, motion.impacts if impacts else ()),
        tuple((rest.contact, rest.start, rest.end) for rest in motion.rests),
        motion.evaluations,
    )


def impact_columns(scene: Scene, impacts: tuple[tuple[float, Any], ...]) -> dict[str, np.ndarray]:
    """The columns of ``ImpactTable`` for the impacts of one motion."""
    count, contacts, nv = len(impacts), len(scene.contacts), scene.robot.nv
    columns = {
        "time": np.array([time for time, _ in impacts], dtype=float),
        "status": np.zeros(count, dtype=np.int8),
        "touching": np.zeros((count, contacts), dtype=bool),
        "impulse": np.zeros((count, contacts, 3)),
        "v_before": np.empty((count, nv)),
        "v_after": np.empty((count, nv)),
    }
    for i, (_, impact) in enumerate(impacts):
        columns["status"][i] = impact.status
        columns["v_before"][i], columns["v_after"][i] = impact.v_before, impact.v_after
        for k, impulse in contact_impulses(impact).items():
            columns["touching"][i, k] = True
            columns["impulse"][i, k, : len(impulse)] = impulse
    return columns
