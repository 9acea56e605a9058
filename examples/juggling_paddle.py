"""A paddle juggles a ball inside MuJoCo, by what it sees of the last impact.

The ball has to rise one metre after every stroke: the paddle's speed at the impact follows from
v⁺ = (1 + e) w - e v⁻, where w is the speed of the paddle, which is moved by its velocity.

python examples/juggling_paddle.py
"""

import mujoco
import numpy as np

import impulsekit as ik
from impulsekit.mujoco import Impacts

MODEL = """<mujoco><option integrator="RK4" timestep="0.002"/><worldbody>
<body name="paddle"><joint name="lift" type="slide" axis="0 0 1"/>
<geom name="paddle" type="cylinder" size="0.15 0.01" mass="50"/></body>
<body name="ball" pos="0 0 0.6"><joint name="fall" type="slide" axis="0 0 1"/>
<geom name="ball" size="0.02" mass="0.01"/></body></worldbody></mujoco>"""
RESTITUTION, HEIGHT, GRAVITY = 0.7, 1.0, 9.81

model = mujoco.MjModel.from_xml_string(MODEL)
data = mujoco.MjData(model)
impacts = Impacts(model, restitution={"ball": RESTITUTION})
hits = impacts.log()
wanted = np.sqrt(2 * GRAVITY * HEIGHT)
while len(hits) < 8:
    ball, paddle = data.joint("fall"), data.joint("lift")
    falling = min(ball.qvel[0], 0.0)
    stroke = (wanted + RESTITUTION * falling) / (1 + RESTITUTION)
    # Below its place it waits; when the ball comes near, it strokes.
    near = falling < 0.0 and ball.qpos[0] + 0.6 - paddle.qpos[0] < 0.1
    paddle.qvel[:] = stroke if near else -8.0 * paddle.qpos[0]  # m/s
    impacts.step(data)

print("stroke  time [s]  before [m/s]  after [m/s]  rises [m]")
for number, hit in enumerate(hits, 1):
    before, after = hit.qvel[1], (hit.qvel + hit.dv)[1]
    print(
        f"{number:6}  {hit.time:8.4f}  {before:12.4f}  {after:11.4f}  {after**2 / 2 / GRAVITY:9.4f}"
    )

# The last stroke as a scene of impulsekit.
robot = ik.Robot.from_mjcf(model)
state = mujoco.MjData(model)
state.qpos[:], state.qvel[:] = hits[-1].qpos, hits[-1].qvel
contact = ik.Contact("ball", at=[0, 0, -0.02], against="paddle", restitution=RESTITUTION)
q, v = ik.mujoco_state(state)
impact = ik.solve(ik.Scene(robot, contacts=[contact], gap_bound=1.0), q, v)
ball = robot.model.joints[robot.model.getJointId("fall")].idx_v
print(f"after the last stroke, by impulsekit alone: {impact.v_after[ball]:.4f} m/s")
