"""Orders of quaternions and signs of axes that recordings do not state, by floor and momentum."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import comb

import numpy as np
import pinocchio as pin

from ..design.parameters import Measurement, scene_of
from ..display import OneLine
from ..errors import InputError
from ..robot import Robot
from ..scene import Contact, Scene
from ..tolerances import NONZERO
from .active_contacts import ClosingContacts
from .found_impacts import FoundImpact
from .free_fall import has_one_free_body
from .recording import Recording

# Recordings looked at, and the lowest samples of each, whose median stands against outliers.
MOST_RECORDINGS, LOWEST = 24, 12
# A reading is wrong if it pushes contacts below the floor by this share of their reach from the
# body's origin, and another puts them within a quarter of that of the floor. Right readings of a
# cube: .02 at most of 120 tosses with a scale 2 % off; wrong: .13. Floors that are off give every
# reading the same depth. Root mean squares over recordings: of a cube, half the rests in
# the wrong reading are rests on a face again.
DEEP, NEAR = 0.05, 0.25
# Where x, y, z, w stand in what was read, if it was read in the wrong order.
READINGS = ((1, 2, 3, 0), (3, 0, 1, 2))
# A jump is better explained in one order than in another if its balance is so many times as
# probable. Of 120 tosses of a real cube 160 jumps are so in the right order, 23 in the wrong one.
BETTER = 10.0
# Probability that two readings that explain jumps alike come out as far apart: an order is wrong
# below the first, and told to be right below the second, since its name speaks for it.
WRONG, RIGHT = 1e-3, 0.05
# The words where no reading is told from the others.
UNTOLD = (
    "nothing in the recordings tells whether quaternions are in the order that was stated: no "
    "angular velocity, no contact with a floor that another order misses, and too few impacts"
)
# Times that differ by less than so many of their sigmas are one.
SAME_TIME = 3.0


def check_quaternion_order(recordings: Sequence[Recording], scene: Scene, who: str) -> bool:
    """Refuse attitudes that drive a free body through the floor, if another order does not.

    Returns:
        Whether the floor tells that the order is right: the other orders drive the body through.

    Raises:
        InputError: the order of the quaternion looks as if it were the other one.
    """
    planes = [
        entry for entry in scene.contacts if isinstance(entry, Contact) and entry.against == "world"
    ]
    if not planes or not has_one_free_body(scene.robot):
        return False
    looked_at = recordings[:: max(1, len(recordings) // MOST_RECORDINGS)]
    lowest = [_lowest(each, np.array(planes[0].normal)) for each in looked_at]
    gaps, reach = _gaps(scene, planes, lowest, (0, 1, 2, 3))
    deep = _root_mean_square(np.minimum(gaps, 0.0))
    others = [_gaps(scene, planes, lowest, order)[0] for order in READINGS]
    if not deep > DEEP * reach:
        depths = [_root_mean_square(np.minimum(each, 0.0)) for each in others]
        return min(depths) > DEEP * reach
    for each in others:
        if _root_mean_square(each) < NEAR * deep:
            raise InputError(
                f"{who}: as the quaternions are read, contacts lie {1e3 * deep:.3g} mm below the "
                "floor, and in the other order they meet it: the order looks as if it were the "
                "other one, xyzw or wxyz"
            )
    return False


def quaternions_of(robot: Robot) -> list[int]:
    """Places in q at which the quaternions of free and ball joints begin."""
    kinds = {"JointModelFreeFlyer": 3, "JointModelSpherical": 0}
    return [
        int(joint.idx_q) + kinds[joint.shortname()]
        for joint in list(robot.model.joints)[1:]
        if joint.shortname() in kinds
    ]


def check_order_by_balance(
    impacts: Sequence[Sequence[FoundImpact]],
    recordings: Sequence[Recording],
    find: Callable[[Sequence[Recording]], Sequence[Sequence[FoundImpact]]],
    who: str,
) -> str | None:
    """Refuse attitudes with which jumps do not balance momentum, if those in another order do.

    A sign test on the impacts that both readings find.

    Args:
        impacts: of each of ``recordings`` as they are read.
        find: gives the impacts of each of some recordings, which are in another order.

    Returns:
        None if the order is told to be right, else what to note.

    Raises:
        InputError: the order of the quaternion looks as if it were the other one.
    """
    starts = quaternions_of(recordings[0].robot)
    pairs = [pair for pair in zip(impacts, recordings, strict=True) if pair[0]]
    pairs = pairs[:: max(1, len(pairs) // MOST_RECORDINGS)]
    told = True
    for order in READINGS:
        found = find([_reordered(each, starts, order) for _, each in pairs])
        both = [_explained(own, there) for (own, _), there in zip(pairs, found, strict=True)]
        ours, others = (sum(each) for each in zip(*both, strict=True))
        if _by_chance(others, ours) < WRONG:
            raise InputError(
                f"{who}: as the quaternions are read, {others} jumps balance momentum worse than "
                f"in another order, and {ours} better: the order looks as if it were the other "
                "one, xyzw or wxyz"
            )
        told = told and _by_chance(ours, others) < RIGHT
    return None if told else UNTOLD


def _reordered(recording: Recording, starts: Sequence[int], order: tuple[int, ...]) -> Recording:
    q = recording.q.copy()
    for start in starts:
        q[:, start : start + 4] = q[:, [start + k for k in order]]
    return replace(recording, q=q, v=None)


def _explained(first: Sequence[FoundImpact], second: Sequence[FoundImpact]) -> tuple[int, int]:
    """The number of impacts found by both readings that each explains better."""
    better = [0, 0]
    for one in first:
        same = [
            other
            for other in second
            if abs(other.time - one.time) < SAME_TIME * (one.time_sigma + other.time_sigma)
        ]
        if not same or not (one.contacts or same[0].contacts):
            continue
        ours, theirs = (each.balance if each.contacts else 0.0 for each in (one, same[0]))
        better[0] += ours > BETTER * theirs
        better[1] += theirs > BETTER * ours
    return better[0], better[1]


def _by_chance(more: int, fewer: int) -> float:
    """The probability that of as many throws of a coin as many or more fall on one side."""
    count = more + fewer
    return sum(comb(count, k) for k in range(more, count + 1)) / 2.0**count


def _lowest(recording: Recording, normal: np.ndarray) -> np.ndarray:
    """(n, nq) samples of a recording in which the body's origin is lowest."""
    return recording.q[np.argsort(recording.q[:, :3] @ normal, kind="stable")[:LOWEST]]


def _gaps(
    scene: Scene,
    planes: list[Contact],
    lowest: list[np.ndarray],
    order: tuple[int, ...],
) -> tuple[np.ndarray, float]:
    """(recordings,) gaps of the lowest contact, and how far contacts reach [m], medians."""
    model = scene.robot.model
    data = model.createData()
    frames = [model.getFrameId(entry.frame) for entry in planes]
    levels, reaches = [], []
    for rows in lowest:
        gaps = []
        for row in rows:
            q = row.copy()
            q[3:7] = q[3:7][list(order)]
            pin.framesForwardKinematics(model, data, q)
            points = [
                data.oMf[frame].act(np.array(entry.at, dtype=float))
                for frame, entry in zip(frames, planes, strict=True)
            ]
            gaps.append(
                min(
                    float((point - np.array(entry.origin)) @ np.array(entry.normal))
                    for point, entry in zip(points, planes, strict=True)
                )
            )
            reaches.append(max(float(np.linalg.norm(point - q[:3])) for point in points))
        levels.append(float(np.median(gaps)))
    return np.array(levels), float(np.median(reaches))


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


# Impacts that tell the signs; more say the same.
MOST = 200
# More components have too many signs to try.
MOST_COMPONENTS = 6
# The best signs leave less than this share of the jump, or the axes are not what is wrong; and
# others leave at least so many times as much, or the impacts do not tell them apart.
EXPLAINED, TIMES = 0.5, 1.3
# Signs that leave no more than this many times the least explain the jumps as well; shares below
# the second are rounding.
AS_WELL, NOTHING = 1.001, 1e-12
# Singular values of rows below this share of the largest are those of redundant rows.
REDUNDANT = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class MirroredAxes(OneLine):
    """Signs of velocity components for which impacts conserve momentum.

    Attributes:
        signs: (nv,) 1 or -1, by which v⁻ and v⁺ are to be multiplied.
        left, left_before: the median share of the jump M (v⁺ − v⁻) that no impulse at the contacts
            explains, in the metric of the kinetic energy, with these signs and without.
        notes: if the impacts do not tell the signs.

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
        """The measurements with these signs; a covariance goes with them."""
        found = []
        for m in measurements:
            covariance = m.covariance
            if covariance is not None:
                whole = np.concatenate([np.ones(len(self.signs)), self.signs, self.signs])
                covariance = np.asarray(covariance) * np.outer(whole, whole)
            before, after = (np.asarray(v, float) * self.signs for v in (m.v_before, m.v_after))
            found.append(replace(m, v_before=before, v_after=after, covariance=covariance))
        return found


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
    """(W, basis): jumps in the metric of M, what impulses reach there; and the sum of normals."""
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
    """The share of a jump that no impulse explains."""
    root, basis = parts
    jump = root @ (signs * (np.asarray(m.v_after, float) - np.asarray(m.v_before, float)))
    size = float(np.linalg.norm(jump))
    return float(np.linalg.norm(jump - basis @ (basis.T @ jump))) / max(size, NONZERO)
