"""Robots: a Pinocchio model with its names, its root, its states and, on demand, its geometry."""

from .combine import combine
from .links import Link
from .robot import Robot
from .source import RobotPart

__all__ = ["Link", "Robot", "RobotPart", "combine"]
