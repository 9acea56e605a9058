"""A golf swing: how fast the ball leaves, and what shoulders and wrists feel of it.

python examples/golf_swing.py
"""

from pathlib import Path

import numpy as np

import impulsekit as ik

MODELS = Path(__file__).parents[1] / "models"
RADIUS, LOFT = 0.02135, np.radians(10)

robot = ik.combine(
    golfer=ik.Robot.from_urdf(MODELS / "golfer.urdf"),
    ball=ik.Robot.from_urdf(MODELS / "golf_ball.urdf", root="freeflyer"),
)
# At the impact arms and club hang down; a positive angle swings towards -x.
face, normal = np.array([0.03, 0, 0]), np.array([np.cos(LOFT), 0, np.sin(LOFT)])
q = ik.place(robot, robot.neutral(), "ball/ball", at_frame="golfer/head", at=face + RADIUS * normal)
v = robot.velocity({"golfer/shoulder": -8.0, "golfer/wrist": -24.0})

ends = {"frame": "ball/ball", "at": -RADIUS * normal, "against": "golfer/head", "origin": face}
hit = ik.Contact(**ends, normal=normal, restitution=0.83, friction=0.4, name="face")
scene = ik.Scene(robot, contacts=[hit])
print(ik.touching(scene, q, v))
impact = ik.solve(scene, q, v)
head, ball = (impact.velocity_at(frame) for frame in ("golfer/head", "ball/ball"))
print(f"the head slows from {head.before[0]:.1f} to {head.after[0]:.1f} m/s")
print(f"the ball leaves at {np.linalg.norm(ball.after):.1f} m/s")
print(f"the shoulders carry {impact.joint_loads['golfer/shoulder'].shear:.3f} N s")
print(f"the wrists carry {impact.joint_loads['golfer/wrist'].shear:.3f} N s")
