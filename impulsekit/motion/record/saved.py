"""A trajectory to its file and back; ``archive`` says what stands in it."""

from __future__ import annotations

import dataclasses
import json
import os
from typing import Any, TypeVar

import numpy as np

from ...errors import ImpulsekitError, InputError
from ...files import replaced_file
from ...robot.arrays import read_only
from ...scene import Scene
from ...scene.motion import MotionSettings
from .archive import (
    bytes_of,
    check_arrays,
    read_arrays,
    record_of,
    scene_of,
    scene_text,
    text_of,
)
from .impact_arrays import impacts_of, packed_impacts
from .path import Path
from .sampled import Rest, SampledMotion
from .status import MotionStatus

__all__ = ["load_motion", "save_motion"]

# Of the file that ``save`` writes; 1 held a pickle, 2 nothing of what rested, 3 another path.
FORMAT = 4

Motion = TypeVar("Motion", bound=SampledMotion)


def save_motion(motion: SampledMotion, path: str | os.PathLike[str]) -> None:
    """See ``Trajectory.save``."""
    text, reason = scene_text(motion.scene)
    impacts, numbers = packed_impacts(motion.impacts)
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
        "scene": bytes_of(text),
        "record": bytes_of(json.dumps(record)),
        "numbers": numbers,
        **motion._path.arrays(),
    }
    with replaced_file(path) as file:
        np.savez_compressed(file, **arrays)


def load_motion(kind: type[Motion], path: str | os.PathLike[str], scene: Scene | None) -> Motion:
    """See ``Trajectory.load``."""
    name, arrays = os.fspath(path), read_arrays(path)
    try:
        record, text = record_of(arrays["record"]), text_of(arrays["scene"])
        if record["format"] != FORMAT:
            raise InputError(f"{name}: expected format {FORMAT}, got {record['format']}")
        if scene is None and not text:
            raise InputError(
                f"{name} comes without its scene ({record['without_scene']}); give it: "
                "Trajectory.load(path, scene=...)"
            )
        scene = scene_of(text, name) if scene is None else scene
        check_arrays(arrays, scene, name)
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
