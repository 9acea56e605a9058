"""Friction along the path at several contacts, against paths followed in time.

In the plane ``truths.along_paths`` follows the same impact by another program: slip that stops,
sticks, turns back and starts again, contacts that meet twice, bodies on several points of one
floor. In space bodies stand on several points, and what is left of cones, works and energy counts;
``truths.space_paths`` follows some of them in time as well: that takes a second for each.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from impulsekit.impact.contact_law import ContactProblem
from impulsekit.scene.law import Law
from impulsekit.tolerances import NONZERO
from tests.truths.along_paths import Planar, follow_in_time
from tests.truths.space_paths import Spatial, space_error

from .statements import CONTACTS, Judged, energetic, points_of, problem_of_points
from .sweep import Sweep

__all__ = ["SWEEPS"]

# Of the states, those in space, and of those in the plane the bodies that stand on all points.
IN_SPACE, STANDING = 0.25, 0.4
# Of the states followed in space those whose slip begins from rest; with any W, and standing.
FROM_REST, ANY_W, STANDS = 0.5, 0.3, 0.4
# What may be left of them: slip from rest has a direction of its own from ``wave_slips.SLOW`` on,
# and where it begins without acceleration some 3e-9 of the velocities are left of that.
OFF = 1e-8


def _rows(n: int, rng: np.random.Generator, *, stands: bool) -> tuple[np.ndarray, np.ndarray]:
    """(2n, 3k) rows of n normals and n tangents of bodies in the plane, (3k,) inverse masses."""
    count = 1 if stands else n + 1
    inverse, rows = np.empty(3 * count), np.zeros((2 * n, 3 * count))
    for body in range(count):
        mass, radius = 10.0 ** rng.uniform(-1, 1), rng.uniform(0.05, 0.3)
        inertia = mass * radius**2 * rng.uniform(0.3, 1.0)
        inverse[3 * body : 3 * body + 3] = 1.0 / mass, 1.0 / mass, 1.0 / inertia
    for i in range(n):
        angle = 0.5 * np.pi if stands else rng.uniform(0, 2 * np.pi)
        normal = np.array([np.cos(angle), np.sin(angle)])
        for body, sign in [(0, 1.0)] if stands else [(i, -1.0), (i + 1, 1.0)]:
            arm = rng.uniform(-0.3, 0.3, 2)
            if stands:
                arm[1] = -0.2
            for row, way in ((i, normal), (n + i, np.array([-normal[1], normal[0]]))):
                turns = arm[0] * way[1] - arm[1] * way[0]
                rows[row, 3 * body : 3 * body + 3] = sign * np.array([*way, turns])
    return rows, inverse


def _planar(
    n: int, rng: np.random.Generator, *, stands: bool
) -> tuple[ContactProblem, Planar, np.ndarray]:
    """The same contacts for the law and for the truth, whose rows stand where in the law's."""
    rows, inverse = _rows(n, rng, stands=stands)
    v = rng.normal(size=rows.shape[1]) * np.tile([1, 1, 3], rows.shape[1] // 3)
    if stands:
        v[1] -= 2.0
    free, W = rows @ v, rows * inverse @ rows.T
    W = 0.5 * (W + W.T)
    mu = rng.choice([0.0, 0.2, 0.5, 0.8], n)
    e = np.where(rng.random(n) < 0.5, 1.0, rng.uniform(0.3, 1.0, n))
    kappa = 10.0 ** rng.uniform(-2, 0, n)
    kappa /= kappa.max()
    at = np.concatenate([3 * np.arange(n) + 2, 3 * np.arange(n)])
    delassus, before = np.eye(3 * n), np.zeros(3 * n)
    delassus[np.ix_(at, at)], before[at] = W, free
    own = ContactProblem(delassus, before, before, e, mu, np.zeros(n), stiffness=1e5 * kappa)
    m = n + 1 if stands else 2 * n
    rub = mu[None] if stands else np.diag(mu)
    power = float(rng.choice([1.0, 1.5]))
    return own, Planar(W[:m, :m], free[:m], e, kappa, power, rub), at[:m]


def _path(n: int, rng: np.random.Generator) -> Judged:
    """Friction along the path at several contacts, against the same impact followed in time."""
    if rng.random() < IN_SPACE:
        problem = problem_of_points(n, rng, float(rng.choice([0.0, 0.5, 1.0])), stands=True)
        problem = replace(problem, stiffness=10.0 ** rng.uniform(4, 6, n))
        return energetic(problem, Law("lzb", exponent=float(rng.choice([1.0, 1.5]))))
    problem, planar, at = _planar(n, rng, stands=n > 1 and bool(rng.random() < STANDING))
    judged = energetic(problem, Law("lzb", exponent=planar.power))
    impulse = follow_in_time(planar)
    if impulse is None:
        # Not followed to its end: then cones, works and energy count alone.
        return judged
    after = planar.free + planar.W @ impulse
    off = float(np.abs(after - judged.solution.velocity_after[at]).max())
    return replace(judged, left=max(judged.left, off / (np.abs(planar.free).max() + NONZERO)))


def _in_space(n: int, rng: np.random.Generator) -> Judged:
    """Friction along the path in space, slip from rest too, against springs followed in time."""
    kind, rests = rng.random(), bool(rng.random() < FROM_REST)
    stands = ANY_W <= kind < ANY_W + STANDS
    problem = problem_of_points(n, rng, 0.5, stands=stands)
    W, before = problem.delassus, problem.velocity_before
    if kind < ANY_W:
        root = rng.normal(size=(3 * n, 3 * n + int(rng.integers(3))))
        W = root @ root.T
    if rests:
        # What stands falls without turning, so that velocities of its points are in the range.
        before = np.where(np.arange(3 * n) % 3 == 2, -1.0 if stands else before, 0.0)
    e = np.where(rng.random(n) < 0.3, 1.0, rng.uniform(0.2, 1.0, n))
    mu, kappa = rng.choice([0.1, 0.3, 0.6, 1.0], n), 10.0 ** rng.uniform(-1.5, 0, n)
    power, kappa = float(rng.choice([1.0, 1.5])), kappa / kappa.max()
    problem = replace(
        problem, delassus=W, velocity_before=before, velocity_free=before, restitution=e,
        friction=mu, stiffness=1e5 * kappa,
    )  # fmt: skip
    judged = energetic(problem, Law("lzb", exponent=power))
    speed = float(np.abs(before).max()) + NONZERO
    spatial = Spatial(W / W.diagonal().max(), before / speed, e, kappa, mu, power)
    off = space_error(spatial, judged.solution.velocity_after / speed)
    # Not followed to its end: then cones, works and energy count alone.
    return replace(judged, left=max(judged.left, off or 0.0))


SWEEPS = (
    Sweep("statement-path", "contacts", CONTACTS, points_of(_path), 420, logarithmic=False),
    Sweep(
        "statement-path-space",
        "contacts",
        CONTACTS,
        points_of(_in_space, 1, OFF),
        30,
        logarithmic=False,
    ),
)
