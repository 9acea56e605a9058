"""The free end of a hanging chain, let go, falls faster than a stone.

A chain of ten links hangs from a pin in a wide bow, its other end held at the pin's height.
Let go, that end is pulled down by the part that has come to hang already (Calkin & March
1989, "The dynamics of a falling chain").

python examples/falling_chain.py
"""

from pathlib import Path

import numpy as np
import pinocchio as pin

import impulsekit as ik

LENGTH = 3.048  # m, of ten links
MODELS = Path(__file__).parents[1] / "models"

chain = ik.Robot.from_urdf(MODELS / "pendulum_10.urdf")
q = chain.neutral()
q[0], q[1:] = np.radians(-10.0), np.radians(-160.0 / 9)  # from nearly down to nearly up
motion = ik.simulate(ik.Scene(chain), q, chain.velocity(), duration=1.2, samples=301)

data = chain.model.createData()
heights = []
for state in motion.q:
    pin.framesForwardKinematics(chain.model, data, state)
    heights.append(data.oMf[chain.frame_id("link_10")].act(np.array([0, 0, -LENGTH / 10]))[2])
heights = np.array(heights)

fall = heights[0] - heights
stone = 0.5 * 9.81 * motion.t**2
ahead = np.argmax(fall - stone)
energy = motion.energy()
lead = fall[ahead] - stone[ahead]
print(f"after {motion.t[ahead]:.3f} s the end is {lead:.3f} m ahead of a stone")
print(f"lowest at {motion.t[np.argmin(heights)]:.3f} s, {heights.min():.3f} m under the pin")
print(f"energy kept to {np.ptp(energy.total) / np.ptp(energy.kinetic):.0e}")
