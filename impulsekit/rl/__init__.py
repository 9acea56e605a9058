"""Measures of landings for learning, as torch functions: ``Landing``."""

from ..errors import MissingExtraError

with MissingExtraError.unless("torch", "torch", "impulsekit.rl"):
    import torch as _torch  # noqa: F401

from .landing import OUTPUTS, Landing
from .layout import Layout

__all__ = ["OUTPUTS", "Landing", "Layout"]
