"""Orders of quaternions that recordings state wrongly, by the floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from ..robot.placing import Posture
from ..scene import Contact, Scene
from .active_contacts import ClosingContacts
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


def check_quaternion_order(recordings: Sequence[Recording], scene: Scene, who: str) -> None:
    """Refuse attitudes that drive a free body through the floor, if another order does not.

    Raises:
        InputError: the order of the quaternion looks as if it were the other one.
    """
    planes = [
        entry for entry in scene.contacts if isinstance(entry, Contact) and entry.against == "world"
    ]
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
