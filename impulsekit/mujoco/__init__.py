"""Impacts with restitution inside MuJoCo: ``Impacts(model, ...).step(data)`` for ``mj_step``."""

from ..errors import MissingExtraError

with MissingExtraError.unless("mujoco", "mujoco", "impulsekit.mujoco"):
    import mujoco as _mujoco  # noqa: F401

from .impacts import Impacts
from .record import StepImpact

__all__ = ["Impacts", "StepImpact"]
