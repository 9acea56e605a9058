"""``impulsekit.jax.solve``: v⁺ of a scene as a function that jax differentiates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .batch.differentiable import Differentiable, leaves_of
from .errors import MissingExtraError
from .errors.calls import public

with MissingExtraError.unless("jax", "jax", "impulsekit.jax"):
    import jax
    import jax.numpy as jnp

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["solve"]


@public
def solve(
    scene: Scene,
    q: Any,
    v: Any,
    *,
    return_mask: bool = False,
    threads: int | None = None,
    **parameters: Any,
) -> Any:
    """Return v⁺ (B, nv) of many impacts, differentiable by q, v and parameters.

    It works under ``jit``, ``vmap`` and ``grad``, by calls back to the core, which computes in
    float64; with ``jax_enable_x64`` nothing is rounded on the way. Rows without a derivative pass
    the gradient of the mode that was found where there is one, and zeros otherwise. Gradients by
    q are by its entries, quaternions and cosines with sines taken at unit length.

    Args:
        scene: the robot, its impulses, constraints and contacts, and the law of contact.
        q, v: (B, nq), (B, nv), or without B.
        return_mask: whether to return (B,) as well in which rows derivatives exist.
        threads: as in ``solve_batch``.
        parameters: impulses, restitution, friction, masses, points as ``solve_batch`` takes them.

    Raises:
        InputError: scenes that ``derivatives`` refuses; no such parameter.

    Example:
        >>> import jax
        >>> from impulsekit import Contact, Robot, Scene
        >>> from impulsekit.jax import solve
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball")])
        >>> fall = jax.numpy.array([0.0, 0.0, -2.0, 0.0, 0.0, 0.0])
        >>> up = lambda e: solve(scene, ball.neutral(), fall, restitution=e)[2]
        >>> float(jax.grad(up)(0.5))
        2.0
    """
    leaves, given = leaves_of(parameters)
    own = Differentiable(scene, leaves, threads)
    arrays = [jnp.asarray(each, dtype=float) for each in (q, v, *given)]
    shapes = own.shapes([array.shape for array in arrays])
    spread = [jnp.broadcast_to(a, shape) for a, (shape, _) in zip(arrays, shapes, strict=True)]
    after, mask = _function(own, tuple(base for _, base in shapes))(*spread)
    return (after, mask) if return_mask else after


def _function(own: Differentiable, bases: tuple[int, ...]) -> Any:
    """v⁺ and the mask of arrays with the same leading axes, and how to pull back."""

    def rows(arrays: Any) -> tuple[tuple[int, ...], list[np.ndarray]]:
        flat = [
            np.asarray(a, dtype=float).reshape(-1, *np.shape(a)[np.ndim(a) - base :])
            for a, base in zip(arrays, bases, strict=True)
        ]
        return np.shape(arrays[0])[:-1], flat

    def forward(*arrays: Any) -> tuple[np.ndarray, np.ndarray]:
        lead, flat = rows(arrays)
        after, exists = own.solve(flat)
        kind = np.asarray(arrays[0]).dtype
        return after.reshape(*lead, -1).astype(kind), exists.reshape(lead)

    def pull(cotangent: Any, *arrays: Any) -> tuple[np.ndarray, ...]:
        _, flat = rows(arrays)
        weights = np.asarray(cotangent, dtype=float).reshape(len(flat[0]), -1)
        found = own.pull(flat, weights)
        return tuple(
            one.reshape(np.shape(a)).astype(np.asarray(a).dtype)
            for one, a in zip(found, arrays, strict=True)
        )

    @jax.custom_vjp
    def after(*arrays: Any) -> Any:
        lead, kind = arrays[0].shape[:-1], arrays[0].dtype
        shapes = (
            jax.ShapeDtypeStruct((*lead, own.nv), kind),
            jax.ShapeDtypeStruct(lead, bool),
        )
        return jax.pure_callback(forward, shapes, *arrays, vmap_method="broadcast_all")

    def with_arrays(*arrays: Any) -> Any:
        return after(*arrays), arrays

    def backward(arrays: Any, cotangents: Any) -> Any:
        shapes = tuple(jax.ShapeDtypeStruct(a.shape, a.dtype) for a in arrays)
        return jax.pure_callback(pull, shapes, cotangents[0], *arrays, vmap_method="broadcast_all")

    after.defvjp(with_arrays, backward)
    return after
