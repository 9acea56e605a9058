"""How far a robot extends."""

from __future__ import annotations

import numpy as np

from ..reference.kinematics import Kinematics
from ..reference.tree import WORLD, Tree

__all__ = ["reach_of"]


def reach_of(tree: Tree, at: Kinematics) -> float:
    """How far a body extends from the root of its tree [m]; never 0."""
    origins, centres = at.origins.astype(float), at.mass_centres.astype(float)
    roots: list[int] = []
    reach = 0.0
    for k, body in enumerate(tree.bodies):
        roots.append(k if body.parent == WORLD else roots[body.parent])
        base = origins[roots[k]]
        gyration = 0.0
        if body.mass > 0:
            gyration = float(np.sqrt(max(float(np.trace(body.inertia)) / float(body.mass), 0.0)))
        distances = np.linalg.norm(origins[k] - base), np.linalg.norm(centres[k] - base)
        reach = max(reach, gyration, *map(float, distances))
    return reach or 1.0
