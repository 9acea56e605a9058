"""Whittaker's struck chain and the struck pendulum: exact fractions for every length."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from impulsekit.chain import chain_urdf, pendulum_urdf
from impulsekit.reference.whittaker import StruckChain, struck_chain, struck_pendulum
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, Scene

from .problem import Problem

__all__ = ["chain_problem", "pendulum_problem", "struck_chains", "struck_pendulums"]

IMPULSE = 5  # N s
# What a method may be off [relative]: 160 rods lose some three digits.
TOLERANCE = 1e-12
QUICK, WHOLE = (3, 10, 40), (3, 10, 20, 40, 80, 160)


def struck_chains(quick: bool) -> Iterator[Problem]:
    """Free chains of n rods of 1 kg and 1 m, struck across at one end."""
    for n in QUICK if quick else WHOLE:
        yield chain_problem(n)


def struck_pendulums(quick: bool) -> Iterator[Problem]:
    """The same with the far end on a pin."""
    for n in QUICK if quick else WHOLE:
        yield pendulum_problem(n)


def chain_problem(
    n: int, mass: float = 1.0, length: float = 1.0, impulse: float = IMPULSE
) -> Problem:
    """A free chain of n rods along x, struck towards +y at its end of greatest x."""
    robot = Robot.from_urdf(chain_urdf(n, mass, length), root="planar")
    blow = AppliedImpulse(f"link_{n}", linear=[0, impulse, 0], at=[length, 0, 0])

    def exact() -> np.ndarray:
        truth = struck_chain(n, mass, length, impulse)
        # The root is the far end: its velocity, then turns of each rod against the one before.
        return np.array([0.0, float(truth.point_velocities[-1]), *_joint_rates(truth)])

    source = "fractions (Whittaker, Analytical Dynamics, p. 175)"
    return Problem(
        "struck chain",
        n,
        Scene(robot, [blow]),
        robot.neutral(),
        robot.velocity(),
        exact,
        source,
        TOLERANCE,
    )


def pendulum_problem(
    n: int, mass: float = 1.0, length: float = 1.0, impulse: float = IMPULSE
) -> Problem:
    """A chain of n rods that hangs from a pin, struck towards +x at its lower end."""
    robot = Robot.from_urdf(pendulum_urdf(n, mass, length))
    blow = AppliedImpulse(f"link_{n}", linear=[impulse, 0, 0], at=[0, 0, -length])

    def exact() -> np.ndarray:
        # Towards +x is a negative turn about y.
        return -np.array(_joint_rates(struck_pendulum(n, mass, length, impulse)))

    source = "fractions (Chang & Huston 1995, example 2)"
    return Problem(
        "struck pendulum",
        n,
        Scene(robot, [blow]),
        robot.neutral(),
        robot.velocity(),
        exact,
        source,
        TOLERANCE,
    )


def _joint_rates(truth: StruckChain) -> list[float]:
    """Rates of the joints from the far end: differences, as fractions, of the rods' rates."""
    rates = [*reversed(truth.link_rates)]
    before = [Fraction(0), *rates[:-1]]
    return [float(rate - above) for rate, above in zip(rates, before, strict=True)]
