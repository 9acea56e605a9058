"""Two cars crash at a crossing, corner into door: how they leave, and a report of it.

python examples/car_crash.py
"""

from pathlib import Path

import numpy as np

import impulsekit as ik
from impulsekit.scene import ReportPoint

car = ik.Robot.from_urdf(Path(__file__).parents[1] / "models" / "car.urdf", root="planar")
robot = ik.combine(a=car, b=car)

# A drives along x and hits the door of B, which comes from the right, with its left front corner.
CORNER, DOOR = [2.25, 0.9, 0], [0.6, 0.9, 0]  # of A, and of B, in their own frames [m]
turned = robot.configuration({"b/root_joint": [0, 0, np.radians(80)]})
q = ik.place(robot, turned, "b/car", at_frame="a/car", at=CORNER, point=DOOR)
# The velocity of a planar root is in its own axes: both drive straight ahead.
v = robot.velocity({"a/root_joint": [14, 0, 0], "b/root_joint": [10, 0, 0]})

crash = ik.Contact(
    "a/car",
    at=CORNER,
    against="b/car",
    origin=DOOR,
    normal=[0, 1, 0],
    restitution=0.1,
    friction=0.5,
    name="door",
)
impact = ik.solve(ik.Scene(robot, contacts=[crash]), q, v)
points = [ReportPoint("a/car", label="A"), ReportPoint("b/car", label="B")]
print(ik.report(impact, points))
lost = impact.energy.before - impact.energy.after
print(f"{lost / 1e3:.0f} of {impact.energy.before / 1e3:.0f} kJ go into the sheet metal")
