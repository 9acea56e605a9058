"""Ctrl-C while a motion is followed or a study is run: never lost, wherever it comes."""

from __future__ import annotations

import signal
import threading
from types import FrameType

__all__ = ["Interrupts"]


class Interrupts:
    """Keeps in mind that Ctrl-C was pressed, for a motion to end before its next step.

    An exception at any moment is not safe: Python drops what is raised in a finalizer, and
    native code that is just making its result turns it into a SystemError. A second Ctrl-C
    raises at once, for a function of the user's that does not return. Only in the main thread,
    and only where no other handler is set.
    """

    def __init__(self) -> None:
        self._struck = self._installed = False

    def __enter__(self) -> Interrupts:
        if (
            threading.current_thread() is threading.main_thread()
            and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        ):
            signal.signal(signal.SIGINT, self._strike)
            self._installed = True
        return self

    def __exit__(self, *_: object) -> None:
        if self._installed:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def stop(self) -> None:
        """As if Ctrl-C had come, for what other threads follow."""
        self._struck = True

    def heed(self) -> None:
        """Raise the KeyboardInterrupt that came."""
        if self._struck:
            raise KeyboardInterrupt

    def _strike(self, number: int, frame: FrameType | None) -> None:
        if self._struck:
            signal.default_int_handler(number, frame)
        self._struck = True
