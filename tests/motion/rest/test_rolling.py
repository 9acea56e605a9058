"""Rolling and torsional friction in motions, against closed forms."""

import numpy as np
import pytest

import impulsekit as ik

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
ON_FLOOR = BALL.with_ground()
MASS, INERTIA, R, G = 0.5, 5e-4, 0.05, 9.81


def rolled(v, duration, **coefficients):
    floor = ik.Collision("ball", "ground", name="floor", **coefficients)
    scene = ik.Scene(ON_FLOOR, contacts=[floor])
    q = ON_FLOOR.configuration(root_joint=[0, 0, R, 0, 0, 0, 1])
    return ik.simulate(scene, q, ON_FLOOR.velocity(root_joint=v), duration=duration)


@pytest.mark.slow
def test_a_ball_stops_rolling_at_the_closed_form_time():
    """(I + m R²) ω̇ = −ρ m g, of sticking friction; Chrono's case."""
    rho, w = 4e-3, 10.0
    stop = w * (INERTIA + MASS * R**2) / (rho * MASS * G)
    motion = rolled([w * R, 0, 0, 0, w, 0], stop + 0.1, friction=0.4, rolling=rho)
    assert motion.status.name == "FINISHED"
    assert np.abs(motion._path.step_times - stop).min() < 1e-7
    assert np.abs(motion.at(stop + 0.05)[1]).max() < 1e-9
    assert motion.at(stop + 0.05)[0][0] == pytest.approx(0.5 * w * R * stop, abs=1e-8)
    assert motion.contacts["floor"].moment(0.3 * stop) == pytest.approx(
        [0, -rho * MASS * G, 0], abs=1e-9
    )
    assert np.abs(motion.balance().residual).max() < 1e-7
    lost = 0.5 * MASS * (w * R) ** 2 + 0.5 * INERTIA * w**2
    assert motion.contacts["floor"].work() == pytest.approx(-lost, rel=1e-7)


@pytest.mark.parametrize(("slope", "moves"), [(0.07, False), (0.09, True)])
def test_a_ball_on_a_slope_rolls_above_rho_over_r(slope, moves):
    """It stays while tan α < ρ/R = 0.08, and then rolls with m g (sin α R − cos α ρ)."""
    rho, a, way = 4e-3, np.arctan(slope), np.array([0.6, 0.8, 0.0])
    normal = np.sin(a) * way + [0, 0, np.cos(a)]
    down = np.cos(a) * way - [0, 0, np.sin(a)]
    robot = BALL.with_ground(normal=normal)
    floor = ik.Collision("ball", "ground", name="floor", friction=0.5, rolling=rho)
    q = robot.configuration(root_joint=[*(R * normal), 0, 0, 0, 1])
    motion = ik.simulate(ik.Scene(robot, contacts=[floor]), q, robot.velocity(), duration=0.3)
    assert motion.status.name == "FINISHED"
    rate = MASS * G * (np.sin(a) * R - np.cos(a) * rho) / (INERTIA + MASS * R**2) if moves else 0
    q, v = motion.at(0.3)
    found = np.concatenate([_rotation(q[3:7]) @ v[:3], _rotation(q[3:7]) @ v[3:]])
    axis = np.cross(normal, down)
    assert found == pytest.approx(0.3 * rate * np.concatenate([R * down, axis]), abs=1e-8)
    resists = MASS * G * (np.cos(a) * rho if moves else np.sin(a) * R)
    assert motion.contacts["floor"].moment(0.2) == pytest.approx(-resists * axis, abs=1e-8)


@pytest.mark.slow
def test_slipping_rolling_and_spinning_at_once_against_an_own_integration():
    """A ball thrown along the floor: slip turns into rolling while both moments act."""
    from scipy.integrate import solve_ivp

    mu, rho, tau = 0.2, 1e-3, 5e-4

    def rates(t, y):
        vx, vy, wx, wy, wz = y
        slip = np.array([vx - wy * R, vy + wx * R])
        f = -mu * MASS * G * slip / np.linalg.norm(slip)
        turn = -rho * MASS * G * np.array([wx, wy]) / np.hypot(wx, wy)
        return [
            *(f / MASS), (f[1] * R + turn[0]) / INERTIA, (-f[0] * R + turn[1]) / INERTIA,
            -np.sign(wz) * tau * MASS * G / INERTIA,
        ]  # fmt: skip

    start, end = [1.0, 0.3, 2.0, -6.0, 4.0], 0.12
    truth = solve_ivp(rates, (0, end), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    v = [start[0], start[1], 0, *start[2:]]
    motion = rolled(v, end, friction=mu, rolling=rho, torsion=tau)
    # The ball's own axes have turned.
    q, u = motion.at(end)
    turn = _rotation(q[3:7])
    found = np.concatenate([(turn @ u[:3])[:2], turn @ u[3:]])
    assert found == pytest.approx(truth, abs=1e-7)


def _rotation(quaternion):
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion).as_matrix()


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "share"), [(0.0, 0.6), (0.4, 0.6), (0.0, 1.5)])
def test_a_moment_spins_a_ball_above_what_torsion_bears_with_and_without_friction(friction, share):
    tau = 2e-3
    bound = tau * MASS * G
    floor = ik.Collision("ball", "ground", friction=friction, torsion=tau)
    moment = ik.AppliedForce("ball", angular=[0, 0, share * bound])
    scene = ik.Scene(ON_FLOOR, contacts=[floor], forces=[moment], gravity=(1e-9, 0, -G))
    q = ON_FLOOR.configuration(root_joint=[0, 0, R, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, ON_FLOOR.velocity(), duration=0.1)
    spin = max(share - 1.0, 0.0) * bound / INERTIA
    assert motion.v[:, 5] == pytest.approx(spin * motion.t, abs=1e-8)
    assert np.abs(motion.balance().residual).max() < 1e-9
