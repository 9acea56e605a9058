"""What the examples show, against closed forms.

Scene files are solved here once each; scripts are run and their tables read.
"""

from __future__ import annotations

import functools
import pathlib
import subprocess
import sys

import impulsekit as ik

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


@functools.cache
def solved(name: str) -> ik.Impact:
    """The answer of a scene file."""
    file = ik.load_scene(EXAMPLES / f"{name}.toml")
    return ik.solve(file.scene, file.q, file.v)


@functools.cache
def printed(name: str) -> tuple[tuple[str, ...], ...]:
    """What a script prints, as words by line."""
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / f"{name}.py")], capture_output=True, text=True, check=True
    )
    return tuple(tuple(line.split()) for line in done.stdout.splitlines())
