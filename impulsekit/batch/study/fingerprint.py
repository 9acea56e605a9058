"""All that a row of a study depends on, as plain data that is the same in every process."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib.metadata
import pickle
import platform
import types
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...errors import InputError, a_thing
from ...robot import Robot
from ...robot.geometry import geometry_ids, shape_content
from ...scene import Collision, Scene

# Distributions whose numbers are in the rows.
_PACKAGES = ("numpy", "pin", "coal")


def versions() -> dict[str, str]:
    """Return the versions of all that computes rows."""
    from ... import __version__

    found = {"impulsekit": __version__, "python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def robot_digest(robot: Robot) -> str:
    """Digest every field of the model, and of the links, whose masses may vary."""
    digest = hashlib.sha256(robot.model.saveToString().encode())
    for link in robot.links:
        digest.update(f"{link.name} {link.frame_id} {link.joint_id} {link.mass.hex()}".encode())
        digest.update(np.ascontiguousarray(link.com_in_joint, dtype=float).tobytes())
        digest.update(np.ascontiguousarray(link.inertia_in_joint_axes, dtype=float).tobytes())
    return digest.hexdigest()


def geometry_digest(scene: Scene) -> str:
    """Digest the shapes that collide, meshes with their corners; "" where none can.

    Geometry is read only where the scene asks for it.
    """
    names = [
        name
        for entry in scene.contacts
        if isinstance(entry, Collision)
        for name in (entry.first, entry.other)
    ]
    if not names:
        return ""
    robot = scene.robot
    digest = hashlib.sha256()
    for name in names:
        for index in geometry_ids(robot, name)[0]:
            item = robot.collision_model.geometryObjects[index]
            digest.update(f"{name}\0{item.name}\0{item.parentFrame}\0{item.parentJoint}\0".encode())
            digest.update(item.placement.homogeneous.tobytes())
            for part in shape_content(item):
                digest.update(part + b"\0")
    return digest.hexdigest()


def described(value: Any, what: str) -> Any:
    """Return a value as JSON-ready data in which it differs from every other.

    Floats keep all their digits. A function is described by its code, with defaults and what it
    closes over; globals that it reads are not seen.

    Raises:
        InputError: it cannot be compared with others, such as an object that does not pickle.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return float(value).hex()
    if isinstance(value, np.ndarray):
        return {"array": list(value.shape), "values": described(value.ravel().tolist(), what)}
    if isinstance(value, np.generic):
        return described(value.item(), what)
    if isinstance(value, list | tuple):
        return [described(item, what) for item in value]
    if isinstance(value, Mapping):
        return {str(key): described(item, what) for key, item in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        return {"kind": type(value).__qualname__, **described(fields, what)}
    if isinstance(value, types.FunctionType):
        parts = (value.__defaults__, value.__kwdefaults__, value.__code__)
        cells = [cell.cell_contents for cell in value.__closure__ or ()]
        name = f"{value.__module__}.{value.__qualname__}"
        return {"function": name, "parts": described(parts, what), "cells": described(cells, what)}
    if isinstance(value, types.CodeType):
        constants = described(value.co_consts, what)
        return {"code": value.co_code.hex(), "names": value.co_names, "constants": constants}
    if isinstance(value, types.MethodType):
        return {"method": described([value.__func__, value.__self__], what)}
    if isinstance(value, frozenset):
        return sorted(map(repr, value))
    try:
        return {"pickle": hashlib.sha256(pickle.dumps(value, protocol=4)).hexdigest()}
    except Exception:  # pickle raises what the object's own methods raise
        raise InputError(
            f"{what}: a study cannot compare {a_thing(value)} with another when it resumes; "
            "give a function, or an object that pickles"
        ) from None
