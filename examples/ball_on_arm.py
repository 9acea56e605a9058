"""A ball drops on the hand of a swinging arm, inside MuJoCo.

The step of MuJoCo finds the impact, and the arm's joints carry it. The same state solved as a scene
of impulsekit gives the same velocities.

python examples/ball_on_arm.py
"""

import mujoco
import numpy as np

import impulsekit as ik
from impulsekit.mujoco import Impacts

MODEL = """<mujoco><option integrator="RK4" timestep="0.002"/><worldbody>
<body name="upper" pos="0 0 0.8"><joint name="shoulder" axis="0 1 0" armature="0.02"/>
<geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="2" contype="0" conaffinity="0"/>
<body name="lower" pos="0.4 0 0"><joint name="elbow" axis="0 1 0" armature="0.01"/>
<geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.025" mass="1" contype="0" conaffinity="0"/>
<geom name="hand" type="box" size="0.06 0.06 0.01" pos="0.33 0 0.02" mass="0.2" friction="0.4"/>
</body></body>
<body name="ball" pos="0.72 0.01 1.0"><freejoint/>
<geom name="ball" size="0.05" mass="0.3" friction="0.4"/></body></worldbody></mujoco>"""
RESTITUTION, FRICTION = 0.8, 0.4

model = mujoco.MjModel.from_xml_string(MODEL)
data = mujoco.MjData(model)
data.joint("shoulder").qvel[:] = -0.4  # rad/s, upwards
data.qvel[4] = -3.0  # m/s, the ball
impacts = Impacts(model, restitution=RESTITUTION)
while not impacts.last:
    impacts.step(data)
hit = impacts.last[0]
print(f"{hit.time:.4f} s: {hit.pairs[0][1]} on {hit.pairs[0][0]}, {hit.approach[0]:.4f} m/s")
print("separates at", f"{hit.separation[0] / hit.approach[0]:.12f} of that")
for body, joint in (("upper", "shoulder"), ("lower", "elbow")):
    print(f"the {joint} carries", hit.joint_impulses[body][:3].round(4), "N s")

# The same impact by impulsekit alone.
robot = ik.Robot.from_mjcf(model)
before = mujoco.MjData(model)
before.qpos[:], before.qvel[:] = hit.qpos, hit.qvel
mujoco.mj_kinematics(model, before)
q, v = ik.mujoco_state(before)
places = {
    name: before.body(name).xmat.reshape(3, 3).T @ (hit.positions[0] - before.body(name).xpos)
    for name in ("ball", "lower")
}
normal = before.body("lower").xmat.reshape(3, 3).T @ hit.normals[0]
first, second = hit.pairs[0]
contact = ik.Contact(
    "ball", at=places["ball"], against="lower", origin=places["lower"],
    normal=normal if second == "ball" else -normal, restitution=RESTITUTION, friction=FRICTION,
)  # fmt: skip
impact = ik.solve(ik.Scene(robot, contacts=[contact]), q, v)
ik.set_mujoco_state(before, impact.q, impact.v_after)
print("largest difference of velocities", f"{np.abs(before.qvel - hit.qvel - hit.dv).max():.0e}")
