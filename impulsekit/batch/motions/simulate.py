"""``simulate_batch``: the same call as ``simulate`` with a leading axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError, check_kind
from ...errors.calls import public
from ...files import free_memory
from ...motion.record.status import MotionStatus
from ...motion.simulate import chosen_settings
from ...robot.arrays import lock
from ...scene import Scene
from ...scene.motion import MotionSettings
from ...scene.numbers import whole
from ..inputs import batch_inputs
from ..progress import shown
from .result import ImpactTable, MotionBatch, RestTable
from .row import RowResult, follow_rows, motion_of_row, row_without

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..inputs import Varied

__all__ = ["simulate_batch"]

# Of the states of the samples, what is free may be used up to this part.
OF_FREE_MEMORY = 0.5


@public
def simulate_batch(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike | None = None,
    duration: float | None = None,
    *,
    samples: ArrayLike | None = None,
    settings: MotionSettings | None = None,
    impulses: Varied | None = None,
    restitution: Varied | None = None,
    friction: Varied | None = None,
    masses: Varied | None = None,
    threads: int | None = None,
    progress: bool | Callable[[int, int], object] | None = None,
    **changes: Any,
) -> MotionBatch:
    """The motions of one scene from many states, or with many coefficients, on all cores.

    Whatever varies has a leading axis of B; what has none holds for all rows. Each row is the
    motion that ``simulate`` gives, bit for bit. Rows are followed by threads in the native core;
    functions of a scene (forces, gaps) are Python, of which one runs at a time.

    Args:
        scene: what strikes, holds, touches and moves the robot.
        q: (B, nq) or (nq,) configurations at the start.
        v: (B, nv) or (nv,) velocities before the impulses strike; at rest by default.
        duration, samples, settings, **changes: as for ``simulate``, the same for all rows.
        impulses, restitution, friction, masses: in place of the scene's, as for ``solve_batch``.
        threads: how many; by default as many as the process may use cores.
        progress: True for a bar on stderr, or a function of rows done and rows in all.

    Returns:
        The motions. A row that is wrong is ``REFUSED`` and stops nothing; ``detail`` says why.
        After Ctrl-C what was computed is there, the other rows are ``INTERRUPTED``.

    Raises:
        ShapeError, NotFiniteError, StateError, RangeError, UnknownNameError, InputError:
            what is wrong with arguments that all rows share.
        CallbackError: what a function of an entry gave.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", normal=[0, 0, 1])])
        >>> drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
        >>> batch = simulate_batch(scene, drop, restitution=[[0.2], [0.6], [1.5]], duration=1.0,
        ...                        samples=2)
        >>> {status.name: n for status, n in batch.count().items()}
        {'FINISHED': 2, 'REFUSED': 1}
    """
    check_kind(scene, Scene, "simulate_batch")
    if threads is not None:
        threads = whole(threads, "threads", 1)
    chosen, times = chosen_settings(settings, duration, samples, changes)
    varied = {"restitution": restitution, "friction": friction, "masses": masses}
    inputs = batch_inputs(scene, q, v, impulses, **varied)
    _check_memory(scene, inputs.size, len(times))
    rows: list[RowResult | None] = [None] * inputs.size
    with shown(progress, inputs.size) as tell:
        done = 0

        def take(index: int, row: RowResult) -> None:
            nonlocal done
            rows[index] = row
            done += 1
            tell(done)

        given = [(inputs, i, chosen, times) for i in range(inputs.size)]
        follow_rows(scene, given, threads, take)
    again = partial(motion_of_row, scene, inputs, settings=chosen, times=times)
    return _batch(scene, times, rows, again)


def _check_memory(scene: Scene, rows: int, samples: int) -> None:
    size = 8.0 * rows * samples * (scene.robot.nq + scene.robot.nv)
    if size > OF_FREE_MEMORY * free_memory():
        raise InputError(
            f"{rows} motions with {samples} samples each take {size / 1e9:.3g} GB of memory, "
            "which is not free; ask for fewer samples, or for fewer rows at a time"
        )


def _batch(
    scene: Scene,
    times: np.ndarray,
    found: Sequence[RowResult | None],
    again: Callable[[int], Any],
) -> MotionBatch:
    missing = row_without(scene, times, MotionStatus.INTERRUPTED)
    rows = [missing if row is None else row for row in found]
    counts = [len(row.impacts["time"]) for row in rows]
    columns = {
        name: np.concatenate([row.impacts[name] for row in rows]) for name in missing.impacts
    }
    rests = [(i, *rest) for i, row in enumerate(rows) for rest in row.rests]
    of_row, contact, start, end = zip(*rests, strict=True) if rests else ((), (), (), ())
    names = ("q", "v", "end", "q_end", "v_end", "evaluations")
    arrays = {name: np.array([getattr(row, name) for row in rows]) for name in names}
    arrays["status"] = np.array([row.status.code for row in rows], dtype=np.int8)
    impacts = ImpactTable(
        scene.entry_names("contacts"), np.repeat(np.arange(len(rows)), counts), **columns
    )
    table = RestTable(
        np.array(of_row, dtype=int),
        np.array(contact, dtype=str),
        np.array(start, dtype=float),
        np.array(end, dtype=float),
    )
    times = times.copy()
    lock(times, *arrays.values(), impacts.row, *columns.values(), *vars(table).values())
    return MotionBatch(
        t=times,
        detail=tuple(row.detail for row in rows),
        impacts=impacts,
        rests=table,
        again=again,
        **arrays,
    )
