"""What happens to a robot, as plain frozen data."""

from .constraints import Constraint, FrameAnchor, JointCoupling, JointLock, PointAnchor
from .impulses import AppliedImpulse, JointImpulse
from .scene import Scene

__all__ = [
    "AppliedImpulse",
    "Constraint",
    "FrameAnchor",
    "JointCoupling",
    "JointImpulse",
    "JointLock",
    "PointAnchor",
    "Scene",
]
