"""From a scene and a state to the velocity jump and all that follows from it."""

from .all_outcomes import Outcomes
from .result import Impact
from .solver import ImpactSolver, solve
from .status import Status

__all__ = ["Impact", "ImpactSolver", "Outcomes", "Status", "solve"]
