"""``impulsekit.torch.solve``: v⁺ of a scene as a function that torch differentiates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .batch.differentiable import Differentiable, leaves_of
from .errors import MissingExtraError
from .errors.calls import public

with MissingExtraError.unless("torch", "torch", "impulsekit.torch"):
    import torch

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["solve"]


class _Solve(torch.autograd.Function):
    """Forward and backward on the core's threads, in float64."""

    @staticmethod
    def forward(ctx: Any, own: Differentiable, *tensors: torch.Tensor) -> Any:
        arrays = [tensor.detach().cpu().numpy() for tensor in tensors]
        after, exists = own.solve(arrays)
        ctx.own = own
        ctx.save_for_backward(*tensors)
        mask = torch.from_numpy(exists.copy())
        ctx.mark_non_differentiable(mask)
        return torch.from_numpy(after.copy()).to(tensors[0].device), mask

    @staticmethod
    def backward(ctx: Any, *cotangents: Any) -> Any:
        tensors = ctx.saved_tensors
        arrays = [tensor.detach().cpu().numpy() for tensor in tensors]
        found = ctx.own.pull(arrays, cotangents[0].detach().cpu().double().numpy())
        gradients = (
            torch.from_numpy(own).to(tensor.device)
            for own, tensor in zip(found, tensors, strict=True)
        )
        return None, *gradients


@public
def solve(
    scene: Scene,
    q: torch.Tensor,
    v: torch.Tensor,
    *,
    return_mask: bool = False,
    threads: int | None = None,
    **parameters: Any,
) -> Any:
    """Return v⁺ (B, nv) of many impacts, differentiable by q, v and parameters.

    Rows without a derivative (see ``exists`` of the mask) pass the gradient of the mode that was
    found where there is one, and zeros otherwise. Gradients by q are by its entries, quaternions
    and cosines with sines taken at unit length. All is computed in float64 and given back in the
    type of v.

    Args:
        scene: the robot, its impulses, constraints and contacts, and the law of contact.
        q, v: (B, nq), (B, nv), or without B.
        return_mask: whether to return (B,) as well in which rows derivatives exist.
        threads: as in ``solve_batch``.
        parameters: impulses, restitution, friction, masses, points as ``solve_batch`` takes them,
            as tensors or numbers.

    Raises:
        InputError: scenes that ``derivatives`` refuses; no such parameter.

    Example:
        >>> import torch
        >>> from impulsekit import Contact, Robot, Scene
        >>> from impulsekit.torch import solve
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball")])
        >>> e = torch.tensor(0.5, requires_grad=True)
        >>> fall = torch.tensor([[0.0, 0.0, -2.0, 0.0, 0.0, 0.0]])
        >>> solve(scene, torch.tensor(ball.neutral()), fall, restitution=e)[0, 2].backward()
        >>> e.grad
        tensor(2.)
    """
    leaves, given = leaves_of(parameters)
    own = Differentiable(scene, leaves, threads)
    tensors = [torch.as_tensor(each) for each in (q, v, *given)]
    kind = tensors[1].dtype if tensors[1].is_floating_point() else torch.float64
    shapes = own.shapes([tuple(tensor.shape) for tensor in tensors])
    rows = [
        tensor.to(torch.float64).expand(shape).reshape(-1, *shape[len(shape) - base :])
        for tensor, (shape, base) in zip(tensors, shapes, strict=True)
    ]
    after, mask = _Solve.apply(own, *rows)
    lead = shapes[0][0][:-1]
    after = after.reshape(*lead, -1).to(kind)
    return (after, mask.reshape(lead)) if return_mask else after
