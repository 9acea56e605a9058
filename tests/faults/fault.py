"""``Fault``: something a user does that cannot work, and what comes of it."""

from __future__ import annotations

import contextlib
import os
import pathlib
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from impulsekit.errors import ImpulsekitError


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes:
        what: what the user did, in a line.
        act: does it.
    """

    what: str
    act: Callable[[], Any]


@dataclass(frozen=True)
class Told:
    """What a user got for a fault.

    Attributes:
        what: what the user did.
        kind: the class of the error, or the exit status of a command.
        words: its words.
        is_ours: whether it is an ``ImpulsekitError``, or a command's own word on its use.
    """

    what: str
    kind: str
    words: str
    is_ours: bool


class CommandRefused(Exception):
    """A command ended with a status other than 0: the status and what it wrote to stderr."""

    def __init__(self, status: int, words: str) -> None:
        super().__init__(words)
        self.status = status


def commit(faults: Iterable[Fault]) -> list[Told]:
    """Commit faults, one after the other, in the current folder."""
    return [_told(fault) for fault in faults]


def _told(fault: Fault) -> Told:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Numbers that overflow on the way to their error are numpy's to remark on.
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            fault.act()
        except CommandRefused as refused:
            ours = refused.status == 2 and not str(refused).startswith("bug:")
            return Told(fault.what, f"exit status {refused.status}", str(refused), ours)
        except ImpulsekitError as error:
            # What a user sees of the files is their own path to it.
            words = str(error).replace(os.path.join(os.getcwd(), ""), "").replace(os.getcwd(), ".")
            return Told(fault.what, type(error).__name__, words, True)
        except Exception as error:
            return Told(fault.what, type(error).__name__, str(error), False)
    return Told(fault.what, "nothing", "", False)


@contextlib.contextmanager
def workshop() -> Iterator[pathlib.Path]:
    """A folder of one's own as the current one, so that files have short names."""
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        try:
            yield pathlib.Path(name)
        finally:
            os.chdir(before)
