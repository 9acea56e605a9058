"""A rod falls on a smooth floor, at all angles: the impulse and the speed of its spin.

The closed form is P = (1 + e) m v/(1 + 3 cos² θ), θ from the floor. A rod that falls flat on
its end gets a quarter of the impulse of one that falls upright, and spins the most at 55°.

python examples/falling_rod.py
"""

from pathlib import Path

import numpy as np

import impulsekit as ik
from impulsekit.impact import ImpactSolver

MODELS = Path(__file__).parents[1] / "models"
E, SPEED = 0.5, 1.0  # restitution; m/s

rod = ik.Robot.from_urdf(MODELS / "rod.urdf", root="planar")
scene = ik.Scene(rod, contacts=[ik.Contact("rod", normal=[0, 1, 0], restitution=E)])
solver = ImpactSolver(scene)

print("angle [deg]   P [N s]   closed form   spin [rad/s]")
for degrees in range(0, 91, 15):
    angle = np.radians(degrees)
    # A planar root's linear velocity is in the rod's own axes.
    v = rod.velocity(root_joint=[-SPEED * np.sin(angle), -SPEED * np.cos(angle), 0])
    impact = solver.solve(rod.configuration(root_joint=[0, 0, angle]), v)
    closed_form = (1 + E) * rod.mass * SPEED / (1 + 3 * np.cos(angle) ** 2)
    impulse = impact.contacts[0].impulse[1]
    print(f"{degrees:11}   {impulse:7.5f}   {closed_form:11.5f}   {abs(impact.v_after[2]):12.4f}")
