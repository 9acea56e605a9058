"""What a robot is made of, for the files that say what one can do with it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, cast

import pinocchio as pin

from ..display import Displayed, one_line
from .source import RobotPart

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["RobotBase"]


class RobotBase(Displayed):
    """The model, the sources it was made from, and the name of a robot."""

    def __init__(self, model: pin.Model, parts: Iterable[RobotPart], name: str) -> None:
        self.model = model
        self.parts = tuple(parts)
        self.name = name

    @property
    def _robot(self) -> Robot:
        """This robot, to functions that take one."""
        return cast("Robot", self)

    def __getstate__(self) -> dict[str, Any]:
        # Cached geometry and tables are made again on the other side.
        return {"model": self.model, "parts": self.parts, "name": self.name}

    def __repr__(self) -> str:
        roots = "/".join(dict.fromkeys(part.root for part in self.parts))
        return one_line("Robot", repr(self.name), root=roots, nq=self.model.nq, nv=self.model.nv)
