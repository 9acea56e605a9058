"""Solo12 and gymnasium's humanoid drop on their feet inside MuJoCo, with restitution 0 and 0.2.

Joints are held by position control. What a knee carries in the first impact is what `impulsekit`
alone says of Solo12. The humanoid falls where gymnasium is installed.

python examples/landing_in_mujoco.py [--view]
"""

import importlib.util
import re
import sys
import time
from pathlib import Path

import mujoco
import mujoco.viewer
import numpy as np

import impulsekit as ik
from impulsekit.mujoco import Impacts

FEET = ("FL", "FR", "HL", "HR")
CROUCHED = [0.0, 0.8, -1.6, 0.0, 0.8, -1.6, 0.0, -0.8, 1.6, 0.0, -0.8, 1.6]  # rad, leg by leg


def solo12():
    """The model with a floor and balls of 1 cm as feet; its legs are drawn as lines."""
    urdf = Path(ik.Robot.from_example("solo12").parts[0].path).read_text(encoding="utf-8")
    urdf = re.sub(r"<(visual|collision)>.*?</\1>", "", urdf, flags=re.DOTALL)
    setting = '<mujoco><compiler fusestatic="false" discardvisual="false"/></mujoco></robot>'
    spec = mujoco.MjSpec.from_string(urdf.replace("</robot>", setting))
    spec.stat.extent = 0.8
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1], friction=[0.6, 0.01, 0]
    )
    base = spec.worldbody.first_body()
    base.add_freejoint()
    base.pos = [0, 0, 0.5]
    for body in spec.bodies[1:]:
        for part in body.bodies:
            if np.linalg.norm(part.pos) > 0.0:  # seen, not felt
                body.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0, 0, 0, *part.pos],
                    size=[0.008, 0, 0], rgba=[0.9, 0.4, 0.1, 1], mass=0, contype=0, conaffinity=0,
                )  # fmt: skip
    for foot in FEET:
        spec.body(f"{foot}_FOOT").add_geom(
            name=foot, size=[0.01, 0, 0], mass=0, friction=[0.6, 0.01, 0]
        )
    return spec.compile()


def humanoid(package):
    """The model that gymnasium ships, 20 cm above the floor."""
    assets = Path(package.origin).parent / "envs/mujoco/assets"
    spec = mujoco.MjSpec.from_file(str(assets / "humanoid.xml"))
    spec.body("torso").pos[2] += 0.2
    return spec.compile()


def fall(model, pose, stiffness, damping, restitution, show=lambda data: None):
    """Return the impacts within one second; ``show`` is called after each step."""
    data = mujoco.MjData(model)
    data.qpos[7:] = pose
    impacts = Impacts(model, restitution={"floor": restitution}, limits=0.0)
    hits = impacts.log()
    while data.time < 1.0:
        data.qfrc_applied[6:] = stiffness * (pose - data.qpos[7:]) - damping * data.qvel[6:]
        impacts.step(data)
        show(data)
    return hits


def watch(*given):
    """Show a fall in MuJoCo's viewer, at a fifth of its speed."""
    seen = mujoco.MjData(given[0])
    with mujoco.viewer.launch_passive(given[0], seen) as viewer:

        def show(data):
            mujoco.mj_copyData(seen, given[0], data)
            viewer.sync()
            time.sleep(5.0 * given[0].opt.timestep)

        fall(*given, show)


model = solo12()
robots = [("Solo12", "FL_LOWER_LEG", (model, CROUCHED, 3.0, 0.1))]
if package := importlib.util.find_spec("gymnasium"):
    figure = humanoid(package)
    robots.append(("humanoid", "left_shin", (figure, figure.qpos0[7:], 200.0, 10.0)))

print("robot     e    time [s]  feet  lost [J]  knee carries [N s]  impacts in 1 s")
first = {}
for name, shin, given in robots:
    for restitution in (0.0, 0.2):
        if "--view" in sys.argv:
            watch(*given, restitution)
        hits = fall(*given, restitution)
        hit = first[name] = hits[0]
        knee = np.linalg.norm(hit.joint_impulses[shin][:3])
        print(
            f"{name:8}  {restitution:.1f}  {hit.time:8.4f}  {len(hit.pairs):4}"
            f"  {-hit.energy_change:8.4f}  {knee:18.4f}  {len(hits):14}"
        )

# Solo12's first impact of the last run, by impulsekit alone.
hit, robot = first["Solo12"], ik.Robot.from_mjcf(model)
before = mujoco.MjData(model)
before.qpos[:], before.qvel[:] = hit.qpos, hit.qvel
mujoco.mj_kinematics(model, before)
contacts = []
for (_, foot), at in zip(hit.pairs, hit.positions, strict=True):
    body = before.body(f"{foot}_FOOT")
    point = body.xmat.reshape(3, 3).T @ (at - body.xpos)
    contacts.append(ik.Contact(f"{foot}_FOOT", at=point, restitution=0.2, friction=0.6))
impact = ik.solve(ik.Scene(robot, contacts=contacts), *ik.mujoco_state(before))
print("energy lost by impulsekit alone", f"{-impact.energy.change:.4f} J")
