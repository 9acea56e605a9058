"""A trajectory to its npz file and back. Nothing is pickled or run.

::

    t, q, v, impact_times, status     readable by numpy alone
    path_...                          the steps between the samples
    scene                             UTF-8 text of a scene file, with the URDFs in it
    record                            UTF-8 JSON: impacts, rests and how the motion ended
    numbers                           the arrays of the impacts, one after the other
"""

from __future__ import annotations

import copy
import dataclasses
import json
import os
from typing import Any, TypeVar

import numpy as np

from ...errors import ImpulsekitError, InputError
from ...files import (
    ENDINGS,
    as_file_error,
    checked_output,
    open_plain_file,
    read_npz,
    replaced_file,
)
from ...robot import Robot
from ...robot.arrays import read_only
from ...scene import Scene
from ...scene.motion import MotionSettings
from .impact_arrays import impacts_of, packed_impacts
from .path import Path
from .sampled import Rest, SampledMotion
from .status import MotionStatus

__all__ = ["load_motion", "save_motion"]

# Of the file that ``save`` writes.
FORMAT = 4

Motion = TypeVar("Motion", bound=SampledMotion)


def save_motion(motion: SampledMotion, path: str | os.PathLike[str]) -> None:
    """See ``Trajectory.save``."""
    path = checked_output(path, "motion", *ENDINGS["motion"])
    text, reason = _scene_text(motion.scene)
    impacts, numbers = packed_impacts(motion.scene, motion.impacts)
    record = {
        "format": FORMAT,
        "without_scene": reason,
        "impacts": impacts,
        "rests": [[rest.contact, rest.start, rest.end] for rest in motion.rests],
        "status": motion.status.name,
        "settings": dataclasses.asdict(motion.settings),
        "detail": motion.detail,
        "steps": motion.steps,
        "evaluations": motion.evaluations,
    }
    arrays: dict[str, Any] = {
        "t": motion.t,
        "q": motion.q,
        "v": motion.v,
        "impact_times": np.array([time for time, _ in motion.impacts]),
        "status": np.array(motion.status.name),
        "scene": _bytes_of(text),
        "record": _bytes_of(json.dumps(record)),
        "numbers": numbers,
        **motion._path.arrays(),
    }
    with replaced_file(path) as file:
        np.savez_compressed(file, **arrays)


def load_motion(kind: type[Motion], path: str | os.PathLike[str], scene: Scene | None) -> Motion:
    """See ``Trajectory.load``."""
    name, arrays = os.fspath(path), _read_arrays(path)
    try:
        record, text = _record_of(arrays["record"]), _text_of(arrays["scene"])
        if record["format"] != FORMAT:
            raise InputError(f"{name}: expected format {FORMAT}, got {record['format']}")
        if scene is None and not text:
            raise InputError(
                f"{name} comes without its scene ({record['without_scene']}); give it: "
                "Trajectory.load(path, scene=...)"
            )
        scene = _scene_of(text, name) if scene is None else scene
        _check_arrays(arrays, scene, name)
        motion = kind(
            scene,
            arrays["t"],
            Path.of_arrays(scene.robot.model, arrays),
            impacts_of(scene, record["impacts"], arrays["numbers"]),
            tuple(Rest(str(c), float(a), float(b)) for c, a, b in record["rests"]),
            MotionStatus[record["status"]],
            MotionSettings(**record["settings"]),
            detail=str(record["detail"]),
            steps=int(record["steps"]),
            evaluations=int(record["evaluations"]),
        )
        # Between the samples the steps count, at them the very numbers that were saved.
        motion.q, motion.v = read_only(arrays["q"]), read_only(arrays["v"])
        return motion
    except ImpulsekitError:
        raise
    except KeyError as error:
        raise InputError(f"{name} holds no trajectory: {error} is missing in it") from None
    except (ValueError, TypeError, IndexError, AttributeError, RecursionError) as error:
        raise InputError(f"{name} holds no trajectory: {error}") from None


def _scene_text(scene: Scene) -> tuple[str, str]:
    """The scene as the text of a scene file that needs no other; or "" and why there is none."""
    from ...scenefile import dump_scene

    parts = [
        dataclasses.replace(
            part,
            path=None,
            # Meshes are still where they were.
            package_dirs=part.package_dirs
            if part.path is None
            else (os.path.dirname(part.path), *part.package_dirs),
        )
        for part in scene.robot.parts
    ]
    whole = copy.copy(scene)
    object.__setattr__(whole, "robot", Robot(scene.robot.model, parts, scene.robot.name))
    try:
        return dump_scene(whole), ""
    except InputError as error:
        return "", str(error)


def _scene_of(text: str, source: str) -> Scene:
    """The scene that ``_scene_text`` wrote.

    Raises:
        SceneFileError: the text is no scene.
    """
    from ...scenefile.read import read_scene

    return read_scene(text, f"{source}: the scene in it").scene


def _read_arrays(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """All arrays of an npz file of a trajectory; nothing is unpickled.

    Raises:
        InputError: no such file, or one too large for memory.
        OSError: it cannot be read.
    """
    name = os.fspath(path)
    with as_file_error(name), open_plain_file(name) as stream:
        try:
            return read_npz(stream)
        except ValueError as error:
            raise InputError(f"{name} holds no trajectory: {error}") from None


def _text_of(array: np.ndarray) -> str:
    """The text in an array of bytes.

    Raises:
        ValueError: it holds none.
    """
    if array.dtype != np.uint8 or array.ndim != 1:
        raise ValueError("its text is no array of bytes")
    return array.tobytes().decode("utf-8")


def _bytes_of(text: str) -> np.ndarray:
    """An array of bytes that holds a text."""
    return np.frombuffer(text.encode("utf-8"), dtype=np.uint8)


def _record_of(array: np.ndarray) -> dict[str, Any]:
    """The JSON in an array of bytes.

    Raises:
        ValueError: it holds none.
    """
    record = json.loads(_text_of(array))
    if not isinstance(record, dict):
        raise ValueError("its record is no table")
    return record


def _check_arrays(arrays: dict[str, np.ndarray], scene: Scene, source: str) -> None:
    """Check that the arrays of a file are a motion of the scene's robot.

    Raises:
        InputError: they are not.
    """
    robot, samples = scene.robot, len(arrays["t"])
    pieces, rests = len(arrays["path_times"]), len(arrays["path_rests_end"])
    size, dry = robot.nq + robot.nv, arrays["path_dry"].size // max(rests, 1)
    for key, shape, kind in (
        ("t", (samples,), float),
        ("q", (samples, robot.nq), float),
        ("v", (samples, robot.nv), float),
        ("path_times", (pieces, 4), float),
        ("path_before", (pieces, size), float),
        ("path_shape", (pieces, 7, size), float),
        ("path_footing", (pieces,), int),
        ("path_rests", (arrays["path_rests"].size,), float),
        ("path_rests_end", (rests,), int),
        ("path_dry", (rests, dry) if rests else arrays["path_dry"].shape, int),
        ("path_controls", (rests, arrays["path_controls"].size // max(rests, 1)), float),
        ("path_end", (1 + size,), float),
    ):
        array = arrays[key]
        if array.shape != shape or array.dtype != np.dtype(kind) or not samples:
            raise InputError(
                f'{source}: "{key}" holds {array.dtype} of shape {array.shape}; for this '
                f"robot, expected {np.dtype(kind)} of shape {shape}"
            )
    starts, ends = arrays["path_times"][:, 0], arrays["path_times"][:, 1]
    resting_state, last = arrays["path_footing"], arrays["path_rests_end"]
    if not (np.isfinite(arrays["t"]).all() and np.isfinite(arrays["path_times"]).all()):
        raise InputError(f"{source} holds times that are not finite")
    if not ((starts <= ends).all() and (np.diff(starts) >= 0.0).all()):
        raise InputError(f"{source} holds steps that are not in order of time")
    inside = not len(resting_state) or (resting_state.min() >= 0 and resting_state.max() < rests)
    rising = (np.diff(last) >= 0).all() and (not rests or last[-1] == arrays["path_rests"].size)
    if not (inside and rising):
        raise InputError(f"{source} holds rests that are none of its steps'")
