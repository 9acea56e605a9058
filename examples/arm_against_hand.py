"""A UR5 meets a person's hand: effective masses, and the energy that is transferred.

python examples/arm_against_hand.py
"""

from pathlib import Path

import numpy as np

import impulsekit as ik

hand = ik.Robot.from_urdf(Path(__file__).parents[1] / "models" / "hand.urdf", root="freeflyer")
arm = ik.Robot.from_example("ur5")
robot = ik.combine(arm=arm, person=hand)

q = robot.configuration(
    {"arm/shoulder_lift_joint": np.radians(-60), "arm/elbow_joint": np.radians(90)}
)
v = robot.velocity({"arm/shoulder_pan_joint": 0.8})
speed = robot.velocity_of(q, v, "arm/tool0").linear
way = speed / np.linalg.norm(speed)
# The back of the hand lies at the flange and stops it: nothing springs back.
q = ik.place(robot, q, "person/hand", at_frame="arm/tool0")
normal = robot.placement(q, "arm/tool0").rotation.T @ way  # in the axes of the flange
meet = ik.Contact("person/hand", against="arm/tool0", normal=normal, name="hand")
impact = ik.solve(ik.Scene(robot, contacts=[meet]), q, v)

masses = [ik.design.effective_mass(robot, q, frame, way) for frame in ("arm/tool0", "person/hand")]
reduced = masses[0] * masses[1] / sum(masses)
lost = impact.energy.before - impact.energy.after
print(f"the flange meets the hand at {np.linalg.norm(speed):.3f} m/s")
print(f"effective mass of the arm {masses[0]:.3f} kg, of the hand {masses[1]:.3f} kg")
print(f"impulse {np.linalg.norm(impact.contacts['hand'].impulse):.3f} N s")
print(f"energy transferred {lost:.4f} J, by the reduced mass {reduced * speed @ speed / 2:.4f} J")
