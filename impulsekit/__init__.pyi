from . import errors as errors
from .chain import chain_urdf as chain_urdf
from .chain import pendulum_urdf as pendulum_urdf
