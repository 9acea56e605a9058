"""A Panda hammers a nail: which pose and swing give it the largest impulse, with bounded joints?

The hammer's head is a mass in the hand. IPOPT, by CasADi, searches three joint angles and speeds;
the blow may load no joint with a moment above a bound, and no joint turns faster than 2 rad/s. The
wood stops the nail with a constant force F within milliseconds. So it goes P u/(2 F) deep, u the
speed of the blow, like any mass on dry friction.

python examples/nail_by_a_panda.py
"""

import casadi
import numpy as np

import impulsekit as ik
from impulsekit.casadi import impact

SWUNG = ("panda_joint2", "panda_joint4", "panda_joint6")
BOUNDS, FASTEST, WOOD = (0.2, 0.4, 0.6, 0.8), 2.0, 1000.0  # [N m s], [rad/s], [N]
HEAD = [0, 0, 0.15]  # the face of the hammer, in the hand [m]
SEARCH = {
    "ipopt.hessian_approximation": "limited-memory", "ipopt.tol": 1e-8,
    "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False,
}  # fmt: skip

arm = ik.Robot.from_example("panda").with_body("panda_hand", mass=0.5, com=[0, 0, 0.1])
nail = ik.Contact("panda_hand", at=HEAD, name="nail")  # its head keeps still at first
scene = ik.Scene(arm, contacts=[nail], gap_bound=np.inf)
start = arm.configuration(panda_joint2=0.6, panda_joint4=-1.6, panda_joint6=2.2)
places = [int(np.argmax(arm.velocity({name: 1.0}))) for name in SWUNG]


def planned(bound: float) -> tuple[np.ndarray, np.ndarray]:
    """The configuration and the velocity of the best blow, by the bound on moments [N m s]."""
    angle, speed = casadi.MX.sym("angle", 3), casadi.MX.sym("speed", 3)
    q, v = casadi.MX(start), casadi.MX.zeros(arm.nv)
    for i, place in enumerate(places):
        q[place], v[place] = angle[i], speed[i]
    impulse, loads = impact(scene, ["contact_impulses", "joint_loads"])(q, v)
    moments = casadi.sum1(loads[3:, :] ** 2).T / bound**2
    level = angle[0] - angle[1] - angle[2]  # the hand points straight down
    problem = {"x": casadi.vertcat(angle, speed), "f": -impulse[2],
               "g": casadi.vertcat(moments, level)}  # fmt: skip
    joints = arm.model.njoints - 1
    search = casadi.nlpsol("blow", "ipopt", problem, SEARCH)
    found = search(
        x0=[*start[places], 0.5, 0.2, 0.0],
        lbx=[-0.5, -2.8, 0.5] + [-FASTEST] * 3, ubx=[1.5, -0.3, 3.7] + [FASTEST] * 3,
        lbg=[0.0] * (joints + 1), ubg=[1.0] * joints + [0.0],
    )  # fmt: skip
    x = np.array(found["x"]).ravel()
    q, v = start.copy(), np.zeros(arm.nv)
    q[places], v[places] = x[:3], x[3:]
    return q, v


if __name__ == "__main__":
    print("bound [N m s]   blow [N s]   at [m/s]   deep [mm]   most loaded joint")
    for bound in BOUNDS:
        q, v = planned(bound)
        blow = ik.solve(scene, q, v)
        speed = -blow.contacts["nail"].velocity_before[2]
        impulse = blow.contacts["nail"].impulse[2]
        loads = {name: np.linalg.norm(blow.joint_loads[name].moment) for name in arm.joint_names}
        most = max(loads, key=loads.get)
        deep = 1e3 * impulse * speed / (2.0 * WOOD)
        print(f"{bound:13.1f}   {impulse:10.4f}   {speed:8.4f}   {deep:9.3f}   "
              f"{most} {loads[most]:.4f}")  # fmt: skip
