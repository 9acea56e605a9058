"""``derivatives_batch`` and ``vjp``: how many impacts change with what they start from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import Existence
from ..errors import UnknownNameError, check_kind
from ..errors.calls import public
from ..formatting import Displayed, one_line
from ..impact.derivatives.refusals import refuse_what_has_none
from ..impact.derivatives.result import layout_of
from ..impact.derivatives.status import DerivativeStatus
from ..robot.arrays import array_of, floats, lock
from ..scene import AppliedImpulse, Scene
from .inputs import BatchInputs, batch_inputs
from .program import program_of
from .result import ImpactBatch
from .solve import run

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .inputs import Varied

__all__ = ["BatchDerivatives", "derivatives_batch", "vjp"]

RESULTS = ("v_after", "contact_impulses")
PARAMETERS = (
    "q", "v", "impulses", "restitution", "friction", "mass", "at", "normal", "strike"
)  # fmt: skip
VARIED = ("impulses", "restitution", "friction", "masses", "points")
_STATUS = tuple(DerivativeStatus[each.name.upper()] for each in Existence)


@dataclass(frozen=True, eq=False, repr=False)
class BatchDerivatives(Displayed):
    """Derivatives of B impacts; arrays are read-only.

    Of ``derivatives_batch`` ``found["v_after", "q"]`` is (B, nv, nv); of ``vjp`` ``found["q"]`` is
    (B, nv). Along the last axis:

    - "q", "v": (nv,) the configuration, on its tangent, and the velocity before.
    - "impulses": the numbers of the known impulses, entry after entry.
    - "restitution", "friction": (contacts,).
    - "mass": (links,) the factors on the masses of ``links``.
    - "at", "normal": (contacts, 3) of contacts on planes, in the coordinates of their frame and of
      ``against``; "strike": (blows, 3) ``at`` of the ``AppliedImpulse`` entries.

    What does not touch has zeros. Rows of which ``exists`` is False hold the derivatives of the
    modes that were found where a mode is on its edge (those on one side), and NaN where there are
    none.

    Attributes:
        impacts: the impacts themselves, with ``v_after``.
        codes: (B,) by row the index in ``DerivativeStatus``.
        links: those that "mass" goes through.
        arrays: by key.
    """

    impacts: ImpactBatch
    codes: np.ndarray
    links: tuple[str, ...]
    arrays: Mapping[Any, np.ndarray] = field(repr=False)

    def __getitem__(self, key: str | tuple[str, str]) -> np.ndarray:
        """Return the derivatives of a result by a parameter, or of ``vjp`` by a parameter."""
        if key not in self.arrays:
            raise UnknownNameError.among("derivative", str(key), [str(k) for k in self.arrays])
        return self.arrays[key]

    @property
    def exists(self) -> np.ndarray:
        """(B,) whether each row's numbers are derivatives."""
        return self.codes <= _STATUS.index(DerivativeStatus.BY_DIFFERENCES)

    def count(self) -> dict[DerivativeStatus, int]:
        """Rows by status, the most frequent first."""
        return {_STATUS[code]: n for code, n in Counter(self.codes.tolist()).most_common()}

    def __repr__(self) -> str:
        counts = [f"{n} {status.name}" for status, n in self.count().items()]
        return one_line("BatchDerivatives", *counts, f"of {', '.join(map(str, self.arrays))}")


@public
def derivatives_batch(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike | None = None,
    *,
    of: Sequence[str] = ("v_after",),
    by: Sequence[str] = ("q", "v"),
    threads: int | None = None,
    **varied: Varied,
) -> BatchDerivatives:
    """Return the derivatives of many impacts, those of ``derivatives`` row by row.

    Args:
        scene, q, v, threads, varied: as ``solve_batch`` takes them; varied are impulses,
            restitution, friction, masses and points.
        of: "v_after" (nv), "contact_impulses" (contacts, 3) in world axes.
        by: "q", "v", "impulses", "restitution", "friction", "mass", "at", "normal", "strike": see
            ``BatchDerivatives``.

    Raises:
        UnknownNameError: no such result or parameter.
        InputError: scenes that ``derivatives`` refuses; as for ``solve_batch``.

    Example:
        >>> import numpy as np
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5)])
        >>> falls = -np.eye(6)[[2, 2]] * [[1.0], [2.0]]
        >>> found = derivatives_batch(scene, ball.neutral(), falls, by=("v", "restitution"))
        >>> found["v_after", "v"][:, 2, 2].tolist()
        [-0.5, -0.5]
        >>> found["v_after", "restitution"][:, 2, 0].tolist()
        [1.0, 2.0]
    """
    of, by = (of,) if isinstance(of, str) else tuple(of), (by,) if isinstance(by, str) else by
    for name in of:
        if name not in RESULTS:
            raise UnknownNameError.among("result", str(name), RESULTS)
    inputs = _inputs(scene, q, v, by, varied)
    layout = layout_of(scene, program_of(scene).flat)
    rows = {"v_after": layout.rows["v_after"], "contact_impulses": layout.contacts}
    every = np.arange(layout.count)
    results = np.concatenate([every[:0], *(every[rows[name]] for name in of)])
    table, impacts, codes, parts = _differentiated(
        scene, inputs, by, threads, {"results": results.tolist(), "weights": None}, len(results)
    )
    arrays, start = {}, 0
    for name in of:
        size = rows[name].stop - rows[name].start
        own = table[:, start : start + size]
        if name == "contact_impulses":
            own = own.reshape(len(own), -1, 3, own.shape[2])
        for kind, (columns, shape) in parts.items():
            arrays[name, kind] = own[..., columns].reshape(*own.shape[:-1], *shape)
        start += size
    lock(*arrays.values())
    return BatchDerivatives(impacts, codes, inputs.links, arrays)


@public
def vjp(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike | None,
    cotangent: ArrayLike | Mapping[str, ArrayLike],
    *,
    by: Sequence[str] = ("q", "v"),
    threads: int | None = None,
    **varied: Varied,
) -> BatchDerivatives:
    """Return the gradients of Σ cotangent · result of many impacts, row by row.

    One transposed linear solve for each row and stage; no Jacobian is formed.

    Args:
        scene, q, v, threads, varied: as ``solve_batch`` takes them; varied are impulses,
            restitution, friction, masses and points.
        cotangent: (B, nv) or (nv,) the weights of v⁺; or a mapping from "v_after" to these and
            from "contact_impulses" to (B, contacts, 3).
        by: as for ``derivatives_batch``.

    Raises:
        ShapeError, NotFiniteError: a cotangent of another shape, or with NaN in it.
        UnknownNameError: no such result or parameter.
        InputError: scenes that ``derivatives`` refuses; as for ``solve_batch``.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5)])
        >>> up, fall = [0, 0, 1, 0, 0, 0], [0, 0, -3, 0, 0, 0]
        >>> vjp(scene, ball.neutral(), fall, up, by="v")["v"].tolist()
        [[0.0, 0.0, -0.5, 0.0, 0.0, 0.0]]
    """
    by = (by,) if isinstance(by, str) else tuple(by)
    inputs = _inputs(scene, q, v, by, varied)
    layout = layout_of(scene, program_of(scene).flat)
    given = cotangent if isinstance(cotangent, Mapping) else {"v_after": cotangent}
    places = {"v_after": layout.rows["v_after"], "contact_impulses": layout.contacts}
    parts = {}
    for name, values in given.items():
        if name not in RESULTS:
            raise UnknownNameError.among("result", str(name), RESULTS)
        width = places[name].stop - places[name].start
        what = f"cotangent of {name}"
        array = floats(values, what, copied=False)
        shape = 1 if array.size == width else inputs.size, width
        fits = array.size == shape[0] * width
        parts[name] = array_of(array.reshape(shape) if fits else array, shape, what)
    size = max((len(part) for part in parts.values()), default=1)
    weights = np.zeros((size, layout.count))
    for name, part in parts.items():
        weights[:, places[name]] = part
    table, impacts, codes, kinds = _differentiated(
        scene, inputs, by, threads, {"results": [], "weights": weights}, 1
    )
    arrays = {
        kind: table[:, 0, columns].reshape(len(table), *shape)
        for kind, (columns, shape) in kinds.items()
    }
    lock(*arrays.values())
    return BatchDerivatives(impacts, codes, inputs.links, arrays)


def _inputs(scene: Scene, q: Any, v: Any, by: Sequence[str], varied: dict[str, Any]) -> BatchInputs:
    """Return the inputs of a batch, with factors on masses if derivatives by these are asked for.

    Raises:
        UnknownNameError: no such parameter, or argument. InputError: what has no derivatives.
    """
    check_kind(scene, Scene, "derivatives_batch")
    refuse_what_has_none(scene)
    for name in by:
        if name not in PARAMETERS:
            raise UnknownNameError.among("parameter", str(name), PARAMETERS)
    for name in varied:
        if name not in VARIED:
            raise UnknownNameError.among("argument", name, VARIED)
    if "mass" in by and varied.get("masses") is None:
        links = [link for link in scene.robot.links if link.mass > 0.0 and link.joint_id > 0]
        varied = {**varied, "masses": {link.name: 1.0 for link in links}}
    return batch_inputs(scene, q, v, **varied)


def _differentiated(
    scene: Scene,
    inputs: BatchInputs,
    by: Sequence[str],
    threads: int | None,
    given: dict[str, Any],
    count: int,
) -> tuple[np.ndarray, ImpactBatch, np.ndarray, dict[str, tuple[slice, tuple[int, ...]]]]:
    """(B, count, columns), the impacts, (B,) statuses, and by parameter its columns and shape."""
    flat = program_of(scene, links=inputs.links, pointed=inputs.pointed).flat
    layout, contacts = layout_of(scene, flat), len(scene.contacts)
    starts, nv = layout.starts, scene.robot.nv
    blows = sum(isinstance(entry, AppliedImpulse) for entry in scene.impulses)
    kinds: dict[str, tuple[Any, tuple[int, ...]]] = {
        "q": (np.arange(nv), (nv,)),
        "v": (starts.v + np.arange(nv), (nv,)),
        "impulses": (layout.order, (len(layout.order),)),
        "restitution": (starts.restitution + np.arange(contacts), (contacts,)),
        "friction": (starts.friction + np.arange(contacts), (contacts,)),
        "mass": (starts.masses + np.arange(len(inputs.links)), (len(inputs.links),)),
        "at": (starts.points + np.arange(3 * contacts), (contacts, 3)),
        "normal": (starts.normals + np.arange(3 * contacts), (contacts, 3)),
        "strike": (starts.blow_points + np.arange(3 * blows), (blows, 3)),
    }
    wanted = list(dict.fromkeys(by))
    parameters = np.concatenate([np.zeros(0, dtype=int), *(kinds[name][0] for name in wanted)])
    slopes = np.empty((inputs.size, count, len(parameters)))
    codes = np.zeros(inputs.size, dtype=np.int8)
    impacts = run(
        scene,
        inputs,
        ("v_after",),
        threads,
        {**given, "parameters": parameters.tolist()},
        {"slopes": slopes, "existence": codes},
    )
    parts, start = {}, 0
    for name in wanted:
        width = len(kinds[name][0])
        parts[name] = slice(start, start + width), kinds[name][1]
        start += width
    lock(codes)
    return slopes, impacts, codes, parts
