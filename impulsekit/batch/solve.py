"""``solve_batch``: the same call as ``solve`` with a leading axis."""

from __future__ import annotations

import functools
import os
import weakref
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, MissingExtraError, RangeError, UnknownNameError
from ..scene import FrameAnchor, JointLock, PointAnchor, Scene
from .codes import AGAIN, RowStatus
from .inputs import BatchInputs, batch_inputs
from .remote import is_lazy, solve_lazily, solve_remotely
from .result import OUTPUTS, ImpactBatch
from .single import solve_rows

if TYPE_CHECKING:
    from .program import BatchPlan, Program

__all__ = ["plan_batch", "solve_batch"]

Progress = Callable[[int, int], object]


def solve_batch(
    scene: Scene,
    q: Any,
    v: Any = None,
    *,
    impulses: Any = None,
    restitution: Any = None,
    friction: Any = None,
    outputs: Sequence[str] = ("v_after",),
    progress: bool | Progress | None = None,
    threads: int | None = None,
    client: Any = None,
) -> ImpactBatch:
    """One scene at many states, blows or coefficients: compiled kernels, on all cores.

    Whatever varies has a leading axis of B; what has none holds for all rows. The answers
    are those of ``solve``. What the kernels do not know is left to it, row by row; ``plan``
    of the answer says so. Where several contacts rub, the law itself can have more than one
    answer; ``solve`` and ``solve_batch`` may then give different ones, each within the bar
    of the law.

    Args:
        scene: what strikes, holds and touches the robot.
        q: (B, nq) or (nq,) configurations.
        v: (B, nv) or (nv,) velocities before the impact; at rest by default.
        impulses: numbers in place of those of the scene's known impulses: a mapping from
            entry names to (B, 6) or (6,), force before couple impulse, or (B, 3) the force
            impulse alone; of a ``JointImpulse`` (B, its own number). An array alone where
            the scene has one known impulse.
        restitution, friction: in place of those of the contacts: a number, (contacts,),
            (B, contacts), or a mapping from entry names to numbers or (B,).
        outputs: what to compute: "v_after", "dv", "generalized_impulse", "energy_change",
            "contact_impulses", "constraint_impulses". The status is always there.
        progress: True for a bar on stderr, or a function of rows done and rows in all.
        threads: how many; by default as many as the process may use.
        client: a ``distributed.Client`` whose workers are to solve. Without it, where any of
            the arrays is a dask array, all arrays of the answer are dask arrays too, and
            nothing is computed before they are.

    Raises:
        ShapeError, NotFiniteError, StateError, RangeError, UnknownNameError, InputError:
            what is wrong with arguments that all rows share. A row that is wrong is
            marked in ``status`` and stops nothing.
        MissingExtraError: numba is not installed.

    Example:
        >>> import numpy as np
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> blows = np.random.default_rng(0).normal(size=(1000, 3))
        >>> solve_batch(scene, robot.neutral(), impulses=blows).v_after.shape
        (1000, 9)
    """
    if not isinstance(scene, Scene):
        raise InputError(f"a Scene is wanted, not a {type(scene).__name__}")
    for name in outputs:
        if name not in OUTPUTS:
            raise UnknownNameError.among("output", str(name), OUTPUTS)
    given = {"q": q, "v": v, "impulses": impulses}
    given.update(restitution=restitution, friction=friction)
    if client is not None or is_lazy(*given.values()):
        return _on_dask(scene, given, tuple(dict.fromkeys(outputs)), threads, client)
    inputs = batch_inputs(scene, q, v, impulses, restitution, friction)
    program, plan = plan_batch(scene, frictional=_frictional(scene, inputs))
    shapes = {name: (inputs.size, *_shape(scene, name)) for name in outputs}
    arrays = {name: np.empty(shape) for name, shape in shapes.items()}
    codes = np.zeros(inputs.size, dtype=np.int8)
    from .progress import shown

    with shown(progress, inputs.size) as tell:
        if program is None:
            for begin in range(0, inputs.size, 256):
                end = min(begin + 256, inputs.size)
                solve_rows(scene, inputs, range(begin, end), arrays, codes)
                tell(end)
        else:
            _run(program, inputs, arrays, codes, _threads(threads), tell)
            again = np.flatnonzero(codes == AGAIN)
            solve_rows(scene, inputs, again.tolist(), arrays, codes)
    failed = codes >= int(RowStatus.NOT_FINITE)
    for array in arrays.values():
        if failed.any():
            array[failed] = np.nan
        array.setflags(write=False)
    codes.setflags(write=False)
    return ImpactBatch(codes, plan, arrays)


def _on_dask(
    scene: Scene, given: dict[str, Any], outputs: tuple[str, ...], threads: int | None, client: Any
) -> ImpactBatch:
    if given["v"] is None:
        del given["v"]
    if client is None:
        arrays = solve_lazily(scene, given, outputs, threads)
    else:
        arrays = solve_remotely(scene, given, outputs, client)
    plan = plan_batch(scene, frictional=given["friction"] is not None)[1]
    return ImpactBatch(arrays.pop("status"), plan, arrays)


_programs: dict[tuple[int, bool], tuple[Any, Any]] = {}


def plan_batch(scene: Scene, *, frictional: bool = False) -> tuple[Program | None, BatchPlan]:
    """The program of a scene for the kernels (None: there is none) and the plan; kept with it.

    Args:
        frictional: give contacts tangent rows even where their own friction is 0.

    Raises:
        MissingExtraError: numba is not installed.
    """
    key = (id(scene), frictional)
    if key not in _programs:
        try:
            import numba  # noqa: F401
        except ImportError:
            raise MissingExtraError.of("numba", "batch", "solve_batch") from None
        from .program import compiled

        _programs[key] = compiled(scene, frictional=frictional)
        weakref.finalize(scene, _programs.pop, key, None)
    return _programs[key]


def _frictional(scene: Scene, inputs: BatchInputs) -> bool:
    return inputs.friction is not None and bool(inputs.friction.any())


def _shape(scene: Scene, name: str) -> tuple[int, ...]:
    if name == "energy_change":
        return ()
    if name == "contact_impulses":
        return (len(scene.contacts), 3)
    if name == "constraint_impulses":
        return (sum(_row_count(scene, entry) for entry in scene.constraints),)
    return (scene.robot.nv,)


def _row_count(scene: Scene, entry: Any) -> int:
    """How many rows a constraint has."""
    if isinstance(entry, FrameAnchor):
        return len(entry.directions)
    if isinstance(entry, JointLock):
        return scene.robot.model.joints[scene.robot.joint_id(entry.joint)].nv
    return 3 if isinstance(entry, PointAnchor) else 1


def _threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    if threads < 1:
        raise RangeError.of("threads", threads, "1 or more")
    return int(threads)


def _run(
    program: Program,
    inputs: BatchInputs,
    arrays: dict[str, np.ndarray],
    codes: np.ndarray,
    threads: int,
    tell: Callable[[int], object],
) -> None:
    """All rows by the kernels, pieces of the batch on several threads."""
    from .run import BatchRun

    run = BatchRun(program, inputs, arrays, codes)
    pieces = run.pieces(threads)
    if threads == 1 or len(pieces) == 1:
        for begin, end in pieces:
            run.solve(begin, end)
            tell(run.rows_done)
        return
    from concurrent.futures import as_completed

    pool = _pool(threads, os.getpid())
    for done in as_completed([pool.submit(run.solve, *piece) for piece in pieces]):
        done.result()
        tell(run.rows_done)


@functools.cache
def _pool(threads: int, process: int) -> Any:
    """Threads that stay, for to start them costs as much as some thousand states; a process
    that was forked off has to have its own."""
    from concurrent.futures import ThreadPoolExecutor

    return ThreadPoolExecutor(threads, thread_name_prefix="impulsekit batch")
