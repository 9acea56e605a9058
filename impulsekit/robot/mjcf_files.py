"""MJCF as MuJoCo's compiler reads it: out of a file, a text or what is compiled already."""

from __future__ import annotations

import os
from typing import Any

from ..errors import MissingExtraError, MjcfError, a_thing, shown
from ..files import read_text_file, reason_of

__all__ = ["read_mjcf"]


def read_mjcf(source: Any) -> tuple[Any, str | None]:
    """The ``mujoco.MjModel`` of a file, of MJCF text or as it is, and the path.

    Raises:
        MjcfError: MuJoCo refuses it; the sentence holds its reason.
        MissingExtraError: the package mujoco is not installed.
    """
    with MissingExtraError.unless("mujoco", "mjcf", "reading MJCF"):
        import mujoco
    if isinstance(source, mujoco.MjModel):
        return source, None
    if isinstance(source, mujoco.MjSpec):
        return _compiled(source.compile, "the MjSpec"), None
    if isinstance(source, str) and source.lstrip().startswith("<"):
        return _compiled(lambda: mujoco.MjModel.from_xml_string(source), "MJCF text"), None
    if not isinstance(source, str | os.PathLike):
        raise MjcfError(
            f"from_mjcf takes a path, MJCF text or a mujoco.MjModel, got {a_thing(source)}",
            source="",
            element="",
        )
    path = os.fspath(source)
    try:
        read_text_file(path)
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "the path holds a NUL"
        raise MjcfError(f"{shown(path, 200)}: {reason}", source=path, element="") from None
    return _compiled(lambda: mujoco.MjModel.from_xml_path(path), path), os.path.abspath(path)


def _compiled(compile_it: Any, source: str) -> Any:
    try:
        return compile_it()
    except Exception as error:  # MuJoCo raises ValueError, its FatalError and more
        reason = " ".join(str(error).split())
        raise MjcfError(
            f"{source}: MuJoCo refuses it: {shown(reason, 200)}", source=source, element=""
        ) from None
