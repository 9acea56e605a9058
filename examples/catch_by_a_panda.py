"""A Panda catches a ball on its palm: how should the arm move so that no joint is loaded much?

The ball comes at 3 m/s against the hand. IPOPT, by CasADi, searches the speeds of the seven
joints, at most 1 rad/s, for the least of the largest moment that the catch leaves in a joint.

python examples/catch_by_a_panda.py
"""

from pathlib import Path

import casadi
import numpy as np

import impulsekit as ik
from impulsekit.casadi import impact

MODELS = Path(__file__).parents[1] / "models"
PALM = [0, 0, 0.06]  # in the hand [m]
FASTEST, SPEED = 1.0, 3.0  # [rad/s], [m/s]
SEARCH = {
    "ipopt.hessian_approximation": "limited-memory", "ipopt.tol": 1e-8, "ipopt.max_iter": 500,
    "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False,
}  # fmt: skip

ball = ik.Robot.from_urdf(MODELS / "billiard_ball.urdf", root="freeflyer")
world = ik.combine(arm=ik.Robot.from_example("panda"), ball=ball)
q = world.configuration(
    {"arm/panda_joint2": 0.3, "arm/panda_joint4": -1.6, "arm/panda_joint6": 1.9 + np.pi / 2}
)
q = ik.place(world, q, "ball/ball", at_frame="arm/panda_hand", at=PALM)
palm = ik.Contact("ball/ball", against="arm/panda_hand", origin=PALM, friction=0.5, name="palm")
scene = ik.Scene(world, contacts=[palm])
flying = world.velocity({"ball/root_joint": [-SPEED, 0, 0, 0, 0, 0]})
joints = [int(np.argmax(world.velocity({f"arm/panda_joint{i}": 1.0}))) for i in range(1, 8)]
names = list(world.model.names)[1:]
carried = [names.index(f"arm/panda_joint{i}") for i in range(1, 8)]


def sparing() -> np.ndarray:
    """The velocity before the catch that spares the joints most."""
    speeds, most = casadi.MX.sym("speeds", 7), casadi.MX.sym("most")
    v = casadi.MX(flying)
    for i, place in enumerate(joints):
        v[place] = speeds[i]
    loads = impact(scene, ["joint_loads"])(q, v)[3:, carried]
    laws = casadi.sum1(loads**2).T - most
    problem = {"x": casadi.vertcat(speeds, most), "f": most, "g": laws}
    search = casadi.nlpsol("catch", "ipopt", problem, SEARCH)
    low, high = [-FASTEST] * 7 + [0.0], [FASTEST] * 7 + [10.0]
    found = search(x0=[0.0] * 7 + [0.1], lbx=low, ubx=high, ubg=0.0)
    v = flying.copy()
    v[joints] = np.array(found["x"]).ravel()[:7]
    return v


def most_loaded(impact: ik.Impact) -> tuple[str, float]:
    """The joint whose bearings carry the largest moment, and that [N m s]."""
    moments = {
        names[i]: float(np.linalg.norm(impact.joint_loads[names[i]].moment)) for i in carried
    }
    name = max(moments, key=moments.__getitem__)
    return name, moments[name]


if __name__ == "__main__":
    for title, v in (("arm at rest", flying), ("arm that moves so", sparing())):
        caught = ik.solve(scene, q, v)
        name, moment = most_loaded(caught)
        impulse = float(np.linalg.norm(caught.contacts["palm"].impulse))
        print(f"{title}: the palm takes {impulse:.4f} N s, {name} {moment:.4f} N m s")
    print("with its joints at", v[joints].round(3), "rad/s")
