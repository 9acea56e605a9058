"""Robots to begin with: chains and pendulums, names of example robots, makers' rotor inertias."""

import pathlib
from typing import TYPE_CHECKING, Any

from .chain import chain_urdf, pendulum_urdf
from .errors import UnknownNameError
from .errors.calls import public

if TYPE_CHECKING:
    from .robot.examples import example_names, rotor_inertias
    from .robot.model_checks import planar_root

__all__ = [
    "chain_urdf", "example_names", "path", "pendulum_urdf", "planar_root", "rotor_inertias",
]  # fmt: skip

# Where the models are in a wheel, and in a checkout.
_FOLDERS = ("data/models", "../models")


@public
def path(name: str) -> str:
    """Return the URDF file of a small model that comes with impulsekit, such as "ball".

    Raises:
        UnknownNameError: the name is unknown; it carries the nearest names.

    Example:
        >>> from impulsekit import Robot
        >>> Robot.from_file(path("ball"), root="freeflyer").mass
        0.5
    """
    here = pathlib.Path(__file__).parent
    files = {file.stem: file for folder in _FOLDERS for file in (here / folder).glob("*.urdf")}
    stem = str(name).removesuffix(".urdf")
    if stem not in files:
        raise UnknownNameError.among("model", stem, sorted(files))
    return str(files[stem].resolve())


def __getattr__(name: str) -> Any:
    # The text of a chain needs no Pinocchio; the names of robots come with it.
    if name in ("example_names", "rotor_inertias"):
        from .robot import examples

        return getattr(examples, name)
    if name == "planar_root":
        from .robot.model_checks import planar_root

        return planar_root
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
