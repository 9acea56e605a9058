"""Recordings whose truth is in closed form: a ball that bounces, a body that turns in flight."""

import numpy as np
import pinocchio as pin

import impulsekit as ik
from impulsekit.measured import Recording

G = 9.81
RADIUS = 0.05


def ball_scene(e=0.6, mu=0.2):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=e, friction=mu, name="floor")
    return ik.Scene(ball, contacts=[floor], gravity=[0, 0, -G])


def bounce(height, e, times, speed=0.0):
    """Heights of a point above a floor at 0, dropped from a height, and when it bounces.

    ``e``: a number, or a function of the speed.
    """
    start, z, v, found, bounces = 0.0, height, speed, np.empty(len(times)), []
    for k, t in enumerate(times):
        while True:
            fall = (v + np.sqrt(v * v + 2 * G * z)) / G
            if t - start <= fall or (z == 0.0 and fall < 1e-4):
                break
            down = G * fall - v
            start, z, v = start + fall, 0.0, (e(down) if callable(e) else e) * down
            bounces.append(start)
        late = t - start
        found[k] = 0.0 if z == 0.0 and fall < 1e-4 else z + v * late - 0.5 * G * late**2
    return found, np.array(bounces)


def bouncing_ball(scene, height, e, rate, seconds, sigma=0.0, rng=None, name=""):
    """A recording without friction: x moves on, the ball turns about z as it did."""
    t = np.arange(int(rate * seconds)) / rate
    z, times = bounce(height, e, t)
    q = np.zeros((len(t), 7))
    q[:, 0], q[:, 2] = 0.3 * t, z + RADIUS
    q[:, 5], q[:, 6] = np.sin(t), np.cos(t)
    if rng is not None:
        q = noisy(scene.robot.model, q, sigma, rng)
    return Recording(scene.robot, t, q, name=name), times


def noisy(model, q, sigma, rng):
    return np.array([pin.integrate(model, x, sigma * rng.normal(size=model.nv)) for x in q])


def flying_body(rng, rate=148, samples=30, scale=1.0, offset=(0, 0, 0), tilt=(0, 0), sigma=0.0):
    """Times and poses (N, 7) of a body with equal inertias, tracked beside its mass centre."""
    t = np.arange(samples) / rate
    start, way = 0.1 * rng.normal(size=3), rng.normal(size=3) + np.array([0, 0, 1.0])
    gravity = -G * np.array([-np.sin(tilt[0]), -np.sin(tilt[1]), np.cos(tilt[0]) * np.cos(tilt[1])])
    omega = 6.0 * rng.normal(size=3)
    first = pin.exp3(rng.normal(size=3))
    poses = np.empty((samples, 7))
    for k, time in enumerate(t):
        turn = first @ pin.exp3(omega * time)
        centre = start + way * time + 0.5 * gravity * time**2
        place = scale * (centre + turn @ np.array(offset)) + sigma * rng.normal(size=3)
        poses[k] = pin.SE3ToXYZQUAT(pin.SE3(turn, place))
    return t, poses
