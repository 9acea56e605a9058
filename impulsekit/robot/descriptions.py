"""Robots by the names of the package robot_descriptions, which fetches their files."""

from __future__ import annotations

import importlib

from ..errors import InputError, MissingExtraError, UnknownNameError, shown

__all__ = ["files_of_description"]


def files_of_description(name: str) -> tuple[str | None, str, list[str]]:
    """The URDF or else the MJCF of a robot, and the folders of its meshes.

    Raises:
        As ``Robot.from_description``.
    """
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
    folders = [getattr(module, key) for key in ("PACKAGE_PATH", "REPOSITORY_PATH")
               if hasattr(module, key)]  # fmt: skip
    return getattr(module, "URDF_PATH", None), getattr(module, "MJCF_PATH", ""), folders
