"""The floor of recordings: its height and tilt under bodies at rest, and attitudes that miss it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..geometry.axes import contact_axes
from ..robot.placing import Posture
from ..scene import Contact, Scene
from ..tolerances import NONZERO
from .active_contacts import ClosingContacts
from .free_fall import free_bodies, has_one_free_body
from .recording import Recording
from .recording_checks import OTHER_ORDERS
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
# Recordings looked at, and the lowest samples of each, whose median stands against outliers.
MOST_RECORDINGS, LOWEST = 24, 12
# A reading is wrong if it pushes contacts below the floor by this share of their reach from the
# body's origin, and another puts them within a quarter of that of the floor. Right readings of a
# cube: .02 at most of 120 tosses with a scale 2 % off; wrong: .13. Floors that are off give every
# reading the same depth. Root mean squares over recordings: of a cube, half the rests in
# the wrong reading are rests on a face again.
DEEP, NEAR = 0.05, 0.25


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
    """Fit the gaps of the points that carry bodies at rest, g = h + a x + b y + n·R d.

    ``scale``: recorded lengths over true ones. Bodies that lie on several faces determine d.
    """
    contacts = _on_planes(scene)
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


def _on_planes(scene: Scene) -> list[Contact]:
    """Return the contacts with planes of the world."""
    return [c for c in scene.contacts if isinstance(c, Contact) and c.against == "world"]


def rest_of(recording: Recording) -> np.ndarray | None:
    """Return the (nq,) median configuration of the last rest of a recording, if it has one.

    Medians, since single samples may be far off (a marker taken for another).
    """
    for run in RUNS:
        if (found := _last_rest(recording, *run)) is not None:
            return found
    return None


def _last_rest(recording: Recording, fewest: int, shortest: float) -> np.ndarray | None:
    """Return the same of runs of so many samples and so long a time [s]."""
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
    """Fit with Huber's weights; standard deviations by the jackknife over recordings."""
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
    """Return (6, k) orthonormal directions of the unknowns that the rests distinguish.

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


def check_quaternion_order(recordings: Sequence[Recording], scene: Scene, who: str) -> None:
    """Refuse attitudes that drive a free body through the floor, if another order does not.

    Raises:
        InputError: the order of the quaternion looks as if it were the other one.
    """
    planes = _on_planes(scene)
    if not planes or not has_one_free_body(scene.robot):
        return
    looked_at = recordings[:: max(1, len(recordings) // MOST_RECORDINGS)]
    contacts = ClosingContacts(scene.replace(contacts=planes, constraints=(), controlled=()))
    lowest = [_lowest(each, np.array(planes[0].normal)) for each in looked_at]
    deep = _root_mean_square(np.minimum(_gaps(contacts, lowest, (0, 1, 2, 3)), 0.0))
    posture = Posture(scene.robot, lowest[0][0])
    points = [posture.frame(entry.frame).act(np.array(entry.at, dtype=float)) for entry in planes]
    reach = max(float(np.linalg.norm(point - lowest[0][0][:3])) for point in points)
    for order in OTHER_ORDERS if deep > DEEP * reach else ():
        if _root_mean_square(_gaps(contacts, lowest, order)) < NEAR * deep:
            raise InputError(
                f"{who}: as the quaternions are read, contacts lie {1e3 * deep:.3g} mm below the "
                "floor, and in the other order they meet it: the order looks as if it were the "
                "other one, xyzw or wxyz"
            )


def _lowest(recording: Recording, normal: np.ndarray) -> np.ndarray:
    """Return (n, nq) samples of a recording in which the body's origin is lowest."""
    return recording.q[np.argsort(recording.q[:, :3] @ normal, kind="stable")[:LOWEST]]


def _gaps(
    contacts: ClosingContacts, lowest: list[np.ndarray], order: tuple[int, ...]
) -> np.ndarray:
    """Return (recordings,) median gap of the lowest contact, with quaternions in an order."""
    places = [0, 1, 2, *(3 + k for k in order)]
    still = np.zeros(contacts.nv)
    medians = []
    for rows in lowest:
        read = np.hstack([rows[:, places], rows[:, 7:]])
        medians.append(np.median([contacts.gaps(q, still).min() for q in read]))
    return np.array(medians)


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
