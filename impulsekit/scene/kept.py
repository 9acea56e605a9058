"""What is made once for a scene and kept as long as the scene is there."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from typing import Generic, TypeVar

from .scene import Scene

__all__ = ["KeptByScene", "KeptByThread"]

T = TypeVar("T")


class KeptByScene(Generic[T]):
    """What ``make`` gives for a scene, made when first asked for; it may not hold the scene.

    Attributes:
        by_scene: what there is now, by the identity of the scene, which is quicker than its hash.
    """

    def __init__(self, make: Callable[[Scene], T]) -> None:
        self._make = make
        self.by_scene: dict[int, T] = {}

    def of(self, scene: Scene) -> T:
        """What is kept for a scene."""
        found = self.by_scene.get(id(scene))
        if found is None:
            found = self.by_scene[id(scene)] = self._make(scene)
            weakref.finalize(scene, self.by_scene.pop, id(scene), None)
        return found


class KeptByThread(threading.local, KeptByScene[T]):
    """The same for each thread by itself: workspaces, which a use overwrites."""
