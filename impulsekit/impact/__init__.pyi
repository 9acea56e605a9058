from .all_outcomes import Outcomes as Outcomes
from .result import Impact as Impact
from .solver import ImpactSolver as ImpactSolver
from .solver import solve as solve
from .status import Status as Status
