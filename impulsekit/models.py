"""Robots to begin with: URDF texts of chains and pendulums, names of example robots."""

from typing import TYPE_CHECKING, Any

from .chain import chain_urdf, pendulum_urdf

if TYPE_CHECKING:
    from .robot.examples import example_names
    from .robot.model_checks import planar_root

__all__ = ["chain_urdf", "example_names", "pendulum_urdf", "planar_root"]


def __getattr__(name: str) -> Any:
    # The text of a chain needs no Pinocchio; the names of robots come with it.
    if name == "example_names":
        from .robot.examples import example_names

        return example_names
    if name == "planar_root":
        from .robot.model_checks import planar_root

        return planar_root
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
