"""``Program``: a scene as the core takes it for batches, made once for all states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from .._core import Load
from .._core import Program as CoreProgram
from ..impact.flat.law import contact_law
from ..impact.flat.links import flat_links_of
from ..impact.flat.model import inertia_numbers
from ..impact.flat.scene import FlatScene, flat_scene
from ..scene import Restitution, RestitutionTable, Scene
from ..scene.scene import SceneCache
from .masses import link_inertia

if TYPE_CHECKING:
    from ..scene import Contact

__all__ = ["BatchPlan", "Program", "program_of"]


@dataclass(frozen=True)
class BatchPlan:
    """The plan by which a batch is solved.

    Attributes:
        rows: how many rows of constraints there are.
        why: a sentence for each choice.
    """

    rows: int
    why: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Program:
    """A scene in the core.

    Attributes:
        flat: what holds and touches the robot.
        core: that, and what is asked of joints and links.
        frames: of each contact whose point varies, its frame in the joint.
        plan: how it is solved.
    """

    flat: FlatScene
    core: CoreProgram
    frames: tuple[Any, ...]
    plan: BatchPlan


# By the links whose masses vary, and the contacts whose points do.
_Programs = dict[tuple[tuple[str, ...], tuple[int, ...]], Program]
_programs: SceneCache[_Programs] = SceneCache(lambda scene: {})


def is_new(scene: Scene) -> bool:
    """Return whether no batch of a scene was solved yet."""
    return not _programs.of(scene)


def program_of(
    scene: Scene, *, links: tuple[str, ...] = (), pointed: tuple[int, ...] = ()
) -> Program:
    """The program of a scene, kept with it.

    Args:
        links: those whose masses vary.
        pointed: indices of the contacts whose points vary.
    """
    own, key = _programs.of(scene), (links, pointed)
    if key not in own:
        own[key] = _made(scene, links, pointed)
    return own[key]


def _made(scene: Scene, links: Sequence[str], pointed: Sequence[int]) -> Program:
    robot, flat = scene.robot, flat_scene(scene)
    model = flat.model
    for name in links:
        joint_id, inertia = link_inertia(robot, name)
        flat.core.add_load(Load(body=model.bodies[joint_id], **inertia_numbers(inertia)))
    flat.core.vary_points(list(pointed))
    named = [cast("Contact", scene.contacts[i]).frame for i in pointed]
    frames = [robot.model.frames[robot.frame_id(name)] for name in named]
    core = CoreProgram(
        flat.core,
        contact_law(scene),
        bool(robot.nv == 0 or robot.is_always_regular),
        list(model.bodies[1:]),
        flat_links_of(robot).core,
    )
    return Program(
        flat,
        core,
        tuple(frame.placement for frame in frames),
        _plan(scene, flat),
    )


def _plan(scene: Scene, flat: FlatScene) -> BatchPlan:
    joints = scene.robot.model.njoints - 1
    if not flat.names and not scene.contacts:
        return BatchPlan(0, (f"articulated bodies over {joints} joints",))
    why = [f"mass matrix over {joints} joints, {len(flat.names)} rows of constraints"]
    if flat.functions or flat.contact_functions:
        why.append("points of bodies and rows by functions are found row by row in Python")
    own = [entry.restitution for entry in scene.contacts]
    if any(callable(e) and not isinstance(e, Restitution | RestitutionTable) for e in own):
        why.append("a function of one's own is called in Python")
    return BatchPlan(len(flat.names), tuple(why))
