"""Strike the left hand of Talos and see how fast the rest of it moves.

python examples/strike_a_hand.py
"""

import impulsekit as ik

robot = ik.Robot.from_example("talos", root="freeflyer")
scene = ik.Scene(robot, [ik.AppliedImpulse("gripper_left_base_link", linear=[0, 0, -5])])

q = robot.configuration(arm_left_4_joint=-1.2, arm_right_4_joint=-1.2)
impact = ik.solve(scene, q, robot.velocity())

for frame in ("gripper_left_base_link", "head_2_link", "gripper_right_base_link"):
    print(frame, impact.velocity_at(frame).after.round(3), "m/s")
print(f"kinetic energy {impact.energy.after:.3f} J")
print(impact.status.value)
