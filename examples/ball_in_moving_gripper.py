"""A Panda moves its gripper along with a ball that it catches: the faster, the less it feels.

python examples/ball_in_moving_gripper.py
"""

from pathlib import Path

import numpy as np

import impulsekit as ik

MODELS = Path(__file__).parents[1] / "models"
GRIP = [0, 0, 0.1034]  # between the fingertips, in the frame of the hand [m]

ball = ik.Robot.from_urdf(MODELS / "billiard_ball.urdf", root="freeflyer")
robot = ik.combine(arm=ik.Robot.from_example("panda"), ball=ball)
q = robot.configuration(
    {
        "arm/panda_joint2": 0.3,
        "arm/panda_joint4": -1.6,
        "arm/panda_joint6": 3.4,
        "arm/panda_finger_joint1": 0.028575,  # the ball's radius
        "arm/panda_finger_joint2": 0.028575,
    }
)
q = ik.place(robot, q, "ball/ball", at_frame="arm/panda_hand", at=GRIP)
grip = ik.FrameAnchor("ball/ball", "arm/panda_hand", other_at=GRIP, name="grip")
scene = ik.Scene(robot, constraints=[grip])

for turning in (0.0, -1.0, -2.0):
    v = robot.velocity({"ball/root_joint": [0, -2, 0, 0, 0, 0], "arm/panda_joint1": turning})
    hand = robot.velocity_of(q, v, "arm/panda_hand", at=GRIP).linear
    impact = ik.solve(scene, q, v)
    force = np.linalg.norm(impact.constraints["grip"].impulse[:3])
    wrist = impact.joint_loads["arm/panda_joint7"]
    print(f"hand at {hand[1]:5.2f} m/s: the grip carries {force:.3f} N s,")
    print(f"    the last joint {wrist.bending:.4f} N m s of bending")
