"""A box is thrown on a floor inside MuJoCo, tumbles and comes to rest.

Every impact of its corners keeps e, and none adds energy by Poisson's law. Where the impacts are
slow, and at rest, MuJoCo's own contact carries the box.

python examples/box_in_mujoco.py
"""

import mujoco
import numpy as np

import impulsekit as ik
from impulsekit.mujoco import Impacts

MODEL = """<mujoco><option integrator="RK4" timestep="0.002"/><worldbody>
<geom name="floor" type="plane" size="5 5 .1" friction="0.3"/>
<body name="box" pos="0 0 0.6"><freejoint/>
<geom name="box" type="box" size="0.1 0.08 0.06" mass="1" friction="0.3"/></body>
</worldbody></mujoco>"""

model = mujoco.MjModel.from_xml_string(MODEL)
data = mujoco.MjData(model)
data.qvel[:] = [1.0, 0.3, 0.0, 2.0, -4.0, 1.0]
impacts = Impacts(model, restitution=0.5, law=ik.Law("poisson"))
hits = impacts.log()
while data.time < 3.0:
    impacts.step(data)

print("time [s]  corners  approach [m/s]  energy lost [J]")
for hit in hits[:8]:
    speed, lost = hit.approach.max(), -hit.energy_change
    print(f"{hit.time:8.4f}  {len(hit.pairs):7}  {speed:14.4f}  {lost:15.4f}")
print(len(hits), "impacts; greatest gain of energy", f"{max(h.energy_change for h in hits):.0e} J")
print(f"at rest at {data.qpos[2]:.4f} m, {np.abs(data.qvel).max():.0e} m/s")

# The first impact as a scene of impulsekit: where the corners are on the box.
hit = hits[0]
state = mujoco.MjData(model)
state.qpos[:], state.qvel[:] = hit.qpos, hit.qvel
turn = np.zeros(9)
mujoco.mju_quat2Mat(turn, hit.qpos[3:7])
robot = ik.Robot.from_mjcf(model)
corners = (hit.positions - hit.qpos[:3]) @ turn.reshape(3, 3)
contacts = [ik.Contact("box", at=at, restitution=0.5, friction=0.3) for at in corners]
impact = ik.solve(
    ik.Scene(robot, contacts=contacts, law=ik.Law("poisson")), *ik.mujoco_state(state)
)
ik.set_mujoco_state(state, impact.q, impact.v_after)
print("difference to impulsekit alone", f"{np.abs(state.qvel - hit.qvel - hit.dv).max():.0e}")
