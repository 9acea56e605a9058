"""Where a robot came from: what is needed to build it, or its geometry, once more."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .added import NONE, Changes

if TYPE_CHECKING:
    from .loop import Loop
    from .mjcf_pairs import TouchingPair
    from .mjcf_shapes import PlainShape

__all__ = ["RobotPart"]


@dataclass(frozen=True)
class RobotPart:
    """One URDF (or one given model) in the world.

    Attributes:
        urdf: XML text, or None for a robot made from a ``pin.Model``.
        path: the file the text was read from, or None.
        root: "fixed", "planar", "sagittal", "freeflyer", or the short name of a ``pin.JointModel``.
        mimic: whether mimic joints follow their leader instead of moving on their own.
        prefix: what stands before every name, such as "arm/"; "" for a robot alone.
        placement: the 4×4 placement of the root in the world, row by row; None at the origin.
        package_dirs: folders in which "package://" is looked up.
        assumptions: what was assumed where the file leaves something open.
        loops: equality constraints of a file that is no URDF.
        shapes: the geometry of such a file.
        pairs: which of the shapes may touch, with their friction.
        changes: what was added to the part after it was read.
        geometry: URDF text that counts for its geometry alone, since masses are other ones.
        source: the file or kind of text that was written anew as ``urdf``, for messages.
    """

    urdf: str | None
    path: str | None = None
    root: str = "fixed"
    mimic: bool = False
    prefix: str = ""
    placement: tuple[tuple[float, ...], ...] | None = None
    package_dirs: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    loops: tuple[Loop, ...] = ()
    shapes: tuple[PlainShape, ...] = ()
    pairs: tuple[TouchingPair, ...] = ()
    changes: Changes = NONE
    geometry: str | None = None
    source: str | None = None

    @property
    def label(self) -> str:
        """A name for messages: the file's path, or what else is known."""
        if self.source is not None:
            return self.source
        if self.path is not None:
            return os.fspath(self.path)
        if self.urdf is not None or self.geometry is not None:
            return "URDF text"
        return "MJCF text" if self.shapes else "a given model"
