"""The arrays of a store: what each holds, and a store with no row written."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from ...impact.status import Status
from ...motion.record.status import MotionStatus
from ...motion.simulate import chosen_settings
from .study import Study

# The status of a row that was never written; no Status, and none of a kernel's codes.
UNWRITTEN = -128
UNITS = {
    "v_after": "rad/s, m/s",
    "dv": "rad/s, m/s",
    "generalized_impulse": "N m s, N s",
    "energy_change": "J",
    "contact_impulses": "N s",
    "constraint_impulses": "N s, N m s",
    "normal_components": "m/s, rad/s, N s, N m s",
    "gaps": "m, rad",
    "q": "rad, m",
    "v": "rad/s, m/s",
    "end": "s",
    "q_end": "rad, m",
    "v_end": "rad/s, m/s",
    "impact_count": "1",
    "q_samples": "rad, m",
    "v_samples": "rad/s, m/s",
}


def unwritten_rows(study: Study) -> tuple[Any, dict[str, Any]]:
    """An ``xarray.Dataset`` whose rows are all unwritten, and how Zarr encodes its arrays."""
    import dask.array as da
    import xarray as xr
    from numcodecs import CRC32

    robot = study.scene.robot
    data, encoding = {}, {}
    for name, (dims, shape, dtype, attributes) in arrays_of(study).items():
        fill = UNWRITTEN if name == "status" else np.nan
        # Only laid out, never computed: one piece, however many chunks it will have.
        empty = da.full((study.samples, *shape), fill, chunks=-1, dtype=dtype)
        data[name] = (dims, empty, attributes)
        encoding[name] = {
            "chunks": (min(study.rows_of_chunk, study.samples), *shape),
            # Digits of floats are noise to a compressor.
            "compressors": None,
            # A chunk that was changed on disk is an error wherever it is read.
            "filters": [CRC32()],
            "_FillValue": dtype(fill),
        }
    coordinates = {
        "dof": _dof_names(robot),
        "axis": ["x", "y", "z"],
        "contact": list(study.scene.entry_names("contacts")),
        "link": list(study.scaled_links),
    }
    used = {dim for dims, *_ in data.values() for dim in dims}
    kept = {name: values for name, values in coordinates.items() if name in used}
    statuses = Status if study.motion is None else MotionStatus
    codes = {code.name: code.code for code in statuses}
    dataset = xr.Dataset(
        data,
        coords=kept,
        attrs={
            "title": f"impulsekit study of {robot.name}",
            "study": json.dumps(study.describe(), sort_keys=True),
            "status": json.dumps({**codes, "UNWRITTEN": UNWRITTEN}),
        },
    )
    return dataset, encoding


def arrays_of(study: Study) -> dict[str, tuple]:
    """By array: dimensions, shape of a row, type, attributes."""
    robot = study.scene.robot
    dims = {
        "energy_change": (),
        "contact_impulses": ("contact", "axis"),
        "normal_components": ("contact", "normal_component"),
        "gaps": ("contact",),
        "constraint_impulses": ("constraint_row",),
        "q": ("q_entry",),
        "v": ("dof",),
        "end": (),
        "impact_count": (),
        "q_end": ("q_entry",),
        "q_samples": ("time", "q_entry"),
        "v_samples": ("time", "dof"),
    }
    found: dict[str, tuple] = {
        "status": (("row",), (), np.int8, {"meaning": "see the attribute status"})
    }
    for name in study.names:
        own = ("row", *dims.get(name, ("dof",)))
        found[name] = (own, _shape_of(study, name), float, {"units": UNITS[name]})
    whats = {one.what for one in study.vary}
    if "configuration" in whats:
        found["q"] = (("row", "q_entry"), (robot.nq,), float, {"units": UNITS["q"]})
    if "velocity" in whats:
        found["v"] = (("row", "dof"), (robot.nv,), float, {"units": UNITS["v"]})
    if whats & {"impulse", "direction"}:
        width = sum(len(one.values) for one in study.scene.impulses)
        units = {"units": "N s, N m s", "order": "as in the scene, entry after entry"}
        found["impulses"] = (("row", "impulse_entry"), (width,), float, units)
    count = (len(study.scene.contacts),)
    if "mass" in whats:
        units = {"units": "1", "meaning": "factors on mass and inertia of links"}
        found["masses"] = (("row", "link"), (len(study.scaled_links),), float, units)
    for name in ("restitution", "friction"):
        if name in whats:
            found[name] = (("row", "contact"), count, float, {"units": "1"})
    return found


def _shape_of(study: Study, name: str) -> tuple[int, ...]:
    """Of one row of an output."""
    from ..shapes import shape_of

    robot = study.scene.robot
    samples = 0 if study.motion is None else len(chosen_settings(study.motion, None, None, {})[1])
    own: dict[str, tuple[int, ...]] = {
        "end": (),
        "impact_count": (),
        "q_end": (robot.nq,),
        "q_samples": (samples, robot.nq),
        "v_samples": (samples, robot.nv),
    }
    return own[name] if name in own else shape_of(study.scene, name)


def _dof_names(robot: Any) -> list[str]:
    names = []
    for name, joint in zip(list(robot.model.names)[1:], list(robot.model.joints)[1:], strict=True):
        names.extend([name] if joint.nv == 1 else [f"{name}[{k}]" for k in range(joint.nv)])
    return names
