from .chain import chain_urdf as chain_urdf
from .chain import pendulum_urdf as pendulum_urdf
from .robot.examples import example_names as example_names

__all__: list[str]
