"""``solve_batch``: the same call as ``solve`` with a leading axis."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, UnknownNameError, a_thing, check_kind, quoted
from ..laws.compiled import ENTRIES
from ..laws.status import Status
from ..robot.arrays import lock
from ..scene import Scene
from ..scene.numbers import whole
from .codes import AGAIN, OPEN, SHARED
from .errors import NoKernelError
from .inputs import BatchInputs, batch_inputs
from .meanwhile import solved_meanwhile
from .plans import plan_batch
from .remote import is_lazy, solve_lazily, solve_remotely
from .result import NO_ANSWER, OUTPUTS, VERDICTS, ImpactBatch
from .shapes import shape_of
from .single import solve_rows

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, DTypeLike

    from .inputs import Varied
    from .joint_loads import JointLoads
    from .program import BatchPlan, Program

__all__ = ["solve_batch", "warm_up"]

# Blows of other sizes are brought near 1 by the solver of single states.
SMALLEST_BLOW, LARGEST_BLOW = 1e-150, 1e150

# Outputs that follow from Δv and the impulses.
_FROM_LOADS = frozenset({"reactions", "bodies"})

Progress = Callable[[int, int], object]


def solve_batch(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike | None = None,
    *,
    impulses: Varied | None = None,
    restitution: Varied | None = None,
    friction: Varied | None = None,
    masses: Varied | None = None,
    points: Mapping[str, ArrayLike] | None = None,
    outputs: Sequence[str] = ("v_after",),
    dtype: DTypeLike = np.float64,
    progress: bool | Progress | None = None,
    threads: int | None = None,
    client: Any = None,
) -> ImpactBatch:
    """Solve one scene at many states, impulses or coefficients: compiled kernels, on all cores.

    Arguments that vary have a leading axis of length B; the others apply to all rows. The
    results equal those of ``solve``. Rows that the kernels do not support are solved by it, one
    by one; ``plan`` of the result reports this. Where kernels are yet to be compiled, batches that
    are sooner done by ``solve`` than compiled are; ``single`` of the result tells, and digits of
    rounding may differ from those of later calls: ``warm_up`` compiles beforehand. With several
    frictional contacts the law itself can have more than one solution; ``solve`` and
    ``solve_batch`` may then return different ones, each within the tolerance of the law.

    Args:
        scene: the robot, its impulses, constraints and contacts, and the law of contact.
        q: (B, nq) or (nq,) configurations.
        v: (B, nv) or (nv,) velocities before the impact; at rest by default.
        impulses: numbers in place of those of the scene's known impulses: a mapping from
            entry names to (B, 6) or (6,), force before couple impulse, or (B, 3) the force
            impulse alone; of a ``JointImpulse`` (B, its own number). An array alone where
            the scene has one known impulse.
        restitution, friction: in place of those of the contacts: a number, (contacts,),
            (B, contacts), or a mapping from entry names to numbers or (B,).
        masses: factors on the mass of links, and on their inertia with it, above 0: a
            mapping from names of links to numbers or (B,).
        points: in place of ``at`` of contacts: a mapping from entry names to (B, 3) or (3,), in
            the coordinates of the contact's frame [m].
        outputs: the results to compute: "v_after", "dv", "generalized_impulse", "energy_change",
            "contact_impulses", "constraint_impulses", "normal_components", "reactions" (what each
            moving joint carries), "bodies" (how each link moves). The status is always computed.
        dtype: numpy.float64, or numpy.float32 for results in single precision, two to three
            times as fast for many rows. Their error is about 1e-5 of the largest speed, or 1e-7
            of it times the condition number where light bodies follow heavy ones. Arguments are
            read in double precision; the laws of contact, and rows with redundant contacts or
            constraints, are computed in it.
        progress: True for a progress bar on stderr, or a function of (rows done, rows in total).
        threads: number of threads; by default all that the process may use.
        client: a ``distributed.Client`` whose workers solve the rows. Without it, if any
            argument is a dask array, all arrays of the result are dask arrays, computed when
            they are evaluated.

    Raises:
        ShapeError, NotFiniteError, StateError, RangeError, UnknownNameError, InputError:
            an argument shared by all rows is not valid. Invalid rows are flagged in
            ``status``; the others continue.

    Example:
        >>> import numpy as np
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> blows = np.random.default_rng(0).normal(size=(1000, 3))
        >>> solve_batch(scene, robot.neutral(), impulses=blows).v_after.shape
        (1000, 9)
    """
    check_kind(scene, Scene, "solve_batch")
    outputs = (outputs,) if isinstance(outputs, str) else outputs
    if not isinstance(outputs, Iterable):
        raise InputError(f"outputs must be a list of names, got {a_thing(outputs)}")
    for name in outputs:
        if name not in OUTPUTS:
            raise UnknownNameError.among("output", str(name), OUTPUTS)
    number = _number(dtype)
    given = {"q": q, "v": v, "impulses": impulses}
    given.update(restitution=restitution, friction=friction, masses=masses, points=points)
    if client is not None or is_lazy(*given.values()):
        names = tuple(dict.fromkeys(outputs))
        return _on_dask(scene, given, names, number, threads, client)
    by_solve = ""
    if _FROM_LOADS.intersection(outputs):
        loads, by_solve = _joint_loads(scene, varied=masses is not None or points is not None)
        if loads is not None:
            return _with_joint_loads(loads, scene, given, outputs, number, progress, threads)
    inputs = batch_inputs(scene, **given)
    if by_solve:
        from .program import BatchPlan

        program, plan = None, BatchPlan(False, 0, (f"state by state: {by_solve}",))
    else:
        program, plan = plan_batch(
            scene, frictional=_frictional(inputs), links=inputs.links, pointed=inputs.pointed
        )
    shapes = {name: (inputs.size, *shape_of(scene, name)) for name in outputs}
    arrays = {name: np.empty(shape, number) for name, shape in shapes.items()}
    codes, verdicts = (np.zeros(inputs.size, dtype=np.int8) for _ in range(2))
    from .progress import shown

    with shown(progress, inputs.size) as tell:
        if program is None:
            single = np.full(inputs.size, True)
            for begin in range(0, inputs.size, 256):
                end = min(begin + 256, inputs.size)
                solve_rows(scene, inputs, range(begin, end), arrays, codes, verdicts)
                tell(end)
        else:
            again = _by_kernels(
                scene, program, inputs, (arrays, codes, verdicts), number, _threads(threads), tell
            )
            single = np.full(inputs.size, False)
            single[again] = True
    return _judged(plan, arrays, codes, single, verdicts)


def _by_kernels(
    scene: Scene,
    program: Program,
    inputs: BatchInputs,
    answers: tuple[dict[str, np.ndarray], np.ndarray, np.ndarray],
    number: np.dtype,
    threads: int,
    tell: Callable[[int], object],
) -> np.ndarray:
    """Solve all rows by the kernels; gives the indices of those that ``solve`` did."""
    from .run import BatchRun, run_all, run_in_double

    arrays, codes, verdicts = answers
    run = BatchRun(program, inputs, arrays, codes, number)
    if not run.is_compiled:
        if solved_meanwhile(scene, inputs, run.kind, answers, tell):
            return np.arange(inputs.size)
        verdicts[:] = 0
    run_all(run, threads, tell)
    _along_push(arrays.get("normal_components"))
    codes[np.broadcast_to(_beyond_products(inputs), codes.shape)] = AGAIN
    again = np.flatnonzero(codes == AGAIN)
    if len(again) and number == np.float32:
        again = run_in_double(program, inputs, again, arrays, codes, threads)
    verdicts[codes >= SHARED] = VERDICTS.index("several")
    codes[codes >= SHARED] -= SHARED
    verdicts[codes >= OPEN] = VERDICTS.index("not proven")
    codes[codes >= OPEN] -= OPEN
    solve_rows(scene, inputs, again.tolist(), *answers)
    return again


def _judged(
    plan: BatchPlan,
    arrays: dict[str, np.ndarray],
    codes: np.ndarray,
    single: np.ndarray,
    verdicts: np.ndarray,
) -> ImpactBatch:
    """The result, NaN in rows without one."""
    several = codes == int(Status.MANY_SOLUTIONS)
    told = [int(s) for s in (Status.NOT_UNIQUE, Status.PAINLEVE_JAM, Status.MANY_SOLUTIONS)]
    codes[np.isin(codes, told)] = int(Status.SOLVED)
    verdicts[several] = VERDICTS.index("several")
    failed = (codes >= int(Status.NOT_FINITE)) & (codes != int(Status.NEARLY_DEPENDENT))
    verdicts[failed | np.isin(codes, NO_ANSWER)] = VERDICTS.index("not proven")
    for array in arrays.values():
        if failed.any():
            array[failed] = np.nan
    lock(*arrays.values(), codes, single, verdicts)
    return ImpactBatch(codes, plan, arrays, single, verdicts)


def _along_push(normals: np.ndarray | None) -> None:
    """Give normal components of kernels the direction of the push; zero without an impulse."""
    if normals is not None:
        # The row of a joint stop is its coordinate's, at the lower and at the upper limit.
        normals *= np.sign(normals[..., 2:])


def _joint_loads(scene: Scene, *, varied: bool) -> tuple[JointLoads | None, str]:
    """The tables for loads of a scene; or None, and why only ``solve`` knows them."""
    from .joint_loads import JointLoads

    if varied:
        return None, "loads of masses that vary, or of points"
    try:
        return JointLoads(scene), ""
    except NoKernelError as reason:
        return None, str(reason)


def _with_joint_loads(
    loads: JointLoads,
    scene: Scene,
    given: dict[str, Any],
    outputs: Sequence[str],
    number: np.dtype,
    progress: bool | Progress | None,
    threads: int | None,
) -> ImpactBatch:
    """The batch with reactions and link velocities worked out of Δv and all impulses."""
    needed = ("dv", "contact_impulses", "constraint_impulses")
    plain = [name for name in outputs if name not in _FROM_LOADS]
    batch = solve_batch(
        scene, **given, outputs=(*plain, *needed), dtype=number, progress=progress,
        threads=threads,
    )  # fmt: skip
    own: dict[str, np.ndarray | None] = {
        name: np.empty((len(batch), *shape_of(scene, name)), number) if name in outputs else None
        for name in ("reactions", "bodies")
    }
    inputs = batch_inputs(scene, *given.values())
    loads.write(
        inputs.q, batch.dv, inputs.given, batch.contact_impulses, batch.constraint_impulses,
        own["reactions"], own["bodies"],
    )  # fmt: skip
    arrays = {name: batch.arrays[name] for name in plain}
    for name, array in own.items():
        if array is not None:
            array.setflags(write=False)
            arrays[name] = array
    return replace(batch, arrays=arrays)


def _on_dask(
    scene: Scene,
    given: dict[str, Any],
    outputs: tuple[str, ...],
    number: np.dtype,
    threads: int | None,
    client: Any,
) -> ImpactBatch:
    if given["v"] is None:
        del given["v"]
    if client is None:
        arrays = solve_lazily(solve_batch, scene, given, outputs, number, threads)
    else:
        arrays = solve_remotely((solve_batch, warm_up), scene, given, outputs, number, client)
    links = tuple(given["masses"] or ())
    names = scene.entry_names("contacts")
    pointed = tuple(sorted(names.index(name) for name in given["points"] or () if name in names))
    plan = plan_batch(
        scene, frictional=given["friction"] is not None, links=links, pointed=pointed
    )[1]
    return ImpactBatch(arrays.pop("status"), plan, arrays)


def warm_up(scene: Scene, *, dtype: DTypeLike = np.float64) -> BatchPlan:
    """Compile the code that a scene needs for single states, motions and batches.

    The first call after installation compiles for ten seconds or more; later calls load the
    compiled code from disk within half a second. ``solve_batch`` does this itself when needed;
    ``solve`` and ``simulate`` run as Python until compilation pays off. Python and compiled code
    may differ in the last digit: after ``warm_up``, motions are bit for bit the same each time.

    Args:
        scene: the scene.
        dtype: as for ``solve_batch``.

    Returns:
        The plan: how batches of this scene are solved.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> warm_up(Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])).kernel
        True
    """
    check_kind(scene, Scene, "warm_up")
    from ..motion.warm import compile_motion

    compile_motion(scene)
    program, plan = plan_batch(scene)
    if program is not None:
        inputs = batch_inputs(scene, scene.robot.neutral(), None, None, None, None, None)
        # A row that is known to be bad passes through all kernels but the laws of contact.
        inputs.codes[:] = int(Status.OUT_OF_RANGE)
        from .run import BatchRun, run_all

        codes = np.zeros(1, dtype=np.int8)
        run_all(BatchRun(program, inputs, {}, codes, _number(dtype)), 1, lambda _: None)
        # What kernels compile when a row first needs it.
        for name, entry in ENTRIES.items():
            if name.startswith(f"{__package__}.kernels."):
                entry.compile()
    return plan


def _number(dtype: Any) -> np.dtype:
    try:
        number = np.dtype(dtype)
    except TypeError:
        number = np.dtype(object)
    if number not in (np.float64, np.float32):
        raise InputError(f"dtype must be numpy.float64 or numpy.float32, got {quoted(dtype)}")
    return number


def _beyond_products(inputs: BatchInputs) -> np.ndarray:
    """(B,) or (1,) whether a row's blows are so small or large that products leave the doubles."""
    if not inputs.given.size:
        return np.zeros(1, dtype=bool)
    largest = np.abs(inputs.given).max(axis=1)
    return (largest > 0.0) & ((largest < SMALLEST_BLOW) | (largest > LARGEST_BLOW))


def _frictional(inputs: BatchInputs) -> bool:
    return inputs.friction is not None and bool(inputs.friction.any())


def _threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    return whole(threads, "threads", 1)
