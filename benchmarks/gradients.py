"""Gradients through impacts that engines have published wrong, beside closed forms.

Run with ``python -m benchmarks.gradients``; the exit status is 1 if one is off by more than 1e-9.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from impulsekit import Collision, Contact, Robot, Scene, combine, sensitivity, simulate

__all__ = ["BOUND", "Case", "cases", "main"]

BOUND = 1e-9
RADIUS, GRAVITY = 0.05, 9.81


class Case(NamedTuple):
    """A gradient of a final place by places and speeds at the start.

    Attributes:
        ours, exact: the gradient and its closed form.
        source, published: where it was asked for, and what engines gave there.
    """

    name: str
    ours: np.ndarray
    exact: np.ndarray
    source: str
    published: str

    @property
    def error(self) -> float:
        """The largest difference from the closed form."""
        return float(np.abs(self.ours - self.exact).max())


def _ball() -> Robot:
    return Robot.from_urdf("models/ball.urdf", root="freeflyer")


def _bounces(
    place: list[float], velocity: list[float], e: float, fall: float, T: float, *walls: Contact
) -> np.ndarray:
    """(6, 12) the final place of a ball by all that it starts from."""  # fmt: skip
    ball = _ball()
    floor = Contact("ball", at=[0, 0, -RADIUS], restitution=e, name="floor")
    scene = Scene(ball, contacts=[floor, *walls], gravity=(0.0, 0.0, -fall))
    q = ball.configuration(root_joint=[*place, 0, 0, 0, 1])
    motion = simulate(scene, q, ball.velocity(root_joint=[*velocity, 0, 0, 0]), duration=T)
    return sensitivity(motion).matrix[:6]


def cases() -> Iterator[Case]:
    """All cases, computed as they are asked for."""
    two, T = combine(a=_ball(), b=_ball()), 1.0
    touch = Collision("a/ball", "b/ball", restitution=1.0)
    scene = Scene(two, contacts=[touch], gravity=(0.0, 0.0, 0.0))
    q = two.configuration(
        {"a/root_joint": [0, 0, 0, 0, 0, 0, 1], "b/root_joint": [0.52, 0, 0, 0, 0, 0, 1]}
    )
    v = two.velocity({"a/root_joint": [1, 0, 0, 0, 0, 0]})
    table = sensitivity(simulate(scene, q, v, duration=T)).matrix
    yield Case(
        "two balls swap speeds: x₂(T) by x₁, x₂, v₁, v₂",
        table[6, [0, 6, 12, 18]],
        np.array([1.0, 0.0, T, 0.0]),
        "nimblephysics#97",
        "Nimble 0.75, 0.25, 0.91, 0.08",
    )
    table = _bounces([0, 0, 2.95], [0, 0, -5.0], 1.0, 0.0, T)
    yield Case(
        "a ball bounces without gravity: z(T) by z, v_z",
        table[2, [2, 8]],
        np.array([-1.0, -T]),
        "brax#317",
        "Brax: z(T) is not continuous in z",
    )
    table = _bounces([-1.0, 0, 1.0], [2.0, 0, -2.0], 1.0, 0.0, T)
    yield Case(
        "a slanting bounce: z(T) by x, z, v_x, v_z",
        table[2, [0, 2, 6, 8]],
        np.array([0.0, -1.0, 0.0, -T]),
        "arXiv 2207.05060, task 1",
        "by convex optimization 0, −1, 0, −0.996; engines disagree",
    )
    wall = Contact("ball", [RADIUS, 0, 0], [-1, 0, 0], [1.0, 0, 0], restitution=1.0, name="wall")
    table = _bounces([0, 0, 1.0], [2.0, 0, -2.0], 1.0, 0.0, T, wall)
    yield Case(
        "by floor and wall: x(T), z(T) by v_x, v_z",
        table[[0, 0, 2, 2], [6, 8, 6, 8]],
        np.array([-T, 0.0, 0.0, -T]),
        "arXiv 2207.05060, task 2",
        "engines disagree",
    )
    e, z, T = 0.8, 0.5, 0.6
    drop = z - RADIUS
    t, speed = np.sqrt(2 * drop / GRAVITY), np.sqrt(2 * GRAVITY * drop)
    # z(T) = r + e u (T − t) − g/2 (T − t)², u' = g/u, t' = 1/u.
    by_z = e * GRAVITY / speed * (T - t) - (e * speed - GRAVITY * (T - t)) / speed
    # A start v_z at z: u² = v² + 2 g h, t = (u + v)/g.
    by_v = (e * speed - GRAVITY * (T - t)) * (-1.0 / GRAVITY)
    table = _bounces([0, 0, z], [0, 0, 0], e, GRAVITY, T)
    yield Case(
        "a dropped ball, e = 0.8: z(T) by z, v_z",
        table[2, [2, 8]],
        np.array([by_z, by_v]),
        "as in DiffMJX, arXiv 2506.14186",
        "wrong in MJX with stiff contacts unless steps adapt",
    )


def main() -> int:
    """Print the table; 1 if a gradient is off."""
    worst = 0.0
    for case in cases():
        worst = max(worst, case.error)
        numbers = ", ".join(f"{x:.9g}" for x in np.round(case.ours, 12) + 0.0)
        exact = ", ".join(f"{x:.9g}" for x in case.exact)
        sys.stdout.write(
            f"{case.name} ({case.source})\n    ours   {numbers}\n    exact  {exact}\n"
            f"    off by {case.error:.1e}; published: {case.published}\n"
        )
    return int(worst > BOUND)


if __name__ == "__main__":
    sys.exit(main())
