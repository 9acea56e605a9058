"""The programs of a scene for the kernels, kept with it, and the plans that they tell."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..scene import Scene
from ..scene.kept import KeptByScene

if TYPE_CHECKING:
    from .program import BatchPlan, Program

__all__ = ["plan_batch"]

# By whether contacts get tangent rows whatever their friction, the links whose masses vary, and
# the contacts whose points do.
_Programs = dict[tuple[bool, tuple[str, ...], tuple[int, ...]], tuple[Any, Any]]
_programs: KeptByScene[_Programs] = KeptByScene(lambda scene: {})


def plan_batch(
    scene: Scene,
    *,
    frictional: bool = False,
    links: tuple[str, ...] = (),
    pointed: tuple[int, ...] = (),
) -> tuple[Program | None, BatchPlan]:
    """The program of a scene for the kernels (None: there is none) and the plan; kept with it.

    Args:
        frictional: give contacts tangent rows even where their own friction is 0.
        links: those whose masses vary.
        pointed: indices of the contacts whose points vary.
    """
    own, key = _programs.of(scene), (frictional, links, pointed)
    if key not in own:
        from .program import compiled

        own[key] = compiled(scene, frictional=frictional, links=links, pointed=pointed)
    return own[key]
