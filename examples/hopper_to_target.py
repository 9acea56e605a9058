"""A hopper bounces to a target: at which pitch should its foot land each time? IPOPT, by CasADi.

A rod of 1 kg and 1 m stands on a springy foot that gives back 0.9 of its speed. Between landings a
wheel in the body sets pitch and spin. Every landing is an impact with friction; its exact
derivatives by pitch and velocity steer the search.

python examples/hopper_to_target.py
"""

from pathlib import Path

import casadi
import numpy as np

import impulsekit as ik
from impulsekit.casadi import impact

MODELS = Path(__file__).parents[1] / "models"
GRAVITY, FALL = 9.81, 4.0  # [m/s^2]; the speed of the first landing [m/s]
HALF = 0.5  # from the foot to the middle of the rod [m]
SEARCH = {
    "ipopt.hessian_approximation": "limited-memory", "ipopt.tol": 1e-8,
    "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False,
}  # fmt: skip

rod = ik.Robot.from_urdf(MODELS / "rod.urdf", root="planar")
foot = ik.Contact("rod", normal=[0, 1, 0], restitution=0.9, friction=0.8, name="foot")
scene = ik.Scene(rod, contacts=[foot])


def plan(landings: int, target: float, start: np.ndarray) -> dict:
    """The least pitches with which the last landing is at the target [m] from the first."""
    F = impact(scene, ["v_after"])
    pitch, time = casadi.MX.sym("pitch", landings), casadi.MX.sym("time", landings - 1)
    middle, speed, feet, laws = 0.0, casadi.DM([0.0, -FALL]), [], []
    for k in range(landings):
        c, s = -casadi.sin(pitch[k]), casadi.cos(pitch[k])  # the rod's own axis, upwards
        turn = casadi.blockcat([[c, -s], [s, c]])
        # A planar root's linear velocity is the foot's, in the rod's own axes.
        after = F(casadi.vertcat(0, 0, c, s), casadi.vertcat(turn.T @ speed, 0))
        up = turn @ casadi.vertcat(after[0], after[1] + HALF * after[2])
        feet.append(middle - HALF * c)
        if k < landings - 1:
            height = HALF * (casadi.cos(pitch[k + 1]) - s)
            laws.append(up[1] * time[k] - GRAVITY * time[k] ** 2 / 2 - height)
            middle, speed = middle + up[0] * time[k], up - casadi.vertcat(0, GRAVITY) * time[k]
    laws.append(feet[-1] - feet[0] - target)
    problem = {"x": casadi.vertcat(pitch, time), "f": casadi.sumsqr(pitch),
               "g": casadi.vertcat(*laws)}  # fmt: skip
    search = casadi.nlpsol("plan", "ipopt", problem, SEARCH)
    flights = 2.0 * FALL / GRAVITY * foot.restitution ** np.arange(1, landings)
    low, high = (np.repeat([a, b], [landings, landings - 1]) for a, b in ((-0.6, 0.05), (0.6, 2)))
    found = search(x0=np.concatenate([start, flights]), lbx=low, ubx=high, lbg=0.0, ubg=0.0)
    x = np.array(found["x"]).ravel()
    return {
        "status": search.stats()["return_status"], "iterations": search.stats()["iter_count"],
        "pitch": x[:landings], "time": x[landings:], "cost": float(found["f"]),
        "off": float(casadi.norm_inf(found["g"])), "statuses": dict(F.statuses),
    }  # fmt: skip


def followed(pitch: np.ndarray, time: np.ndarray) -> list[float]:
    """Where the foot lands, by ``solve`` and the flights in between."""
    middle, speed, feet = 0.0, np.array([0.0, -FALL]), []
    for angle, flight in zip(pitch, [*time, 0.0], strict=True):
        c, s = -np.sin(angle), np.cos(angle)
        turn = np.array([[c, -s], [s, c]])
        q = rod.configuration(root_joint=[0, 0, np.pi / 2 + angle])
        after = ik.solve(scene, q, [*(turn.T @ speed), 0.0]).v_after
        up = turn @ [after[0], after[1] + HALF * after[2]]
        feet.append(middle - HALF * c)
        middle, speed = middle + up[0] * flight, up - np.array([0.0, GRAVITY]) * flight
    return feet


if __name__ == "__main__":
    found = plan(10, 3.0, np.zeros(10))
    print(f"{found['status']} in {found['iterations']} iterations, off by {found['off']:.0e}")
    feet = followed(found["pitch"], found["time"])
    print("landing   pitch [deg]   foot from the first [m]")
    for k, (angle, place) in enumerate(zip(found["pitch"], feet, strict=True), 1):
        print(f"{k:7}   {np.degrees(angle):11.3f}   {place - feet[0]:12.6f}")
