"""From a contact problem and a law to impulses, in contact space: no robot, no scene.

The laws that are compiled stand in ``impulsekit.laws``; here are their problems and answers as
Python's objects, and what is looked at once an answer is there.
"""

from .problem import ContactProblem, ContactSolution
from .solve import find_impulses, solve_contacts

__all__ = ["ContactProblem", "ContactSolution", "find_impulses", "solve_contacts"]
