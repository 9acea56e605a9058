"""Where should Solo12 put its feet to spare its knees? Their impulse over the leg pose.

Solo12 drops on four feet with e = 0, its hips at one height. Feet may stand under the hips,
further out or further in. A knee that stands right above its foot carries the stop of all
that is above; where foot, knee and hip fold easily, little has to be stopped at once.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize_scalar

import impulsekit as ik

LEGS = ("FL", "FR", "HL", "HR")
LENGTH = 0.16  # [m] of the thigh and of the shank
HEIGHT = 0.25  # [m] of the hips above the feet
SPEED = 1.0  # [m/s]

solo = ik.Robot.from_example("solo12", root="freeflyer")
# In each pose the hips are at the same height, and the floor is where the feet are.
floor = [ik.Contact(f"{leg}_FOOT", origin=[0, 0, -HEIGHT], friction=0.8, name=leg) for leg in LEGS]
scene = ik.Scene(solo, contacts=floor)


def pose(out: float) -> np.ndarray:
    """Feet ``out`` [m] from under the hips: in front of the front ones, behind the others."""
    reach = math.hypot(HEIGHT, out)
    bend = math.acos(reach / (2.0 * LENGTH))
    lean = math.atan2(-out, HEIGHT)
    joints = {}
    for leg in LEGS:
        side = 1.0 if leg[0] == "F" else -1.0
        joints[f"{leg}_HFE"], joints[f"{leg}_KFE"] = side * (bend + lean), -2.0 * side * bend
    return solo.configuration(**joints)


def landing(out: float) -> ik.Impact:
    """The landing in a pose."""
    return ik.solve(scene, pose(out), solo.velocity(root_joint=[0, 0, -SPEED, 0, 0, 0]))


def knee_impulse(out: float) -> float:
    """The largest impulse that a knee's bearings carry [N s]."""
    reactions = landing(out).reactions
    return max(float(np.linalg.norm(reactions[f"{leg}_KFE"][:3])) for leg in LEGS)


if __name__ == "__main__":
    print("feet out [m]   foot [N s]   knee [N s]   effective mass of a foot [kg]")
    for out in np.linspace(-0.15, 0.15, 11).tolist():
        impact = landing(out)
        foot = max(float(np.linalg.norm(contact.impulse)) for contact in impact.contacts)
        mass = ik.design.effective_mass(solo, pose(out), "FL_FOOT", [0, 0, 1])
        print(f"{out:12.3f}   {foot:10.4f}   {knee_impulse(out):10.4f}   {mass:8.4f}")
    best = minimize_scalar(
        knee_impulse, bounds=(-0.15, 0.15), method="bounded", options={"xatol": 1e-7}
    )
    print(f"least with feet {best.x:.4f} m out: {best.fun:.4f} N s at {SPEED:g} m/s")
