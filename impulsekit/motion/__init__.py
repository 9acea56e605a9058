"""What happens after an impact: forces, flight, events, rest, and the ``Trajectory`` of it all."""

from .simulate import simulate
from .status import MotionStatus
from .trajectory import Trajectory

__all__ = ["MotionStatus", "Trajectory", "simulate"]
