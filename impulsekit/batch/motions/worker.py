"""A process that follows motions for another one, which it hears and answers through pipes.

It imports nothing of the program that started it, so that scripts need no guard for it.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import struct
import threading
import time
from typing import IO, Any

__all__ = ["main", "receive", "send"]

_LENGTH = struct.Struct("<Q")
# How often it is looked whether the process that asks is still there [s].
WATCH = 0.5


def send(stream: IO[bytes], message: Any) -> None:
    """Write a message, whole."""
    packed = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(_LENGTH.pack(len(packed)))
    stream.write(packed)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read a message.

    Raises:
        EOFError: whoever wrote is gone.
    """
    return pickle.loads(_exactly(stream, _LENGTH.unpack(_exactly(stream, _LENGTH.size))[0]))


def _exactly(stream: IO[bytes], count: int) -> bytes:
    read = stream.read(count)
    if len(read) < count:
        raise EOFError
    return read


def main() -> None:
    """Answer until the other process is gone."""
    # What a user's function prints must not come between the messages.
    hears, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    state = _State()
    with contextlib.suppress(EOFError, BrokenPipeError, KeyboardInterrupt):
        while True:
            kind, content = receive(hears)
            send(answers, state.scene(content) if kind == "scene" else state.row(*content))


def _end_with(parent: int) -> None:
    """End this process when the one that asks is gone, even within a motion.

    A thread does: a motion that reports its progress makes its steps one by one, at twice the cost.
    """
    while os.getppid() == parent:
        time.sleep(WATCH)
    os._exit(1)


class _State:
    """The scene that came last."""

    def __init__(self) -> None:
        self._scene: Any = None

    def scene(self, packed: bytes) -> str:
        """Take a scene; "" or why it cannot be had here."""
        try:
            self._scene = pickle.loads(packed)
        except Exception as error:  # whatever a pickle raises
            return f"{type(error).__name__}: {error}"
        return ""

    def row(self, inputs: Any, settings: Any, times: Any, impacts: bool = True) -> Any:
        """Follow a motion: ("row", its ``RowResult``) or ("error", what is to be raised)."""
        from .row import followed_row

        try:
            # Ctrl-C ends the motion, not the process.
            signal.signal(signal.SIGINT, signal.default_int_handler)
            found = followed_row(self._scene, inputs, settings, times, impacts)
            return "row", found
        except KeyboardInterrupt:
            return "row", None
        except Exception as error:
            return "error", _sendable(error)
        finally:
            signal.signal(signal.SIGINT, signal.SIG_IGN)


def _sendable(error: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(error))
        return error
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
