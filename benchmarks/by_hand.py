"""Solves beside the calls to Pinocchio, numpy and scipy that one would write instead.

These make Jacobians, M with its Cholesky factor and the least squares of velocities that are
to be 0: no friction, no parting, no rank is decided and nothing is checked.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio as pin

from impulsekit.impact import solve
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, Contact, Law, Scene

from .methods.bare import Points
from .problems.feet import CORNERS, FEET, SOLES, landing_state
from .problems.registry import problem_named
from .timing import Times, in_turn

__all__ = ["BESIDE_BARE"]

# Calls in turn.
ROUNDS = 301
# Singular values of W, relative, below which rows are redundant: what numpy is told.
REDUNDANT = 1e-10

Case = Callable[[], tuple[Scene, np.ndarray, np.ndarray]]


def _landing(
    name: str, friction: float, e: float = 0.0, along: float = 0.0, law: Law | None = None
) -> tuple[Scene, np.ndarray, np.ndarray]:
    """Solo12 on four feet or Talos on eight points of its soles, down at some 1 m/s."""
    robot = Robot.from_example(name, root="freeflyer")
    points = [(foot, (0.0, 0.0, 0.0)) for foot in FEET]
    if name == "talos":
        points = [(sole, at) for sole in SOLES for at in CORNERS]
    contacts = [Contact(f, at=at, friction=friction, restitution=e) for f, at in points]
    state = landing_state(robot, len(points), along)
    return Scene(robot, contacts=contacts, law=law or Law()), *state


def _one_foot() -> tuple[Scene, np.ndarray, np.ndarray]:
    """A corner of one sole along its path, Stronge's restitution."""
    scene, q, v = _landing("talos", 0.5, 0.3)
    law = Law("stronge", slip="path")
    return Scene(scene.robot, contacts=scene.contacts[:1], law=law), q, v


def _pinned() -> tuple[Scene, np.ndarray, np.ndarray]:
    """Talos struck at a hand, both soles held."""
    problem = problem_named("held robot", "held robot 12")
    return problem.scene, problem.q, problem.v


def _four_bar() -> tuple[Scene, np.ndarray, np.ndarray]:
    """Three rods between two pins, struck."""
    problem = problem_named("closed chain", "closed chain 3")
    return problem.scene, problem.q, problem.v


def _by_hand(scene: Scene, q: np.ndarray, v: np.ndarray) -> Callable[[], np.ndarray]:
    """v⁺ with all rows held."""
    import scipy.linalg

    points = Points(scene)
    model, data = points.model, points.data
    blows = [entry for entry in scene.impulses if isinstance(entry, AppliedImpulse)]
    rows = [(frame, len(kept)) for frame, kept in points.rows]
    jacobian = np.zeros((sum(count for _, count in rows), model.nv))
    world = pin.LOCAL_WORLD_ALIGNED

    def velocity_after() -> np.ndarray:
        upper = pin.crba(model, data, q)
        factor = scipy.linalg.cho_factor(np.triu(upper) + np.triu(upper, 1).T)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        first = 0
        for frame, count in rows:
            part = pin.getFrameJacobian(model, data, frame, world)[:count]
            jacobian[first : first + count] = part
            first += count
        before = v
        if blows:
            total = points.joint_impulse.copy()
            for frame, wrench in points.blows:
                total += wrench @ pin.getFrameJacobian(model, data, frame, world)
            before = v + scipy.linalg.cho_solve(factor, total)
        moved = scipy.linalg.cho_solve(factor, jacobian.T)
        right = -jacobian @ before
        return before + moved @ np.linalg.lstsq(jacobian @ moved, right, rcond=REDUNDANT)[0]

    return velocity_after


def _beside_bare(case: Case) -> Times:
    scene, q, v = case()
    return in_turn(partial(solve, scene, q, v), _by_hand(scene, q, v), rounds=ROUNDS)


def _rows(*cases: tuple[str, Case, float]) -> tuple[tuple[str, Callable[[], Times], float], ...]:
    return tuple((label, partial(_beside_bare, case), bound) for label, case, bound in cases)


# What is solved, its times, and the bound of solve over the calls by hand.
BESIDE_BARE = _rows(
    ("Solo12 on four feet", partial(_landing, "solo12", 0.6, 0.3), 0.6),
    ("Solo12, four feet, Poisson", partial(_landing, "solo12", 0.6, 0.3, law=Law("poisson")), 0.8),
    (
        "Solo12, four feet in sequence",
        partial(_landing, "solo12", 0.6, 0.3, law=Law(order="sequential")),
        0.8,
    ),
    ("Talos on a corner along the path, Stronge", _one_foot, 1.5),
    ("Talos on eight points", partial(_landing, "talos", 0.5), 0.6),
    ("Talos on eight points, all slip", partial(_landing, "talos", 0.5, 0.3), 2.3),
    ("Talos on eight points, half of them slip", partial(_landing, "talos", 0.1), 1.9),
    ("Talos on eight points, sliding", partial(_landing, "talos", 0.3, along=2.0), 0.8),
    ("Talos, eight points, Poisson", partial(_landing, "talos", 0.5, 0.3, law=Law("poisson")), 2.3),
    ("Talos held at both feet", _pinned, 0.6),
    ("struck four-bar", _four_bar, 0.9),
)
