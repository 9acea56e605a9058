"""Recorded attitudes held against the floor: a quaternion read in the wrong order pushes corners
through it. Without angular velocity nothing else tells: any order gives a smooth rotation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..scene import Contact, Scene
from .free_fall import has_one_free_body
from .recording import Recording

__all__ = ["check_quaternion_order"]

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
    lowest = [_lowest(each, np.array(planes[0].normal)) for each in looked_at]
    gaps, reach = _gaps(scene, planes, lowest, (0, 1, 2, 3))
    deep = _root_mean_square(np.minimum(gaps, 0.0))
    if not deep > DEEP * reach:
        return
    for order in READINGS:
        others, _ = _gaps(scene, planes, lowest, order)
        if _root_mean_square(others) < NEAR * deep:
            raise InputError(
                f"{who}: as the quaternions are read, contacts lie {1e3 * deep:.3g} mm below the "
                "floor, and in the other order they meet it: the order looks as if it were the "
                "other one, xyzw or wxyz"
            )


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
