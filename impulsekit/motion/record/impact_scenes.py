"""``scene_of_impact``: the scene that an impact on the way of a motion is one of."""

from __future__ import annotations

from dataclasses import replace

from ...scene import Scene
from ...scene.scene import SceneCache, scene_at

__all__ = ["is_soft", "scene_of_impact"]


def scene_of_impact(scene: Scene, t: float, *, soft: bool) -> Scene:
    """The scene without its impulses, with velocities that are driven as they are at a time [s].

    ``soft``: without restitution, as contacts below their capture speeds are met.
    """
    return scene_at((_soft if soft else _later).of(scene), t)


def is_soft(scene: Scene, own: Scene) -> bool:
    """Return whether the scene of an impact is one without the restitution of a motion's."""
    given, here = ([entry.restitution for entry in one.contacts] for one in (scene, own))
    return given != here


def _without_restitution(scene: Scene) -> Scene:
    contacts = [replace(entry, restitution=0.0) for entry in scene.contacts]
    return replace(scene, contacts=contacts)


# Made once, so that their solvers serve every motion of a scene.
_later = SceneCache(lambda scene: replace(scene, impulses=()) if scene.impulses else scene)
_soft = SceneCache(lambda scene: _without_restitution(_later.of(scene)))
