"""Crocoddyl's impulse action, in an environment of its own.

Crocoddyl 3.2 is built against Pinocchio 4.0 and crashes beside 4.1. So it runs in another
interpreter, which is named by the environment variable ``IMPULSEKIT_CROCODDYL`` and made by

    python -m benchmarks.methods.crocoddyl --set-up FOLDER

Problems go there as plain numbers; answers and times, taken in there, come back. Its impulse holds
points and frames fast, without restitution: held robots, and landings of which it is taken
for granted that all points stick.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
import venv
import weakref
from pathlib import Path
from typing import Any

import click
import numpy as np

from impulsekit.errors import ImpulsekitError
from impulsekit.scene import Contact

from ..problems.problem import Problem
from .mechanism import has_plain_joints, hold_of, is_fixed, is_held, mechanism_of
from .method import Answer, Method

VARIABLE = "IMPULSEKIT_CROCODDYL"
PACKAGES = ("crocoddyl==3.2.1", "pin==4.0.0")
SERVER = Path(__file__).with_name("crocoddyl_server.py")


def set_up(folder: Path) -> Path:
    """Make the environment; gives its interpreter.

    Args:
        folder: where; what is there already is kept.

    Raises:
        subprocess.CalledProcessError: pip could not install it.
    """
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    return python


def _lacks() -> str:
    python = os.environ.get(VARIABLE)
    if not python:
        return (
            f"{VARIABLE} names no interpreter with Crocoddyl; make one with "
            "python -m benchmarks.methods.crocoddyl --set-up FOLDER"
        )
    return "" if Path(python).is_file() else f"{VARIABLE} is {python}, which is not there"


class _Server:
    """The process with Crocoddyl in it. It ends with this one."""

    def __init__(self, python: str) -> None:
        # -I keeps this folder, and files named like packages, off its path.
        self._process = subprocess.Popen(
            [python, "-I", str(SERVER)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        weakref.finalize(self, self._process.terminate)

    def ask(self, **request: Any) -> Any:
        """Its reply."""
        pipes = self._process.stdin, self._process.stdout
        if pipes[0] is None or pipes[1] is None:
            raise ImpulsekitError("the process with Crocoddyl has no pipes")
        try:
            pipes[0].write(json.dumps(request) + "\n")
            pipes[0].flush()
            reply = pipes[1].readline()
        except BrokenPipeError:
            reply = ""
        if not reply:
            _server.cache_clear()
            raise ImpulsekitError("the process with Crocoddyl has ended; its own words are above")
        return json.loads(reply)


@functools.cache
def _server(python: str) -> _Server:
    return _Server(python)


class _Elsewhere:
    """An answer of the other process, which times it itself."""

    def __init__(self, server: _Server, call: int) -> None:
        self._server, self._call = server, call

    def __call__(self) -> np.ndarray:
        """(nv,) velocities after."""
        return np.array(self._server.ask(do="answer", call=self._call))

    def seconds(self, repeats: int) -> float:
        """Of one call in there."""
        return float(self._server.ask(do="time", call=self._call, repeats=repeats))


def _prepare(problem: Problem) -> Answer:
    mechanism = mechanism_of(problem)
    request = {
        "bodies": [_plain(vars(body)) for body in mechanism.bodies],
        "blows": [_plain(vars(blow)) for blow in mechanism.blows],
        "joint_impulse": mechanism.joint_impulse.tolist(),
        "holds": [_plain(vars(hold_of(problem, entry))) for entry in _entries(problem)],
        "v": mechanism.v.tolist(),
    }
    server = _server(os.environ[VARIABLE])
    return _Elsewhere(server, server.ask(do="build", **request))


def _plain(fields: dict[str, Any]) -> dict[str, Any]:
    return {k: x.tolist() if isinstance(x, np.ndarray) else x for k, x in fields.items()}


def _entries(problem: Problem) -> list[Any]:
    return [*problem.scene.constraints, *problem.scene.contacts]


def _suits(problem: Problem) -> bool:
    entries = _entries(problem)
    return (
        bool(entries)
        and not problem.duration
        and has_plain_joints(problem)
        and all(_may_stick(problem, entry) for entry in entries)
    )


def _may_stick(problem: Problem, entry: Any) -> bool:
    """Whether an entry holds, or is a contact that holds if its point sticks."""
    if isinstance(entry, Contact):
        smooth = not entry.friction or entry.tangential_restitution or entry.restitution != 0.0
        return not smooth and is_fixed(problem, entry.against)
    return is_held(problem, entry)


METHODS: tuple[Method, ...] = (
    Method("crocoddyl, impulse action", _suits, _prepare, peer=True, lacks=_lacks),
)


@click.command()
@click.option(
    "--set-up", "folder", required=True, type=click.Path(path_type=Path), help="Where to make it."
)
def main(folder: Path) -> None:
    """Make the environment with Crocoddyl and tell how to name it."""
    sys.stdout.write(f"export {VARIABLE}={set_up(folder).absolute()}\n")


if __name__ == "__main__":
    main()
