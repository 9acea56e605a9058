"""Kernels in numba: plain arrays in, plain arrays out, several states side by side.

Compiled code is kept on disk. numba looks at the file of a function alone when it decides
whether what it kept is still true, but these functions are built into each other across
files; so what was kept is thrown away here whenever any of them has changed.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pathlib

__all__: list[str] = []


def _forget_what_has_changed() -> None:
    folder = pathlib.Path(__file__).parent
    digest = hashlib.sha256()
    for path in (*sorted(folder.glob("*.py")), folder.parent / "codes.py"):
        digest.update(path.read_bytes())
    stamp = folder / "__pycache__" / "kernels.stamp"
    with contextlib.suppress(OSError):
        if stamp.exists() and stamp.read_text() == digest.hexdigest():
            return
        for kept in (*stamp.parent.glob("*.nbi"), *stamp.parent.glob("*.nbc")):
            kept.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        partial = stamp.with_name(f"kernels.{os.getpid()}.partial")
        partial.write_text(digest.hexdigest())
        os.replace(partial, stamp)


_forget_what_has_changed()
