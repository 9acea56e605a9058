"""Impacts and motions for the gallery of examples that compute without a scene."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import impulsekit as ik


def _racket(names: dict[str, Any]) -> ik.Impact:
    """Return the impact of a ball in mid-strings, the racket held 10 cm from the butt."""
    racket = names["held_at"](0.1)
    at = [names["MIDDLE"] - 0.1, 0, 0]
    blow = ik.AppliedImpulse("racket", linear=[0, 0, 2], at=at, name="ball")
    return ik.solve(ik.Scene(racket, [blow]), racket.neutral(), racket.velocity(wrist=10.0))


def _rod(names: dict[str, Any]) -> ik.Impact:
    """Return one of the measured impacts: a rod that leans by 50 degrees."""
    # The script's rod has no shape.
    visual = """<visual><origin rpy="0 1.5707963 0"/><geometry><cylinder radius="0.02" length="1"/>
    </geometry></visual><inertial>"""
    rod = ik.Robot.from_urdf(names["ROD"].replace("<inertial>", visual), root="planar")
    lean = math.radians(50)
    tip = ik.Contact("rod", at=[-0.5, 0, 0], normal=[0, 1, 0], restitution=0.6, friction=0.3,
                     origin=[0, -0.5 * math.sin(lean), 0], name="tip")  # fmt: skip
    scene = ik.Scene(rod, contacts=[tip], law=ik.Law("stronge", "path"))
    q = rod.configuration(root_joint=[0, 0, lean])
    # The velocity of a planar root is in its own axes.
    turn = np.array([[math.cos(lean), math.sin(lean)], [-math.sin(lean), math.cos(lean)]])
    return ik.solve(scene, q, rod.velocity(root_joint=[*(turn @ [0.4, -2.0]), 0]))


def _chain(_names: dict[str, Any]) -> ik.Impact:
    file = ik.load_scene("examples/whittaker_chain.toml")
    return ik.solve(file.scene, file.q, file.v)


INERTIAL = """<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
</inertial>"""
HUB = f"""<link name="hub"><visual><geometry><sphere radius="0.06"/></geometry></visual>{INERTIAL}
</link>"""


def _walker(angles: list[float]) -> ik.Robot:
    """Return spokes of 1 m on a hub, at angles about y [rad], each on a joint of its own."""
    spokes = "".join(
        f"""<link name="leg_{i}"><visual><origin xyz="0 0 -0.5"/><geometry>
        <box size="0.02 0.02 1"/></geometry></visual>{INERTIAL}</link>
        <joint name="turn_{i}" type="continuous"><parent link="hub"/><child link="leg_{i}"/>
        <origin rpy="0 {angle} 0"/><axis xyz="0 1 0"/></joint>"""
        for i, angle in enumerate(angles)
    )
    return ik.Robot.from_urdf(f'<robot name="walker">{HUB}{spokes}</robot>', root="freeflyer")


def _recorded(robot: ik.Robot, legs: list[Any], hubs: list[Any], step: float) -> Any:
    """Return a recording of the legs' angles and the hub's places, ``step`` seconds apart."""
    q = []
    for leg, hub in zip(legs, hubs, strict=True):
        joints = {f"turn_{i}": angle for i, angle in enumerate(leg)}
        q.append(robot.configuration({"root_joint": [*hub, 0, 0, 0, 1], **joints}))
    return ik.measured.Recording(robot, step * np.arange(len(q)), q)


def _wheel(names: dict[str, Any]) -> Any:
    """Return four steps of the wheel, drawn on level ground."""
    alpha, slope, steps, shots = math.pi / 8, 0.08, 4, 20
    found = names["gait"](alpha, slope, 9.81)
    robot = _walker([i * math.pi / 4 for i in range(8)])
    legs, hubs = [], []
    for k in range(steps * shots):
        number, share = divmod(k, shots)
        theta = -alpha + 2 * alpha * share / shots
        foot = 2 * math.sin(alpha) * number
        hubs.append([foot + math.sin(theta), 0, math.cos(theta)])
        legs.append([theta + 2 * alpha * number] * 8)
    return _recorded(robot, legs, hubs, found.period / shots)


def _compass(names: dict[str, Any]) -> Any:
    """Return four steps of the gait; the legs change roles at each."""
    found, steps, shots = names["gait"](0.009), 4, 30
    from scipy.integrate import solve_ivp

    times = np.linspace(0.0, found.period, shots, endpoint=False)
    path = solve_ivp(lambda t, x: names["rates"](x, 0.009), (0, found.period), found.start,
                     t_eval=times, rtol=1e-9).y.T  # fmt: skip
    legs, hubs = [], []
    stride = 2 * math.sin(found.start[0])
    for number in range(steps):
        for theta, _, phi, _ in path:
            hubs.append([stride * number - math.sin(theta), 0, math.cos(theta)])
            stance, swing = -theta, phi - theta
            legs.append([stance, swing] if number % 2 == 0 else [swing, stance])
    return _recorded(_walker([0.0, 0.0]), legs, hubs, found.period / shots)


def _hopper(names: dict[str, Any]) -> Any:
    """Return the flights of the hopper from landing to landing, as its plan has them."""
    found, shots = names["plan"](10, 3.0, np.zeros(10)), 12
    robot = ik.Robot.from_urdf(names["MODELS"] / "rod.urdf", root="freeflyer")
    pitches, half = found["pitch"], names["HALF"]
    feet = np.array(names["followed"](pitches, found["time"]))
    # The middle flies along parabolas, the pitch turns evenly.
    middles = np.stack([feet - half * np.sin(pitches), half * np.cos(pitches)], axis=1)
    times, q, start = [], [], 0.0
    for k, flight in enumerate(found["time"].tolist()):
        for t in np.linspace(0.0, flight, shots, endpoint=False):
            share = t / flight
            pitch, (x, z) = (
                (1 - share) * each[k] + share * each[k + 1] for each in (pitches, middles)
            )
            z += names["GRAVITY"] * t * (flight - t) / 2.0
            place = [x + half * math.sin(pitch), 0, z - half * math.cos(pitch)]
            # The rod's own axis, its x, is turned upwards about y.
            turn = -(math.pi / 2 + pitch) / 2.0
            place += [0, math.sin(turn), 0, math.cos(turn)]
            q.append(robot.configuration(root_joint=place))
            times.append(start + t)
        start += flight
    return ik.measured.Recording(robot, np.array(times), q)


STAND_INS = {
    "hopper_to_target.py": _hopper,
    "tennis_racket.py": _racket,
    "which_law.py": _rod,
    "draw_struck_chain.py": _chain,
    "rimless_wheel.py": _wheel,
    "compass_gait.py": _compass,
}
