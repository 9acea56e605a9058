"""Robots: a Pinocchio model with its names, its root, its states and, on demand, its geometry.

Only ``Robot`` itself is imported here; ``combine``, the example robots and geometry are
modules of their own, loaded when first used.
"""

from .robot import Robot
from .source import RobotPart

__all__ = ["Robot", "RobotPart"]
