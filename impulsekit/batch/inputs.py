"""``BatchInputs``: arrays with a leading axis on whatever varies, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, NotFiniteError, RangeError, ShapeError, UnknownNameError
from ..impact.status import Status
from ..robot import state
from ..robot.arrays import floats
from ..scene import Contact, Scene
from ..scene.impulses import impulse_numbers

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    # Numbers in place of the scene's: for all entries, or by the entries' names.
    Varied = ArrayLike | Mapping[str, ArrayLike]

__all__ = ["BatchInputs", "batch_inputs"]

# Points farther from their frame than this [m] are taken for a mistake.
FARTHEST = 1e6


@dataclass(frozen=True, eq=False)
class BatchInputs:
    """The numbers of a batch, each array (1, k) where all rows share it, else (B, k).

    Attributes:
        size: B.
        q, v: configurations and velocities.
        impulses: the numbers of the known impulses, entry after entry: force impulse and couple
            impulse (6) of an ``AppliedImpulse``, those of a ``JointImpulse``.
        restitution, friction: of each contact; None where the scene's own hold.
        masses: factors on the masses of ``links``; None where there are none.
        links: whose masses are scaled.
        points: (1 or B, 3k) in place of ``at`` of the contacts ``pointed``, by their indices; None
            where the scene's own hold.
        codes: (B,) what is known of a row before anything is solved.
        varies: whether rows are not all of the scene's own impulses, coefficients and bodies.
    """

    size: int
    codes: np.ndarray
    q: np.ndarray
    v: np.ndarray
    impulses: np.ndarray
    restitution: np.ndarray | None = None
    friction: np.ndarray | None = None
    masses: np.ndarray | None = None
    points: np.ndarray | None = None
    links: tuple[str, ...] = ()
    pointed: tuple[int, ...] = ()
    varies: bool = False

    def state(self, row: int) -> tuple[np.ndarray, np.ndarray]:
        """The configuration and the velocity of a row."""
        return of_row(self.q, row), of_row(self.v, row)


def of_row(array: np.ndarray, row: int) -> np.ndarray:
    """A row of an array, which all rows may share."""
    found: np.ndarray = array[row if len(array) > 1 else 0]
    return found


def batch_inputs(
    scene: Scene, q: Any, v: Any = None, impulses: Any = None, **varied: Any
) -> BatchInputs:
    """Check the arguments of ``solve_batch`` and bring them into one form.

    Args:
        varied: restitution, friction, masses and points; None where the scene's own hold.

    Raises:
        ShapeError: shapes that do not go together, or an empty batch.
        UnknownNameError: no impulse, contact or link of that name.
        NotFiniteError, StateError, RangeError: in what all rows share. What is wrong with
            a single row is noted in ``codes``.
    """
    robot = scene.robot
    arrays: dict[str, Any] = {
        "q": _matrix(q, robot.nq, "q"),
        "v": _matrix(np.zeros(robot.nv) if v is None else v, robot.nv, "v"),
        "impulses": impulse_numbers(scene.impulses, scene.entry_names("impulses"), impulses),
    }
    for name in ("restitution", "friction"):
        if varied.get(name) is not None:
            arrays[name] = _coefficients(scene, name, varied[name], len(scene.contacts))
    own = [x for entry in scene.impulses for x in entry.values]
    impulses = arrays["impulses"]
    named: dict[str, Any] = {
        "varies": any(one is not None for one in varied.values())
        or len(impulses) > 1
        or not np.array_equal(impulses[0], own)
    }
    if varied.get("masses") is not None:
        named["links"], arrays["masses"] = _factors(scene, varied["masses"])
    if varied.get("points") is not None:
        named["pointed"], arrays["points"] = _points(scene, varied["points"])
    size = 1
    for name, array in arrays.items():
        if array.shape[0] not in (1, size):
            if size != 1:
                raise ShapeError.of(
                    name, (size, *array.shape[1:]), array.shape, "all leading axes must agree"
                )
            size = array.shape[0]
    # (1, k) given as such and (k,) are the same: what all rows share is checked at once.
    if len(arrays["q"]) == 1:
        state.checked_configuration(robot.model, arrays["q"][0])
    if len(arrays["v"]) == 1:
        v = state.checked_velocity(robot.model, arrays["v"][0])
        if scene.held or scene.contacts:
            state.refuse_overflow(v)
    if len(arrays["impulses"]) == 1 and not np.isfinite(arrays["impulses"]).all():
        raise NotFiniteError.of("impulses", "an entry", "a NaN or an infinity")
    codes = np.zeros(size, dtype=np.int8)
    if scene.held or scene.contacts:
        arrays["v"] = _not_too_fast(arrays["v"], codes)
    _check_ranges(arrays, codes)
    return BatchInputs(size, codes, **arrays, **named)


def _check_ranges(arrays: dict[str, Any], codes: np.ndarray) -> None:
    """Refuse numbers out of range that all rows share; note rows that have some, made harmless."""
    for name, low, high, allowed, harmless in (
        ("restitution", 0.0, 1.0, "0 to 1", 0.0),
        ("friction", 0.0, np.inf, "0 or more", 0.0),
        ("masses", np.nextafter(0.0, 1.0), np.inf, "above 0", 1.0),
        ("points", -FARTHEST, FARTHEST, f"within {FARTHEST:g} m", 0.0),
    ):
        if name in arrays:
            array = arrays[name]
            fine = (array >= low) & (array <= high) & np.isfinite(array)
            if fine.all():
                continue
            if len(array) == 1:
                raise RangeError.of(name, float(array[~fine][0]), allowed)
            bad = ~fine.all(axis=1)
            codes[bad] = int(Status.OUT_OF_RANGE)
            codes[bad & ~np.isfinite(array).all(axis=1)] = int(Status.NOT_FINITE)
            # The core computes every lane; what is out of range must not make them fail.
            array[bad] = harmless


def _not_too_fast(v: np.ndarray, codes: np.ndarray) -> np.ndarray:
    """v, its rows at rest that no law of contact can multiply; these are noted."""
    if v.max() <= state.FASTEST and v.min() >= -state.FASTEST:
        return v
    bad = np.isfinite(v).all(axis=1) & (np.abs(v).max(axis=1) > state.FASTEST)
    codes[bad] = int(Status.OUT_OF_RANGE)
    return np.where(bad[:, None], 0.0, v)


def _matrix(values: Any, width: int, what: str) -> np.ndarray:
    array = floats(values, what, copied=False)
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        raise _misshapen(what, width, array, f"or ({width},) for all rows")
    return _rows_of(np.atleast_2d(array), what)


def _misshapen(what: str, width: int, array: np.ndarray, hint: str = "") -> ShapeError:
    wanted: Any = ("B", width)
    return ShapeError.of(what, wanted, array.shape, hint)


def _rows_of(array: np.ndarray, what: str) -> np.ndarray:
    if not len(array):
        raise _misshapen(what, array.shape[-1], array, "the batch is empty")
    return np.ascontiguousarray(array)


def _points(scene: Scene, points: Any) -> tuple[tuple[int, ...], np.ndarray]:
    """The contacts named, by their indices, and (1 or B, 3k) their points."""
    if not isinstance(points, Mapping):
        raise InputError("points: give a mapping from names of contacts to points")
    names = scene.entry_names("contacts")
    columns = {}
    for name, values in points.items():
        if name not in names:
            raise UnknownNameError.among("contact", str(name), names)
        index = names.index(name)
        if not isinstance(scene.contacts[index], Contact):
            raise InputError(f'points["{name}"]: only a Contact has a point of its own')
        columns[index] = _matrix(values, 3, f'points["{name}"]')
    size = max((len(column) for column in columns.values()), default=1)
    for index, column in columns.items():
        if len(column) not in (1, size):
            raise ShapeError.of(f'points["{names[index]}"]', (size, 3), column.shape)
    pointed = tuple(sorted(columns))
    table = [np.broadcast_to(columns[index], (size, 3)) for index in pointed]
    return pointed, np.concatenate([*table, np.zeros((size, 0))], axis=1)


def _factors(scene: Scene, masses: Any) -> tuple[tuple[str, ...], np.ndarray]:
    """The links named, and (1 or B, links) factors on their masses."""
    from .masses import link_inertia

    if not isinstance(masses, Mapping):
        raise InputError("masses: give a mapping from names of links to factors")
    columns = []
    for name, values in masses.items():
        link_inertia(scene.robot, name)
        place = f'masses["{name}"]'
        columns.append(_rows_of(floats(values, place, copied=False).reshape(-1), place))
    size = max((len(column) for column in columns), default=1)
    for name, column in zip(masses, columns, strict=True):
        if len(column) not in (1, size):
            raise ShapeError.of(f'masses["{name}"]', (size,), column.shape)
    table = np.empty((size, len(columns)))
    for k, column in enumerate(columns):
        table[:, k] = column
    return tuple(masses), table


def _coefficients(scene: Scene, what: str, values: Any, count: int) -> np.ndarray:
    """(1 or B, contacts) from a number, an array, or a mapping by name."""
    if not count:
        raise InputError(f"{what}: the scene has no contacts")
    names = scene.entry_names("contacts")
    if isinstance(values, Mapping):
        own = []
        for entry in scene.contacts:
            value = getattr(entry, what, 0.0)
            own.append(value if isinstance(value, float) else np.nan)
        base = np.array(own, dtype=float).reshape(1, -1)
        for name, one in values.items():
            if name not in names:
                raise UnknownNameError.among("contact", str(name), names)
            array = _rows_of(
                floats(one, place := f'{what}["{name}"]', copied=False).reshape(-1), place
            )
            if len(array) > 1 and len(base) == 1:
                base = np.repeat(base, len(array), axis=0)
            elif len(array) not in (1, len(base)):
                raise ShapeError.of(place, (len(base),), array.shape)
            base[:, names.index(name)] = array
        if np.isnan(base).any():
            raise InputError(f"{what}: give all contacts theirs where one is more than a number")
        return base
    table: Any = floats(values, what, copied=False)
    if table.ndim == 0:
        table = np.full((1, count), float(table))
    elif table.ndim == 1 and count == 1:
        table = table.reshape(-1, 1)
    elif table.ndim == 1:
        table = table.reshape(1, -1)
    if table.ndim != 2 or table.shape[1] not in (1, count):
        raise _misshapen(what, count, table)
    return _rows_of(np.array(np.broadcast_to(table, (len(table), count))), what)
