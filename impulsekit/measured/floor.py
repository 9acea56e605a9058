"""The floor under bodies at rest: its height and tilt against the scene's plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..geometry.axes import contact_axes
from ..robot.placing import Posture
from ..scene import Contact, Scene
from ..tolerances import NONZERO
from .free_fall import free_bodies
from .recording import Recording
from .segments import MEDIAN_TO_SIGMA

# A body is at rest where the medians of three parts of a run of samples differ by no more than so
# slow a way [m/s, rad/s] and so many standard deviations of their noise.
STILL, NOISY = 0.05, 3.0
# Runs have so many samples and last so long at least [s]; shorter ones are for recordings without a
# longer rest: at the top of a flight a body falls 12 mm, or 6 mm, in that time.
RUNS = ((18, 0.1), (12, 0.07))
# The deviation of a median over the deviation of a mean.
MEDIAN_OVER_MEAN = 1.2533141373155003
# Points this near to the lowest one carry the body [m].
CARRYING = 0.004
# A plane whose normal is off by less is the same one [rad], whose origin by less [m].
SAME = 1e-9
# Unknowns whose rows vary by less than this [relative, root mean square] are not distinguished from
# those before them; so many rests at least determine an uncertainty.
UNDETERMINED_FLOOR, FEWEST_RESTS = 0.05, 3
# [of the square of a direction] Unknowns with more than this in what no rest determines.
UNDETERMINED_SHARE = 1e-3
# Slopes are determined over this way at least [m].
NARROW = 1e-3


@dataclass(frozen=True, eq=False)
class FloorFit:
    """The recorded floor against the scene's plane.

    Attributes:
        values: (6,) height [m], slopes along the plane's two axes [rad], and d (3,), the offset
            of the recorded position against the body's frame, in its axes [m].
        sigma: (6,) standard deviations, infinite for what is not determined.
        rests: how many recordings end or pause at rest.
        plane: (3, 3) axes with the normal last, and (3,) origin; None without a plane.
        notes: what to look at.
    """

    values: np.ndarray
    sigma: np.ndarray
    rests: int
    plane: tuple[np.ndarray, np.ndarray] | None
    notes: tuple[str, ...] = ()


def fitted_floor(several: list[Recording], scene: Scene, scale: float) -> FloorFit:
    """Least squares on the gaps of the points that carry bodies at rest, g = h + a x + b y + n·R d.

    ``scale``: recorded lengths over true ones. Bodies that lie on several faces determine d.
    """
    contacts = [
        entry for entry in scene.contacts if isinstance(entry, Contact) and entry.against == "world"
    ]
    if not contacts:
        note = (
            "no floor was fitted: its height is that of a Contact with a plane of the world, and "
            "the scene has none"
        )
        return FloorFit(np.zeros(6), np.full(6, np.inf), 0, None, (note,))
    normal, origin = np.array(contacts[0].normal), np.array(contacts[0].origin)
    axes = np.array(contact_axes(normal))
    contacts = [
        entry
        for entry in contacts
        if np.abs(np.array(entry.normal) - normal).max() < SAME
        and abs(float((np.array(entry.origin) - origin) @ normal)) < SAME
    ]
    rows, heights, groups = [], [], []
    for number, recording in enumerate(several):
        q = rest_of(recording)
        if q is None:
            continue
        q = q.copy()
        free = [recording.robot.model.joints[joint].idx_q for joint in free_bodies(recording.robot)]
        # The points of several bodies have no offset in common.
        turn = pin.Quaternion(np.array(q[3:7])).matrix() * (len(free) == 1)
        for start in free:
            q[start : start + 3] /= scale
        posture = Posture(recording.robot, q)
        points = np.array(
            [posture.frame(entry.frame).act(np.array(entry.at, dtype=float)) for entry in contacts]
        )
        gaps = (points - origin) @ normal
        low = gaps <= gaps.min() + CARRYING
        for point, gap in zip(points[low], gaps[low], strict=True):
            x, y = (point - origin) @ axes[:, :2]
            rows.append([1.0, x, y, *(normal @ turn)])
            heights.append(gap)
            groups.append(number)
    count = len(set(groups))
    if not count:
        note = "no recording comes to rest, so the floor's height is not determined"
        return FloorFit(np.zeros(6), np.full(6, np.inf), 0, (axes, origin), (note,))
    values, sigma = _robust_plane(np.array(rows), np.array(heights), np.array(groups))
    return FloorFit(values, sigma, count, (axes, origin))


def rest_of(recording: Recording) -> np.ndarray | None:
    """(nq,) the median configuration of the last rest of a recording, if it has one.

    Medians, since single samples may be far off (a marker taken for another).
    """
    for run in RUNS:
        if (found := _last_rest(recording, *run)) is not None:
            return found
    return None


def _last_rest(recording: Recording, fewest: int, shortest: float) -> np.ndarray | None:
    """The same of runs of so many samples and so long a time [s]."""
    t, q, model = recording.t, recording.q, recording.robot.model
    for end in range(len(t), fewest - 1, -1):
        before = int(np.searchsorted(t, t[end - 1] - shortest, side="right")) - 1
        begin = min(end - fewest, before)
        if begin < 0:
            return None
        base = q[(begin + end) // 2]
        ways = np.array([pin.difference(model, base, row) for row in q[begin:end]])
        parts = np.array([np.median(own, axis=0) for own in np.array_split(ways, 3)])
        # x₋ − 2 x + x₊ of noise σ has √6 σ, whatever the speed.
        bends = np.median(np.abs(np.diff(ways, n=2, axis=0)), axis=0)
        noise = bends / (MEDIAN_TO_SIGMA * np.sqrt(6.0))
        spread = MEDIAN_OVER_MEAN * noise * np.sqrt(2.0 * len(parts) / len(ways))
        slow = STILL * (t[end - 1] - t[begin]) / len(parts)
        if (np.ptp(parts, axis=0) <= slow + NOISY * spread).all():
            return np.asarray(pin.integrate(model, base, np.median(ways, axis=0)))
    return None


def _robust_plane(
    rows: np.ndarray, heights: np.ndarray, groups: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Huber's weights; standard deviations by the jackknife over recordings."""
    size = np.array([1.0, *np.maximum(rows[:, 1:3].std(axis=0), NARROW), 1.0, 1.0, 1.0])
    scaled = rows / size
    basis = _determined(scaled)

    def fitted(kept: np.ndarray) -> np.ndarray:
        weights = np.ones(int(kept.sum()))
        found = np.zeros(basis.shape[1])
        for _ in range(5):
            root = np.sqrt(weights)
            own = (scaled[kept] @ basis) * root[:, None]
            found = np.linalg.lstsq(own, heights[kept] * root, rcond=None)[0]
            left = np.abs(heights[kept] - scaled[kept] @ basis @ found)
            typical = max(1.5 * float(np.median(left)), SAME)
            weights = np.minimum(1.0, 2.0 * typical / np.maximum(left, NONZERO))
        return np.asarray(basis @ found / size)

    values = fitted(np.ones(len(heights), bool))
    names = np.unique(groups)
    if len(names) < FEWEST_RESTS:
        return values, np.full(6, np.inf)
    others = np.array([fitted(groups != name) for name in names])
    count = len(names)
    sigma = np.sqrt((count - 1) / count * ((others - others.mean(axis=0)) ** 2).sum(axis=0))
    sigma[1.0 - (basis**2).sum(axis=1) > UNDETERMINED_SHARE] = np.inf
    return values, sigma


def _determined(rows: np.ndarray) -> np.ndarray:
    """(6, k) orthonormal directions of the unknowns that the rests distinguish.

    What height explains is not laid on slopes, and what these explain not on the offset.
    """
    basis = [np.eye(6)[:1]]
    for own in (slice(1, 3), slice(3, 6)):
        known = rows @ np.vstack(basis).T
        left = rows[:, own] - known @ np.linalg.lstsq(known, rows[:, own], rcond=None)[0]
        _, values, ways = np.linalg.svd(left, full_matrices=False)
        determined = values > UNDETERMINED_FLOOR * np.sqrt(len(rows))
        found = np.zeros((int(determined.sum()), 6))
        found[:, own] = ways[determined]
        basis.append(found)
    return np.vstack(basis).T
