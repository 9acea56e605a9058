"""What happens to a robot, as plain frozen data."""

from .impulses import AppliedImpulse, JointImpulse
from .scene import Scene

__all__ = ["AppliedImpulse", "JointImpulse", "Scene"]
