"""Ten table-tennis rackets: the stiffness along their rubber that turns spin back as was measured.

Springs along and across the rubber store the ball's slip and give it back. Inverted rubber returns
70 % of the rim's speed; long pips bend and let the spin pass; anti-spin rubber slips.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq

import impulsekit as ik

# [kg], [m]; a thin shell, whose rim weighs 2/5 of it for a push along the rubber.
MASS, RADIUS = 0.0027, 0.02
INERTIA = 2.0 / 3.0 * MASS * RADIUS**2
BALL = f"""<robot name="ball"><link name="ball">
<inertial><mass value="{MASS}"/>
<inertia ixx="{INERTIA}" iyy="{INERTIA}" izz="{INERTIA}" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><sphere radius="{RADIUS}"/></geometry></visual></link></robot>"""
# By racket: its rubber, e at rest and its fall per m/s, and k_p [kg], the impulse along the rubber
# over the rim's speed; T. Gossard, arXiv 2604.11349 (2026), github.com/gossardt/tt_rackets.
RACKETS = {
    1: ("inverted", 0.91721, 0.021704, 0.0018399),
    2: ("inverted, allround", 0.85853, 0.017581, 0.0018084),
    3: ("inverted, defensive", 0.88561, 0.023410, 0.0018632),
    4: ("inverted, slow", 0.81311, 0.017944, 0.0018122),
    5: ("long pips", 0.74882, 0.007339, 0.00080344),
    6: ("long pips, no sponge", 0.72887, 0.005474, 0.00066773),
    7: ("medium pips", 0.77221, 0.013814, 0.0013978),
    8: ("short pips", 0.86620, 0.016311, 0.0018699),
    9: ("inverted, on allround", 0.88443, 0.019232, 0.0018642),
}
ANTI_SPIN = ("anti-spin", 0.53578, 0.000451)
ANTI_SPIN_FRICTION = 0.189
# Rubber grips at more than this ball asks for.
GRIP = 1.5
SPIN = 300.0  # [rad/s]
SPEED = 6.0  # [m/s]


def hit(e: float, fall: float, friction: float, ratio: float) -> ik.Impact:
    """A spinning ball falls straight onto a rubber."""
    ball = ik.Robot.from_urdf(BALL, root="freeflyer")
    rubber = ik.Contact(
        "ball",
        at=[0, 0, -RADIUS],
        origin=[0, 0, -RADIUS],
        restitution=ik.RestitutionTable([0, 10], [e, e - 10 * fall]),
        friction=friction,
        stiffness_ratio=ratio,
        name="rubber",
    )
    scene = ik.Scene(ball, contacts=[rubber], law=ik.Law(slip="compliant"))
    return ik.solve(scene, ball.neutral(), [0, 0, -SPEED, 0, SPIN, 0])


def turned_back(impact: ik.Impact) -> float:
    """e_t: the speed of the rim after over that before, reversed."""
    before, after = (v[0] - RADIUS * v[4] for v in (impact.v_before, impact.v_after))
    return float(-after / before)


def ratio_of(e: float, fall: float, wanted: float) -> float:
    """The least stiffness along the rubber, over that across it, that gives an e_t."""
    # There both springs let go at once: half a period of one is the time of the other.
    most = (2.0 / (1.0 + e - fall * SPEED)) ** 2 / 2.5
    found = brentq(
        lambda x: turned_back(hit(e, fall, GRIP, math.exp(x))) - wanted, -7, math.log(most)
    )
    return math.exp(found)


def measured(k_p: float) -> float:
    """e_t of the impulse k_p times the rim's speed."""
    return 2.5 * k_p / MASS - 1.0


if __name__ == "__main__":
    print("racket                       e     e_t  stiffness ratio  spin after [rad/s]")
    rows = {}
    for number, (rubber, e, fall, k_p) in RACKETS.items():
        ratio = ratio_of(e, fall, measured(k_p))
        rows[f"{number:2} {rubber}"] = (f"{ratio:.3f}", hit(e, fall, GRIP, ratio))
    rubber, e, fall = ANTI_SPIN
    rows[f"10 {rubber}"] = ("rigid", hit(e, fall, ANTI_SPIN_FRICTION, math.inf))
    for name, (ratio, impact) in rows.items():
        print(
            f"{name:25} {impact.v_after[2] / SPEED:.3f}  {turned_back(impact):+.2f}"
            f"  {ratio:>15}  {impact.v_after[4]:18.1f}"
        )
