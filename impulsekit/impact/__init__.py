"""From a scene and a state to the velocity jump and all that follows from it."""

from ..laws.status import Status
from .result import Impact
from .solver import ImpactSolver, solve

__all__ = ["Impact", "ImpactSolver", "Status", "solve"]
