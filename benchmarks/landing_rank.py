"""``python -m benchmarks.landing_rank``: do ``Landing``'s impulses rank falls as peak forces do?

Solo12 falls on its feet at random: pose of the legs, tilt, velocity. At the instant of the first
touch ``Landing`` predicts the impulse of each knee, as if all feet touched. MuJoCo then goes on
from there with contacts that are springs and dampers, in steps far shorter than the contact, and
keeps the peak force of each knee.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import impulsekit as ik

RESULTS = Path(__file__).parent / "results/restitution"
FEET = ("FL", "FR", "HL", "HR")
CROUCHED = np.array([0.0, 0.8, -1.6, 0.0, 0.8, -1.6, 0.0, -0.8, 1.6, 0.0, -0.8, 1.6])  # rad
FALLS = 500
FRICTION, RADIUS = 0.6, 0.01
# Of the spring [1/s²], without restitution: half a period takes 10 ms.
STIFFNESS, DAMPING_RATIO = 1e5, 0.5
STEP, DURATION = 5e-5, 0.03  # s


def solo12(**contact: Any) -> Any:
    """Return Solo12 above a floor, with balls as feet and no other shapes."""
    urdf = Path(ik.Robot.from_example("solo12").parts[0].path or "").read_text(encoding="utf-8")
    urdf = re.sub(r"<(visual|collision)>.*?</\1>", "", urdf, flags=re.DOTALL)
    setting = '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
    spec = mujoco.MjSpec.from_string(urdf.replace("</robot>", setting))
    touch = {"friction": [FRICTION, 0.0, 0.0], **contact}
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name="floor", type=plane, size=[5, 5, 0.1], **touch)
    spec.worldbody.first_body().add_freejoint()
    for foot in FEET:
        spec.body(f"{foot}_FOOT").add_geom(name=foot, size=[RADIUS, 0, 0], mass=0, **touch)
    return spec.compile()


def fallen(model: Any, random: np.random.Generator, tilt: float) -> Any:
    """Return a state in which the lowest foot touches the floor."""
    data = mujoco.MjData(model)
    data.qpos[7:] = CROUCHED + random.uniform(-0.3, 0.3, 12)
    axis = np.array([*random.normal(size=2), 0.0])
    mujoco.mju_axisAngle2Quat(data.qpos[3:7], axis / np.linalg.norm(axis), random.uniform(0, tilt))
    data.qvel[:3] = *random.uniform(-0.5, 0.5, 2), random.uniform(-3.0, -0.5)
    data.qvel[3:6] = random.uniform(-1.0, 1.0, 3)
    data.qvel[6:] = random.uniform(-2.0, 2.0, 12)
    mujoco.mj_kinematics(model, data)
    feet = [data.geom(foot).xpos[2] for foot in FEET]
    data.qpos[2] -= min(feet) - RADIUS
    return data


def peak_forces(model: Any, data: Any) -> np.ndarray:
    """Return the largest force in each knee [N] within the contact."""
    knees = [model.body(f"{foot}_LOWER_LEG").id for foot in FEET]
    peaks = np.zeros(4)
    for _ in range(round(DURATION / STEP)):
        mujoco.mj_step(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        peaks = np.maximum(peaks, np.linalg.norm(data.cfrc_int[knees, 3:], axis=1))
    return peaks


def rank_correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Return Spearman's rank correlation."""
    first, second = (np.argsort(np.argsort(each.ravel())) for each in (a, b))
    return float(np.corrcoef(first, second)[0, 1])


def correlations(tilt: float, falls: int = FALLS) -> tuple[float, float]:
    """Return the rank correlations of the hardest knee of a fall, and of all knees."""
    import torch

    from impulsekit.rl import Landing

    solref = [-STIFFNESS, -2.0 * DAMPING_RATIO * np.sqrt(STIFFNESS)]
    model, random = solo12(solref=solref), np.random.default_rng(0)
    model.opt.timestep, model.opt.cone = STEP, mujoco.mjtCone.mjCONE_ELLIPTIC
    landing = Landing.from_mujoco(model, FEET, friction=FRICTION, outputs=("joint_impulse",))
    states = [fallen(model, random, tilt) for _ in range(falls)]
    q, v = (
        torch.tensor(np.array([getattr(data, name) for data in states]))
        for name in ("qpos", "qvel")
    )
    knees = [landing.joints.index(f"{foot}_KFE") for foot in FEET]
    predicted = landing(q, v)["joint_impulse"][:, knees, :3].norm(dim=2).numpy()
    peaks = np.array([peak_forces(model, data) for data in states])
    hardest = rank_correlation(predicted.max(axis=1), peaks.max(axis=1))
    return hardest, rank_correlation(predicted, peaks)


def main() -> int:
    """Write the table to ``benchmarks/results``."""
    lines = ["| tilt up to [deg] | hardest knee of a fall | every knee |", "|---|---|---|"]
    for tilt in (0.0, 2.0, 10.0):
        hardest, every = correlations(np.radians(tilt))
        lines.append(f"| {tilt:.0f} | {hardest:.3f} | {every:.3f} |")
    (RESULTS / "landing_rank.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
