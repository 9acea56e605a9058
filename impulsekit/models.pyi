from .chain import chain_urdf as chain_urdf
from .chain import pendulum_urdf as pendulum_urdf
from .robot.examples import example_names as example_names
from .robot.examples import rotor_inertias as rotor_inertias
from .robot.model_checks import planar_root as planar_root

__all__: list[str]

def path(name: str) -> str: ...
