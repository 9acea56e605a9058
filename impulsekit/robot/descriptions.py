"""Robots by the names of the package robot_descriptions, which fetches their files."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from ..errors import InputError, MissingExtraError, UnknownNameError, shown

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["robot_from_description"]


def robot_from_description(name: str, root: str | None) -> Robot:
    """See ``Robot.from_description``."""
    from .robot import Robot

    with MissingExtraError.unless(
        "robot_descriptions", "descriptions", "reading robots by description"
    ):
        from robot_descriptions import DESCRIPTIONS
    if name not in DESCRIPTIONS:
        raise UnknownNameError.among("robot description", str(name), sorted(DESCRIPTIONS))
    try:
        module = importlib.import_module(f"robot_descriptions.{name}")
    except Exception as error:  # git and the network fail in many ways
        reason = shown(" ".join(str(error).split()), 200)
        raise InputError(
            f'robot description "{name}": its files cannot be fetched: {reason}'
        ) from None
    if hasattr(module, "URDF_PATH"):
        folders = [getattr(module, key) for key in ("PACKAGE_PATH", "REPOSITORY_PATH")
                   if hasattr(module, key)]  # fmt: skip
        return Robot.from_urdf(module.URDF_PATH, root or "fixed", package_dirs=folders)
    return Robot.from_mjcf(module.MJCF_PATH, root)
