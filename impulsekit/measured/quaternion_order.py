"""Orders of quaternions that recordings do not state, or state wrongly, by floor and momentum."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import comb

import numpy as np

from ..errors import InputError
from ..robot import Robot
from ..robot.placing import Posture
from ..scene import Contact, Scene
from .active_contacts import ClosingContacts
from .found_impacts import FoundImpact
from .free_fall import has_one_free_body
from .recording import Recording
from .recording_checks import OTHER_ORDERS

# Recordings looked at, and the lowest samples of each, whose median stands against outliers.
MOST_RECORDINGS, LOWEST = 24, 12
# A reading is wrong if it pushes contacts below the floor by this share of their reach from the
# body's origin, and another puts them within a quarter of that of the floor. Right readings of a
# cube: .02 at most of 120 tosses with a scale 2 % off; wrong: .13. Floors that are off give every
# reading the same depth. Root mean squares over recordings: of a cube, half the rests in
# the wrong reading are rests on a face again.
DEEP, NEAR = 0.05, 0.25
# A jump is better explained in one order than in another if its balance is so many times as
# probable. Of 120 tosses of a real cube 160 jumps are so in the right order, 23 in the wrong one.
BETTER = 10.0
# Probability that two readings that explain jumps alike come out as far apart: an order is wrong
# below the first, and right below the second, since its name speaks for it.
WRONG, RIGHT = 1e-3, 0.05
# The note where no order explains more than the others.
ORDER_UNKNOWN = (
    "nothing in the recordings shows whether quaternions are in the order that was stated: no "
    "angular velocity, no contact with a floor that another order misses, and too few impacts"
)
# Times that differ by less than so many of their sigmas are one.
SAME_TIME = 3.0


def check_quaternion_order(recordings: Sequence[Recording], scene: Scene, who: str) -> bool:
    """Refuse attitudes that drive a free body through the floor, if another order does not.

    Returns:
        Whether the floor shows that the order is right: the other orders drive the body through.

    Raises:
        InputError: the order of the quaternion looks as if it were the other one.
    """
    planes = [
        entry for entry in scene.contacts if isinstance(entry, Contact) and entry.against == "world"
    ]
    if not planes or not has_one_free_body(scene.robot):
        return False
    looked_at = recordings[:: max(1, len(recordings) // MOST_RECORDINGS)]
    contacts = ClosingContacts(scene.replace(contacts=planes, constraints=(), controlled=()))
    lowest = [_lowest(each, np.array(planes[0].normal)) for each in looked_at]
    deep = _root_mean_square(np.minimum(_gaps(contacts, lowest, (0, 1, 2, 3)), 0.0))
    others = [_gaps(contacts, lowest, order) for order in OTHER_ORDERS]
    posture = Posture(scene.robot, lowest[0][0])
    points = [posture.frame(entry.frame).act(np.array(entry.at, dtype=float)) for entry in planes]
    reach = max(float(np.linalg.norm(point - lowest[0][0][:3])) for point in points)
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
        None if the order is right, else what to note.

    Raises:
        InputError: the order of the quaternion looks as if it were the other one.
    """
    starts = quaternions_of(recordings[0].robot)
    pairs = [pair for pair in zip(impacts, recordings, strict=True) if pair[0]]
    pairs = pairs[:: max(1, len(pairs) // MOST_RECORDINGS)]
    known = True
    for order in OTHER_ORDERS:
        found = find([_reordered(each, starts, order) for _, each in pairs])
        both = [_explained(own, there) for (own, _), there in zip(pairs, found, strict=True)]
        ours, others = (sum(each) for each in zip(*both, strict=True))
        if _by_chance(others, ours) < WRONG:
            raise InputError(
                f"{who}: as the quaternions are read, {others} jumps balance momentum worse than "
                f"in another order, and {ours} better: the order looks as if it were the other "
                "one, xyzw or wxyz"
            )
        known = known and _by_chance(ours, others) < RIGHT
    return None if known else ORDER_UNKNOWN


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
    contacts: ClosingContacts, lowest: list[np.ndarray], order: tuple[int, ...]
) -> np.ndarray:
    """(recordings,) median gap of the lowest contact, with quaternions in an order."""
    places = [0, 1, 2, *(3 + k for k in order)]
    still = np.zeros(contacts.nv)
    medians = []
    for rows in lowest:
        read = np.hstack([rows[:, places], rows[:, 7:]])
        medians.append(np.median([contacts.gaps(q, still).min() for q in read]))
    return np.array(medians)


def _root_mean_square(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
