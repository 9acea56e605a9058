"""``find_mirrored``: signs of velocity components that recordings do not state, by momentum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ..design.parameters import Measurement, scene_of
from ..errors import InputError
from ..errors.calls import public
from ..formatting import OneLine
from ..tolerances import NONZERO
from .active_contacts import ClosingContacts

# Impacts that determine the signs; more change nothing.
MOST = 200
# More components have too many signs to try.
MOST_COMPONENTS = 6
# The best signs leave less than this share of the jump, or the axes are not what is wrong; and
# others leave at least so many times as much, or the impacts do not distinguish them.
EXPLAINED, TIMES = 0.5, 1.3
# Signs that leave no more than this many times the least explain the jumps as well; shares below
# the second are rounding.
AS_WELL, NOTHING = 1.001, 1e-12
# Singular values of rows below this share of the largest are those of redundant rows.
REDUNDANT = 1e-9


@public
@dataclass(frozen=True, eq=False, repr=False)
class MirroredAxes(OneLine):
    """Signs of velocity components for which impacts conserve momentum.

    Attributes:
        signs: (nv,) 1 or -1, by which v⁻ and v⁺ are to be multiplied.
        left, left_before: the median share of the jump M (v⁺ − v⁻) that no impulse at the contacts
            explains, in the metric of the kinetic energy, with these signs and without.
        notes: if the impacts do not determine the signs.

    Example:
        >>> import numpy as np
        >>> MirroredAxes(np.array([-1.0, 1.0, 1.0]), 0.1, 0.8).signs[0]
        np.float64(-1.0)
    """

    signs: np.ndarray
    left: float
    left_before: float
    notes: tuple[str, ...] = ()

    def apply(self, measurements: Sequence[Measurement]) -> list[Measurement]:
        """Return the measurements with these signs; a covariance goes with them."""
        found = []
        for m in measurements:
            covariance = m.covariance
            if covariance is not None:
                whole = np.concatenate([np.ones(len(self.signs)), self.signs, self.signs])
                covariance = np.asarray(covariance) * np.outer(whole, whole)
            before, after = (np.asarray(v, float) * self.signs for v in (m.v_before, m.v_after))
            found.append(replace(m, v_before=before, v_after=after, covariance=covariance))
        return found


@public
def find_mirrored(measurements: Sequence[Measurement]) -> MirroredAxes:
    """Find the components of velocities that are recorded with the other sign.

    An impact changes momentum by impulses at its contacts alone, M (v⁺ − v⁻) = Jᵀ P: I Δω =
    r × m Δv of a lone body. All signs of the components are tried, those that leave least
    are taken; of the two that differ in all signs, the one in which contacts approach.

    Args:
        measurements: whole velocities, contacts where they touch (``points``), robots of six
            velocity components at most.

    Raises:
        InputError: no measurement, too many components, or velocities with gaps.

    Example:
        >>> import numpy as np, impulsekit as ik
        >>> ball = ik.Robot.from_urdf("models/ball.urdf", root="planar")
        >>> scene = ik.Scene(ball, contacts=[ik.Contact("ball", normal=[0, 1, 0], friction=0.3,
        ...                                             restitution=0.5, name="tip")])
        >>> rng, seen, sign = np.random.default_rng(0), [], np.array([-1.0, 1, 1])
        >>> for _ in range(12):
        ...     at, v = [*rng.uniform(-0.05, 0.05, 2), 0], rng.normal(size=3) - [0, 3, 0]
        ...     after = ik.solve_batch(scene, ball.neutral(), v, points={"tip": at}).v_after[0]
        ...     seen.append(ik.measured.Measurement(scene, ball.neutral(), sign * v, sign * after,
        ...                                         points={"tip": at}))
        >>> find_mirrored(seen).signs.tolist()
        [-1.0, 1.0, 1.0]
    """
    seen = list(measurements)
    if not seen:
        raise InputError("find_mirrored: no measurements; give one or more")
    nv = seen[0].scene.robot.nv
    if nv < 2:
        raise InputError("find_mirrored: needs two velocity components or more, got 1")
    if nv > MOST_COMPONENTS:
        raise InputError(f"find_mirrored: at most {MOST_COMPONENTS} velocity components, got {nv}")
    chosen = seen[:: -(-len(seen) // MOST)]
    parts = [_parts(m) for m in chosen]
    pairs = list(zip(parts, chosen, strict=True))
    left: dict[tuple[float, ...], float] = {}
    for others in product((1.0, -1.0), repeat=nv - 1):
        tried = (1.0, *others)
        shares = [_share(own, m, np.array(tried)) for (own, _), m in pairs]
        left[tried] = float(np.median(shares))
    plain = left[(1.0,) * nv]
    least = min(left.values())
    # Of those that explain it as well, the one with the fewest changes.
    best = max((s for s in left if left[s] <= AS_WELL * least + NOTHING), key=sum)
    signs = np.array(best)
    speeds = [float(normal @ (signs * np.asarray(m.v_before))) for (_, normal), m in pairs]
    if np.median(speeds) > 0.0:
        signs = -signs
    notes = []
    if left[best] > EXPLAINED:
        notes.append("no signs make the jumps conserve momentum: contacts or inertias may be off")
    if min(left[s] for s in left if s != best) < TIMES * left[best] + NOTHING:
        notes.append("not all signs are determined: others explain the jumps nearly as well")
    signs.setflags(write=False)
    return MirroredAxes(signs, left[best], plain, tuple(notes))


def _parts(m: Measurement) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Return W and basis, jumps in M's metric and what impulses reach; and the sum of normals."""
    v = np.array([m.v_before, m.v_after], dtype=float)
    if not np.isfinite(v).all():
        raise InputError("find_mirrored: a velocity has gaps; leave such impacts out")
    closing = ClosingContacts(scene_of(m, [], np.zeros(0), {}))
    mass, rows, normals = closing.mass_and_rows(np.array(m.q, dtype=float))
    root = np.linalg.cholesky(mass).T
    reach = np.linalg.solve(root.T, rows.T)
    left, values, _ = np.linalg.svd(reach, full_matrices=False)
    return (root, left[:, values > REDUNDANT * values[0]]), normals.sum(axis=0)


def _share(parts: tuple[np.ndarray, np.ndarray], m: Measurement, signs: np.ndarray) -> float:
    """Return the share of a jump that no impulse explains."""
    root, basis = parts
    jump = root @ (signs * (np.asarray(m.v_after, float) - np.asarray(m.v_before, float)))
    size = float(np.linalg.norm(jump))
    return float(np.linalg.norm(jump - basis @ (basis.T @ jump))) / max(size, NONZERO)
