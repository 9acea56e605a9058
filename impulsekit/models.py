"""Robots to begin with: URDF texts of chains and pendulums, names of example robots."""

import lazy_loader as _lazy

# The text of a chain needs no Pinocchio; the names of robots come with it.
__getattr__, __dir__, __all__ = _lazy.attach(
    "impulsekit",
    submod_attrs={
        "chain": ["chain_urdf", "pendulum_urdf"],
        "robot.examples": ["example_names"],
    },
)
