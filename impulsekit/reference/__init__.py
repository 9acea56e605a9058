"""The independent truth: Chang & Huston's method, equation by equation, in any precision.

Nothing here knows Pinocchio. yourdfpy reads the tree of a URDF, its numbers come from the text; the
bodies' motion and the impact equations are those of the paper, and the numbers are doubles, long
doubles or of as many digits as are asked for.

    urdf ─► tree ─► kinematics ─► kane ─► system, impact    the method of the paper

``whittaker`` holds chains whose answers are exact fractions.
"""

from impulsekit.reference.arithmetic import Arithmetic
from impulsekit.reference.impact import KaneImpact
from impulsekit.reference.loads import JointSpring, Load, PointSpring
from impulsekit.reference.rows import Rows
from impulsekit.reference.system import KaneSystem
from impulsekit.reference.tree import Tree

__all__ = [
    "Arithmetic",
    "JointSpring",
    "KaneImpact",
    "KaneSystem",
    "Load",
    "PointSpring",
    "Rows",
    "Tree",
]
