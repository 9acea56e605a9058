"""A UR5 with a payload of 2 kg runs into a wall: what the rotors behind its gears add.

python examples/wall_hit_by_ur5.py
"""

import numpy as np

import impulsekit as ik

GEAR = 101
# Rotor inertias of the three large and the three small motors [kg m²]; take those of your arm.
ROTORS = dict.fromkeys(("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"), 9e-5)
ROTORS |= dict.fromkeys(("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"), 2e-5)
PAYLOAD = [0, 0, 0.08]  # its mass centre and its face, in front of the flange [m]

bare = ik.Robot.from_example("ur5").with_body("tool0", mass=2.0, com=PAYLOAD)
geared = bare.with_armature(ROTORS, gear=dict.fromkeys(ROTORS, GEAR))
q = bare.configuration(
    shoulder_lift_joint=np.radians(-60), elbow_joint=np.radians(90), wrist_1_joint=np.radians(-30)
)
v = bare.velocity(shoulder_lift_joint=1.0, elbow_joint=-0.5)
face = bare.placement(q, "tool0").point(PAYLOAD)
speed = bare.velocity_of(q, v, "tool0", at=PAYLOAD).linear
print(f"the payload moves at {np.linalg.norm(speed):.3f} m/s")

for name, robot in (("without rotors", bare), ("with rotors", geared)):
    wall = ik.Contact("tool0", at=PAYLOAD, origin=face, normal=-speed, friction=0.3, name="wall")
    impact = ik.solve(ik.Scene(robot, contacts=[wall]), q, v)
    load = impact.joint_loads["elbow_joint"]
    print(f"{name}: {np.linalg.norm(impact.contacts['wall'].impulse):.3f} N s on the wall,")
    print(f"  elbow: shear {load.shear:.3f} N s, bending {load.bending:.3f} N m s")
