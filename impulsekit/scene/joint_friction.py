"""Dry friction in a joint: a torque that holds it up to a bound, and opposes it when it moves."""

from __future__ import annotations

from dataclasses import dataclass

from .numbers import check_name, keep, not_negative, text

__all__ = ["JointFriction"]


@dataclass(frozen=True)
class JointFriction:
    """Dry (Coulomb) friction in a joint with one degree of freedom.

    τ = −torque · sign(v) while the joint moves; while it stands still τ is whatever holds it, at
    most ``torque`` either way. Joints and contacts at rest hold together: what they can carry
    between them does not move. Where joints of a loop, or joints and feet, are redundant, they
    share the load as stiff springs would. ``JointSpring`` has viscous damping.

    In an impact it carries nothing: a finite torque has no impulse in no time.

    Attributes:
        joint: the joint.
        torque: the largest torque or force τ_c [N m, N], 0 or more.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, NotFiniteError, RangeError.

    Example:
        >>> from impulsekit import Robot, Scene, simulate
        >>> from impulsekit.models import pendulum_urdf
        >>> arm = Robot.from_urdf(pendulum_urdf(1))
        >>> stiff = Scene(arm, forces=[JointFriction("joint_1", 100.0, name="bearing")])
        >>> motion = simulate(stiff, [1.0], [0.0], duration=1.0)
        >>> float(motion.q[-1, 0]), motion.forces["bearing"].force(0.5).shape
        (1.0, (1,))
    """

    joint: str
    torque: float
    name: str | None = None

    def __post_init__(self) -> None:
        text(self.joint, "JointFriction: joint")
        what = f'JointFriction in "{self.joint}"'
        keep(self, what, not_negative, "torque")
        check_name(self.name, what)
