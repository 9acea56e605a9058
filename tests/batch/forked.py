"""The command in processes that begin with all imported, for tests that end many of them."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path

__all__ = ["ForkedCommand"]

IMPORTED = [
    "impulsekit.cli", "impulsekit.study", "xarray", "dask.array",
    "tests.batch.preloaded",
]  # fmt: skip


class ForkedCommand:
    """``impulsekit`` with these arguments, in a process of its own, as ``subprocess.Popen``.

    Args:
        arguments: of the command.
        told: the file that gets what it writes to stdout and stderr.
    """

    def __init__(self, arguments: Sequence[str], told: Path) -> None:
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(IMPORTED)
        self._told = told
        self._process = context.Process(target=_run, args=(list(arguments), str(told)))
        self._process.start()

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    def poll(self) -> int | None:
        return self._process.exitcode

    def send_signal(self, number: signal.Signals) -> None:
        if self.poll() is None:
            # It may end by itself meanwhile.
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._process.pid, number)

    def kill(self) -> None:
        """End it, and wait until it has ended."""
        self.send_signal(signal.SIGKILL)
        self.wait(60.0)

    def pause(self) -> None:
        """Stop it, and wait until it stands still, as far as the system tells."""
        self.send_signal(signal.SIGSTOP)
        state = Path(f"/proc/{self._process.pid}/stat")
        # What has ended is gone from there, between two looks.
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            while state.read_text().rpartition(")")[2].split()[0] not in "TZX":
                time.sleep(0.001)

    def wait(self, timeout: float) -> None:
        self._process.join(timeout)
        assert self.returncode is not None, f"still runs after {timeout} s"

    def communicate(self, timeout: float = 120.0) -> tuple[str, None]:
        self.wait(timeout)
        # Where it was killed before it began to write there is no file.
        return (self._told.read_text() if self._told.exists() else ""), None


def _run(arguments: list[str], told: str) -> None:
    # Where the tests themselves ignore Ctrl-C, as in the background, this inherits it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with open(told, "w") as file:
        for stream in (sys.stdout, sys.stderr):
            os.dup2(file.fileno(), stream.fileno())
    from impulsekit.cli import main

    main(arguments, prog_name="impulsekit")
