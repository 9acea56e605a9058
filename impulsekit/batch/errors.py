"""What in a scene the kernels do not know."""

from __future__ import annotations

__all__ = ["NoKernelError"]


class NoKernelError(Exception):
    """Something in a scene that the kernels do not know; the message says what."""
