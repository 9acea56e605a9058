"""Solo12 drops on its feet inside MuJoCo, with restitution 0 and 0.2.

MuJoCo compiles the URDF; the legs are held by position control with 3 N m/rad. What the knees
carry in the first impact is what `impulsekit` alone says.

python examples/solo12_in_mujoco.py
"""

import re
from pathlib import Path

import mujoco
import numpy as np

import impulsekit as ik
from impulsekit.mujoco import Impacts

FEET = ("FL", "FR", "HL", "HR")
CROUCHED = [0.0, 0.8, -1.6, 0.0, 0.8, -1.6, 0.0, -0.8, 1.6, 0.0, -0.8, 1.6]  # rad, leg by leg


def solo12(height):
    """The model with a floor, its shapes left out but for balls of 1 cm as feet."""
    urdf = Path(ik.Robot.from_example("solo12").parts[0].path).read_text(encoding="utf-8")
    urdf = re.sub(r"<(visual|collision)>.*?</\1>", "", urdf, flags=re.DOTALL)
    setting = '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
    spec = mujoco.MjSpec.from_string(urdf.replace("</robot>", setting))
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1], friction=[0.6, 0.01, 0]
    )
    base = spec.worldbody.first_body()
    base.add_freejoint()
    base.pos = [0, 0, height]
    for foot in FEET:
        spec.body(f"{foot}_FOOT").add_geom(
            name=foot, size=[0.01, 0, 0], mass=0, friction=[0.6, 0.01, 0]
        )
    return spec.compile()


print("e    time [s]  feet  lost [J]  knee FL carries [N s]  impacts in 1 s")
for restitution in (0.0, 0.2):
    model = solo12(0.5)
    data = mujoco.MjData(model)
    data.qpos[7:] = CROUCHED
    impacts = Impacts(model, restitution=restitution)
    hits = impacts.log()
    while data.time < 1.0:
        data.qfrc_applied[6:] = 3.0 * (CROUCHED - data.qpos[7:]) - 0.1 * data.qvel[6:]
        impacts.step(data)
    first = hits[0]
    knee = np.linalg.norm(first.joint_impulses["FL_LOWER_LEG"][:3])
    print(
        f"{restitution:.1f}  {first.time:8.4f}  {len(first.pairs):4}  {-first.energy_change:8.4f}"
        f"  {knee:21.4f}  {len(hits):14}"
    )

# The first impact of the last run, by impulsekit alone.
robot = ik.Robot.from_mjcf(model)
before = mujoco.MjData(model)
before.qpos[:], before.qvel[:] = first.qpos, first.qvel
mujoco.mj_kinematics(model, before)
contacts = []
for (_, foot), at in zip(first.pairs, first.positions, strict=True):
    body = before.body(f"{foot}_FOOT")
    point = body.xmat.reshape(3, 3).T @ (at - body.xpos)
    contacts.append(ik.Contact(f"{foot}_FOOT", at=point, restitution=0.2, friction=0.6))
impact = ik.solve(ik.Scene(robot, contacts=contacts), *ik.mujoco_state(before))
print("energy lost by impulsekit alone", f"{-impact.energy.change:.4f} J")
