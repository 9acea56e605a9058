"""Robots to begin with: chains and pendulums, names of example robots, makers' rotor inertias."""

from typing import TYPE_CHECKING, Any

from .chain import chain_urdf, pendulum_urdf

if TYPE_CHECKING:
    from .robot.examples import example_names, rotor_inertias
    from .robot.model_checks import planar_root

__all__ = ["chain_urdf", "example_names", "pendulum_urdf", "planar_root", "rotor_inertias"]


def __getattr__(name: str) -> Any:
    # The text of a chain needs no Pinocchio; the names of robots come with it.
    if name in ("example_names", "rotor_inertias"):
        from .robot import examples

        return getattr(examples, name)
    if name == "planar_root":
        from .robot.model_checks import planar_root

        return planar_root
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
