"""Kane & Levinson's double pendulum strikes a rough floor: the energy left, law by law.

Newton's law with friction can leave more energy than there was (Kane & Levinson 1985); the
status of such an answer says so. Stronge's law balances work and cannot.

python examples/rough_floor.py
"""

from pathlib import Path

import numpy as np

import impulsekit as ik

MODELS = Path(__file__).parents[1] / "models"

robot = ik.Robot.from_urdf(MODELS / "double_pendulum.urdf")
# The rods lean by 20 and 30 degrees and turn at -0.1 and -0.2 rad/s.
q = robot.configuration(joint_1=np.radians(20), joint_2=np.radians(10))
v = robot.velocity(joint_1=-0.1, joint_2=-0.1)
end = robot.placement(q, "link_2").point([0, 0, -1])
floor = ik.Contact("link_2", at=[0, 0, -1], origin=end, restitution=0.7, friction=0.5)

print("restitution  slip  energy after/before  end's velocity x, z [m/s]  status")
for restitution, slip in [
    ("newton", "end"),
    ("newton", "path"),
    ("poisson", "end"),
    ("poisson", "path"),
    ("stronge", "path"),
]:
    impact = ik.solve(ik.Scene(robot, contacts=[floor], law=ik.Law(restitution, slip)), q, v)
    left = impact.energy.after / impact.energy.before
    x, _, z = impact.contacts[0].velocity_after
    print(f"{restitution:11}  {slip:4}  {left:19.3f}  {x:z12.4f} {z:12.4f}  {impact.status.name}")
