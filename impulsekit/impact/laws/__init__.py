"""Contact laws as pure functions in contact space: no robot, no scene, no Pinocchio model."""

from .problem import ContactProblem, ContactSolution
from .solve import find_impulses, solve_contacts

__all__ = ["ContactProblem", "ContactSolution", "find_impulses", "solve_contacts"]
