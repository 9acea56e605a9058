"""The four-bar of four_bar.toml moves on after the blow, and its loop stays closed.

python examples/struck_four_bar.py
"""

from pathlib import Path

import numpy as np
import pinocchio as pin

import impulsekit as ik

file = ik.load_scene(Path(__file__).with_name("four_bar.toml"))
robot = file.scene.robot
motion = ik.simulate(file.scene, file.q, file.v, duration=2.0, samples=201)

data = robot.model.createData()
gaps = []
for q in motion.q:
    pin.framesForwardKinematics(robot.model, data, q)
    far_pin = data.oMf[robot.frame_id("coupler")].act(np.array([0.5, 0, 0]))
    gaps.append(far_pin - data.oMf[robot.frame_id("rocker")].act(np.array([0, 0.5, 0])))

turns = (motion.q[-1, 0] - motion.q[0, 0]) / (2 * np.pi)
energy = motion.energy().total
print(f"the crank makes {turns:+.2f} turns in 2 s, {motion.steps} steps")
print(f"the loop opens by no more than {np.abs(gaps).max():.0e} m")
print(f"energy {energy[0]:.6f} J at the start, kept to {np.ptp(energy) / energy[0]:.0e}")
