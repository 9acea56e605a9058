"""The [batch] table of a scene file.

::

    [batch]
    samples = 100000
    seed = 7                       # 0 by default
    outputs = ["v_after", "energy_change", "contact_impulses"]
    chunk = 16384                  # rows that are drawn, solved and written together
    motion = true                  # motions by the file's table [motion]; else impacts alone

    [[batch.vary]]                 # a Variation: its fields are the keys
    what = "configuration"
    low = -0.1
    high = 0.1

    [[batch.vary]]
    what = "impulse"
    of = "blow"
    distribution = "normal"
    mean = 1.0
    deviation = 0.2
"""

from __future__ import annotations

import os
import tomllib
from typing import Any

import pydantic

from ...errors import ImpulsekitError
from ...errors.calls import public
from ...files import as_file_error, open_plain_file
from ...scene.motion import MotionSettings
from ...scenefile import load_scene
from ...scenefile.faults import Faults, tuples_of
from ...scenefile.vocabulary import STRICT, model_of
from .study import Study, Variation


class _Batch(pydantic.BaseModel):
    model_config = STRICT
    samples: int
    seed: int = 0
    motion: bool = False
    outputs: tuple[str, ...] | None = None
    chunk: int | None = None
    vary: tuple[Any, ...] = ()


@public
def load_study(path: str | os.PathLike[str]) -> Study:
    """Load a study from a scene file with a [batch] table.

    Raises:
        SceneFileError: all errors of the scene, or all of the table, are reported at once.

    Example:
        >>> study = load_study("examples/landing_study.toml")
        >>> study.samples
        20000
    """
    file, faults = load_scene(path), Faults()
    with as_file_error(path), open_plain_file(path) as stream:
        raw = tomllib.loads(stream.read().decode("utf-8-sig").replace("\r\n", "\n")).get("batch")
    if raw is None:
        faults.add("the table [batch] is missing: how many samples, and what varies?")
        raise faults.error(file.path)
    settings = faults.validated(_Batch, tuples_of(raw), "batch")
    vary = []
    for i, entry in enumerate(settings.vary if settings is not None else ()):
        place = f"batch.vary[{i}]"
        model = faults.validated(model_of(Variation), entry, place)
        if model is None:
            continue
        values = {name: getattr(model, name) for name in model.model_fields_set}
        try:
            vary.append(Variation(**values))
        except ImpulsekitError as error:
            faults.add_error(place, error)
    if not faults and settings is not None:
        try:
            return Study(
                file.scene,
                file.q,
                file.v,
                settings.samples,
                settings.seed,
                vary,
                settings.outputs,
                settings.chunk,
                (file.motion or MotionSettings()) if settings.motion else None,
            )
        except ImpulsekitError as error:
            faults.add_error("batch", error)
    raise faults.error(file.path)
