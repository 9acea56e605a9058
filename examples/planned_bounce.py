"""A thrust steers a ball by way of the floor to a place and a spin: iLQR across an impact.

The ball starts at rest 1 m up and is to be 1.5 m away, 0.6 m high and spinning after 1 s. Thrust
moves the instant of the impact; the saltation matrix carries that through the Riccati recursion
(Kong, Council & Johnson 2021).

python examples/planned_bounce.py
"""

import numpy as np

import impulsekit as ik

STEPS, DT, RADIUS, MASS, GRAVITY = 50, 0.02, 0.05, 0.5, 9.81
INERTIA = 0.4 * MASS * RADIUS**2
START, GOAL = np.array([0, 1.0, 0, 0, 0, 0]), np.array([1.5, 0.6, 0, 0, 0, 30.0])
# Weights of the miss at the end, by x, z, angle and their rates; of the thrust [1/N^2].
END, EFFORT = np.diag([1e4, 1e4, 0, 0, 0, 1.0]), 0.01


INERTIAL = f"""<inertial><mass value="{MASS}"/>
    <inertia ixx="{INERTIA}" iyy="{INERTIA}" izz="{INERTIA}" ixy="0" ixz="0" iyz="0"/></inertial>"""
SPHERE = f'<geometry><sphere radius="{RADIUS}"/></geometry>'


def joint(kind: str, parent: str, child: str, axis: str) -> str:
    """A joint that carries a link, named like it."""
    return f"""<joint name="to_{child}" type="{kind}"><parent link="{parent}"/>
    <child link="{child}"/><axis xyz="{axis}"/>
    <limit lower="-1e3" upper="1e3" effort="1e3" velocity="1e3"/></joint>"""


# A ball in the plane of x and z, that turns about y.
ball = ik.Robot.from_urdf(
    f"""<robot name="ball"><link name="rail"/><link name="car"/><link name="lift"/>
    <link name="ball"><visual>{SPHERE}</visual><collision>{SPHERE}</collision>{INERTIAL}</link>
    {joint("prismatic", "rail", "car", "1 0 0")}{joint("prismatic", "car", "lift", "0 0 1")}
    {joint("revolute", "lift", "ball", "0 1 0")}</robot>"""
).with_ground()
floor = ik.Collision("ball", "ground", restitution=0.8, friction=0.3, name="floor")
scene = ik.Scene(ball, contacts=[floor])


def fly(x: np.ndarray, thrust: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The state after a flight, and its derivatives by the state before and by the thrust."""
    A, B = np.eye(6), np.zeros((6, 2))
    A[:3, 3:] = t * np.eye(3)
    B[:2], B[3:5] = t**2 / (2 * MASS) * np.eye(2), t / MASS * np.eye(2)
    return A @ x + B @ (thrust - [0.0, MASS * GRAVITY]), A, B


def step(x: np.ndarray, thrust: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same of a time step, through the impact if there is one."""
    after, A, B = fly(x, thrust, DT)
    if after[1] > RADIUS or after[4] > 0.0:
        return after, A, B
    fall = np.array([thrust[0] / MASS, thrust[1] / MASS - GRAVITY, 0.0])
    t = float(np.roots([fall[1] / 2, x[4], x[1] - RADIUS]).max())
    at, A, B = fly(x, thrust, t)
    impact = ik.solve(scene, at[:3], at[3:])
    jump = ik.saltation(impact, "floor", acceleration_before=fall, acceleration_after=fall).matrix
    end, C, D = fly(np.concatenate([at[:3], impact.v_after]), thrust, DT - t)
    return end, C @ jump @ A, C @ jump @ B + D


def rolled(thrusts: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray], float]:
    """The states under given thrusts (STEPS, 2), their derivatives, and the cost."""
    states, As, Bs = [START], [], []
    for thrust in thrusts:
        x, A, B = step(states[-1], thrust)
        states.append(x)
        As.append(A)
        Bs.append(B)
    miss = states[-1] - GOAL
    return np.array(states), As, Bs, 0.5 * (miss @ END @ miss + EFFORT * float((thrusts**2).sum()))


def planned(iterations: int = 100) -> tuple[np.ndarray, list[float]]:
    """The thrusts, and the cost after each iteration of iLQR."""
    thrusts = np.zeros((STEPS, 2))
    states, As, Bs, cost = rolled(thrusts)
    costs = [cost]
    for _ in range(iterations):
        Vx, Vxx, gains = END @ (states[-1] - GOAL), END, []
        for A, B, thrust in zip(As[::-1], Bs[::-1], thrusts[::-1], strict=True):
            Qu, Quu, Qux = (
                EFFORT * thrust + B.T @ Vx,
                EFFORT * np.eye(2) + B.T @ Vxx @ B,
                B.T @ Vxx @ A,
            )
            k, K = -np.linalg.solve(Quu, Qu), -np.linalg.solve(Quu, Qux)
            gains.append((k, K))
            Vx, Vxx = A.T @ Vx + Qux.T @ k, A.T @ Vxx @ A + Qux.T @ K
        for scale in 0.5 ** np.arange(12):
            x, tried = START, []
            for old, thrust, (k, K) in zip(states, thrusts, gains[::-1], strict=False):
                # Where one has bounced and the other not yet, they are not to be compared.
                together = x[4] * old[4] > 0.0 or x is START
                tried.append(thrust + scale * k + (K @ (x - old) if together else 0.0))
                x = step(x, tried[-1])[0]
            found = rolled(np.array(tried))
            if found[3] < costs[-1]:
                break
        else:
            break
        thrusts, (states, As, Bs, cost) = np.array(tried), found
        costs.append(cost)
    return thrusts, costs


if __name__ == "__main__":
    thrusts, costs = planned()
    states = rolled(thrusts)[0]
    for number in (0, 1, 2, 4, 8, len(costs) - 1):
        print(f"iteration {number:2}: cost {costs[number]:.6f}")
    x, z, _, _, _, spin = states[-1]
    print(f"after {STEPS * DT:g} s at x = {x:.3f} m, z = {z:.3f} m, spin {spin:.2f} rad/s")
    print(f"the largest thrust is {np.abs(thrusts).max():.2f} N")
