"""``solve_contact_problems``: contacts of anyone's simulator, given by their matrices."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import solve_problems
from ..errors import InputError, NotFiniteError, RangeError, ShapeError, a_thing, check_kind
from ..errors.calls import public
from ..formatting import OneLine
from ..impact.contact_law import core_law
from ..impact.status import BY_CODE, Status
from ..scene.law import Law
from ..scene.numbers import whole

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["ContactAnswers", "solve_contact_problems"]

# W may differ from its transpose by rounding, of its largest entry: that of single precision.
SYMMETRIC = 1e-5


@public
@dataclass(frozen=True, eq=False, repr=False)
class ContactAnswers(OneLine):
    """The impulses of many contact problems, in the arrays of whoever asked.

    Attributes:
        impulses: (N, 3n) P [N s], t₁, t₂ and normal of each contact.
        velocity_after: (N, 3n) u⁺ [m/s].
        status: (N,) codes of ``impulsekit.Status``.
        residual: (N,) of the law, relative to its terms.
        valid: (N,) whether the impulses may be used.
    """

    impulses: Any
    velocity_after: Any
    status: Any
    residual: Any
    valid: Any

    def __repr__(self) -> str:
        count = len(self.valid)
        return f"ContactAnswers({int(self.valid.sum())} of {count} valid)"


@public
def solve_contact_problems(
    W: Any,
    free: Any,
    *,
    before: Any = None,
    restitution: ArrayLike | Any = 0.0,
    friction: ArrayLike | Any = 0.0,
    tangential_restitution: ArrayLike | Any = 0.0,
    law: Law | None = None,
    threads: int | None = None,
) -> ContactAnswers:
    """Return the impulses of N problems of n contacts each, solved on all processors.

    u⁺ = u_free + W P with P by the law; rows of a contact are two tangents, then the normal,
    which separates where u_n > 0.

    Args:
        W: (N, 3n, 3n) J M⁻¹ Jᵀ [1/kg], symmetric and positive semidefinite; or (3n, 3n) that
            all problems share. A numpy array, or a tensor of any library that knows DLPack (torch,
            jax, cupy, warp), on any device; the answers are of the same kind, on its device.
        free: (N, 3n) u_free [m/s], the velocities without the contacts' impulses.
        before: (N, 3n) u⁻, where known impulses act at the same instant; None for ``free``.
        restitution, friction, tangential_restitution: a number, (n,) or (N, n).
        law: ``Law()`` by default; one without stiffnesses.
        threads: number of threads; None for one a processor.

    Raises:
        ShapeError, NotFiniteError, RangeError: an array of another shape, with NaN or infinity,
            a W that is not symmetric, a coefficient out of range.
        InputError: a law that needs stiffnesses, or that refuses the contacts.

    Example:
        >>> import numpy as np
        >>> W = np.diag([7.0, 7.0, 2.0])  # a ball of 0.5 kg
        >>> falls = [[0.0, 0.0, -2.0], [1.0, 0.0, -3.0]]
        >>> found = solve_contact_problems(W, falls, restitution=0.5, friction=0.3)
        >>> (found.impulses[1].round(3) + 0.0).tolist()
        [-0.143, 0.0, 2.25]
    """
    law = Law() if law is None else law
    check_kind(law, Law, "solve_contact_problems: law")
    if law.restitution == "lzb":
        raise InputError('solve_contact_problems: law "lzb" needs stiffnesses; use a Scene')
    velocities = _array(free, "free")
    if velocities.ndim != 2 or velocities.shape[1] % 3:
        raise ShapeError.of("free", ("N", "3n"), velocities.shape)
    count, rows = velocities.shape
    matrices = _array(W, "W")
    if matrices.shape == (rows, rows):
        matrices = np.ascontiguousarray(np.broadcast_to(matrices, (count, rows, rows)))
    if matrices.shape != (count, rows, rows):
        raise ShapeError.of("W", (count, rows, rows), matrices.shape)
    _check_symmetric(matrices)
    start = velocities if before is None else _array(before, "before")
    if start.shape != velocities.shape:
        raise ShapeError.of("before", velocities.shape, start.shape)
    e, mu, e_t = (
        _coefficient(value, name, (count, rows // 3), low, high)
        for value, name, low, high in (
            (restitution, "restitution", 0.0, 1.0),
            (friction, "friction", 0.0, np.inf),
            (tangential_restitution, "tangential_restitution", -1.0, 1.0),
        )
    )
    own = os.cpu_count() or 1 if threads is None else whole(threads, "threads", 1)
    try:
        found = solve_problems(
            matrices, start, velocities, e, mu, e_t, core_law(law), min(own, max(count, 1))
        )
    except ValueError as error:
        raise InputError(f"solve_contact_problems: {error}") from None
    is_valid = np.array([BY_CODE.get(code, Status.NOT_CONVERGED).valid for code in range(64)])
    impulses, after = (own.reshape(count, rows) for own in (found.impulse, found.after))
    answers = (impulses, after, found.status, found.residual, is_valid[found.status])
    return ContactAnswers(*(_like(answer, free) for answer in answers))


def _array(given: Any, what: str) -> np.ndarray:
    """A contiguous array in double precision of an array, a tensor on any device, or numbers."""
    if hasattr(given, "detach"):  # torch
        given = given.detach().cpu()
    try:
        array = np.asarray(given, dtype=float, order="C")
    except (TypeError, ValueError):
        raise InputError(f"{what} must be an array of numbers, got {a_thing(given)}") from None
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise NotFiniteError.of(what, where, array[where])
    return array


def _check_symmetric(matrices: np.ndarray) -> None:
    apart = np.abs(matrices - matrices.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
    wrong = np.flatnonzero(apart > SYMMETRIC * np.abs(matrices).max(axis=(1, 2), initial=0.0))
    if len(wrong):
        row = int(wrong[0])
        raise RangeError.of(f"W[{row}] - W[{row}]ᵀ", float(apart[row]), "0: W is symmetric")


def _coefficient(
    value: Any, what: str, shape: tuple[int, int], low: float, high: float
) -> np.ndarray:
    array = _array(value, what)
    if array.shape not in ((), shape[1:], shape):
        raise ShapeError.of(what, shape, array.shape, f"or one number, or {shape[1]} of them")
    wrong = array[(array < low) | (array > high)] if array.ndim else array[None]
    if len(wrong) and not low <= wrong[0] <= high:
        allowed = f"{low:g} to {high:g}" if high < np.inf else f"{low:g} or more"
        raise RangeError.of(what, float(wrong[0]), allowed)
    return np.ascontiguousarray(array if array.ndim == 2 else np.broadcast_to(array, shape[1:]))


def _like(answer: np.ndarray, given: Any) -> Any:
    """An answer as an array of the library of what was given, on its device."""
    if hasattr(given, "detach"):
        import torch

        found = torch.from_numpy(answer)
        return found.to(given.device, given.dtype if found.is_floating_point() else found.dtype)
    if not isinstance(given, np.ndarray) and hasattr(given, "__array_namespace__"):
        return given.__array_namespace__().asarray(answer, device=given.device)
    return answer
