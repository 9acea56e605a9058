"""xacro files: URDFs with macros, expanded by the package xacro."""

from __future__ import annotations

import io
import os
import tempfile
from contextlib import redirect_stderr, redirect_stdout

from ..errors import UrdfError, shown

__all__ = ["expanded"]

HINT = "expand it first: xacro FILE > robot.urdf"


def expanded(text: str, path: str | None) -> str:
    """The URDF that a xacro file stands for.

    xacro evaluates the expressions in the file, so expand files from sources you trust only.

    Args:
        text: the file's text.
        path: where it lies; files that it includes are looked for from there.

    Raises:
        UrdfError: xacro is not installed, or refuses the file; the sentence says why.
    """
    source = path or "URDF text"
    try:
        import xacro
    except ImportError:
        raise UrdfError(
            f"{source}: it is a xacro file, whose macros are not expanded; {HINT}, or "
            'pip install "impulsekit[xacro]"',
            source=source,
            element="xacro",
        ) from None
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            if path is not None:
                return xacro.process_file(path).toxml()
            with tempfile.TemporaryDirectory() as folder:
                own = os.path.join(folder, "robot.xacro")
                with open(own, "w", encoding="utf-8") as file:
                    file.write(text)
                return xacro.process_file(own).toxml()
    except (Exception, SystemExit) as error:  # xacro has no error class of its own for all
        lines = [line for line in (str(error) or said.getvalue()).splitlines() if line.strip()]
        reason = shown(lines[0], 200) if lines else type(error).__name__
        raise UrdfError(
            f"{source}: xacro cannot expand it: {reason}; {HINT}",
            source=source,
            element="xacro",
        ) from None
