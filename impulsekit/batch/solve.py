"""``solve_batch``: the same call as ``solve`` with a leading axis."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, UnknownNameError, a_thing, check_kind, warn_of_setup
from ..errors.calls import public
from ..impact.doubts import doubts_of_state
from ..impact.status import Status
from ..robot.arrays import lock
from ..scene import JointStop, Scene
from ..scene.numbers import whole
from .inputs import BatchInputs, batch_inputs
from .program import Program, is_new, program_of
from .progress import shown
from .remote import computed, is_lazy, solve_lazily
from .result import OUTPUTS, ImpactBatch, shape_of
from .rows import bounds_of, verdicts_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .inputs import Varied

__all__ = ["run", "solve_batch"]

Progress = Callable[[int, int], object]


@public
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
    progress: bool | Progress | None = None,
    threads: int | None = None,
    client: Any = None,
) -> ImpactBatch:
    """Solve one scene at many states, impulses or coefficients, on all cores.

    Arguments that vary have a leading axis of length B; the others apply to all rows. The
    results equal those of ``solve``: rows and laws are the same code. What has to be found in
    Python (functions of the configuration, points of bodies other than balls) is found row by
    row; ``plan`` of the result says which.

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
            "contact_impulses", "constraint_impulses", "normal_components", "gaps" (of the contacts
            that touch), "reactions" (what each moving joint carries), "bodies" (how each link
            moves), "uniqueness" (whether other v⁺ obey the law as well), "outcome_bounds" (v⁺ in
            any order and shares of the contacts); these two search row by row. The status is
            always computed.
        progress: True for a progress bar on stderr, or a function of (rows done, rows in total).
        threads: number of threads; by default all that the process may use.
        client: a ``distributed.Client`` whose workers solve the rows. Without it, if any
            argument is a dask array, all arrays of the result are dask arrays, computed when
            they are evaluated.

    Warns:
        SetupWarning: the first time that a scene is solved, if ``ImpactBatch.doubts`` is not empty,
            nothing can be hit, or a q that all rows share is likely not meant.

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
    given = {"q": q, "v": v, "impulses": impulses}
    given.update(restitution=restitution, friction=friction, masses=masses, points=points)
    if client is not None or is_lazy(*given.values()):
        return _on_dask(scene, given, tuple(dict.fromkeys(outputs)), threads, client)
    inputs = batch_inputs(scene, **given)
    first = is_new(scene)
    with shown(progress, inputs.size) as tell:
        solved = run(scene, inputs, outputs, threads, tell=tell if progress else None)
    if first:
        shared = inputs.q[0] if len(inputs.q) == 1 else scene.robot.neutral()
        warn_of_setup([*doubts_of_state(scene, shared), *solved.doubts])
    return solved


def run(
    scene: Scene,
    inputs: BatchInputs,
    outputs: Sequence[str],
    threads: int | None,
    given: Mapping[str, Any] = MappingProxyType({}),
    found: Mapping[str, np.ndarray] = MappingProxyType({}),
    tell: Any = None,
) -> ImpactBatch:
    """Solve the rows of a batch.

    Args:
        given, found: more that the core takes, and that it fills.
        tell: called with the number of rows done.
    """
    program = program_of(scene, links=inputs.links, pointed=inputs.pointed)
    looked_at = ("gaps",) if scene.contacts and scene.gap_bound < np.inf else ()
    shapes = {name: (inputs.size, *shape_of(scene, name)) for name in (*outputs, *looked_at)}
    arrays = {name: np.empty(shape) for name, shape in shapes.items()}
    codes = np.zeros(inputs.size, dtype=np.int8)
    asked = {**_given(program, inputs), "codes": inputs.codes, **given}
    program.core.solve(asked, {**arrays, "codes": codes, **found}, _threads(threads), tell)
    failed = (codes >= int(Status.NOT_FINITE)) & (codes != int(Status.NEARLY_DEPENDENT))
    if failed.any():
        for array in arrays.values():
            array[failed] = np.nan
    if "uniqueness" in arrays:
        arrays["uniqueness"] = verdicts_of(scene, inputs, codes)
    if "outcome_bounds" in arrays:
        arrays["outcome_bounds"] = bounds_of(scene, inputs, codes)
    doubts = tuple(_open_contacts(scene, arrays["gaps"])) if looked_at else ()
    lock(*arrays.values(), codes)
    chosen = {name: arrays[name] for name in outputs}
    return ImpactBatch(codes, program.plan, chosen, doubts, scene)


def _open_contacts(scene: Scene, gaps: np.ndarray) -> Iterator[str]:
    """A sentence for each contact that is open or overlaps by more than the bound in some rows."""
    for name, entry, own in zip(scene.entry_names("contacts"), scene.contacts, gaps.T, strict=True):
        unit = "m or rad" if isinstance(entry, JointStop) else "m"
        for what, sizes in (("is open", own), ("overlaps", -own)):
            if count := int((sizes > scene.gap_bound).sum()):
                most = float(np.nanmax(sizes))
                yield f"{name} {what} in {count} of {len(own)} rows, by up to {most:.3g} {unit}"


def _on_dask(
    scene: Scene,
    given: dict[str, Any],
    outputs: tuple[str, ...],
    threads: int | None,
    client: Any,
) -> ImpactBatch:
    # A client's workers use one thread each.
    lazy = solve_lazily(solve_batch, scene, given, outputs, threads if client is None else 1)
    arrays = lazy if client is None else computed(lazy, client)
    return ImpactBatch(arrays.pop("status"), program_of(scene).plan, arrays, scene=scene)


def _given(program: Program, inputs: BatchInputs) -> dict[str, Any]:
    """The arrays of a batch as the core takes them."""
    names = ("q", "v", "restitution", "friction", "masses")
    given: dict[str, Any] = {name: getattr(inputs, name) for name in names}
    order = program.flat.order
    given["impulses"] = inputs.impulses[:, order] if order else None
    given["points"] = None
    if inputs.points is not None:
        parts = np.split(inputs.points, len(program.frames), axis=1)
        placed = [
            part @ frame.rotation.T + frame.translation
            for part, frame in zip(parts, program.frames, strict=True)
        ]
        given["points"] = np.concatenate(placed, axis=1)
    given.update(_by_functions(program, inputs))
    return {
        name: array if array is None else np.ascontiguousarray(array)
        for name, array in given.items()
    }


def _by_functions(program: Program, inputs: BatchInputs) -> dict[str, Any]:
    """The values of functions of the scene, row by row."""
    flat = program.flat
    names = ("function_rows", "function_contacts")
    given: dict[str, Any] = dict.fromkeys(names)
    if not (flat.functions or flat.contact_functions):
        return given
    fine = inputs.codes == 0
    rows = [
        flat.given(q) if fine[i if len(inputs.q) > 1 else 0] and np.isfinite(q).all() else {}
        for i, q in enumerate(inputs.q)
    ]
    for name in names:
        size = max((len(row[name]) for row in rows if name in row), default=0)
        if size:
            given[name] = np.array([row.get(name, np.zeros(size)) for row in rows])
    return given


def _threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    return whole(threads, "threads", 1)
