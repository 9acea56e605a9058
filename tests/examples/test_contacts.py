"""Balls, rods, blocks and robots that strike something, against closed forms."""

import runpy

import numpy as np
import pytest

import impulsekit as ik

from ..laws.test_compliant_angles import angle_after
from . import EXAMPLES, printed, solved


def about(value, rel=1e-12):
    return pytest.approx(value, rel=rel, abs=1e-13)


def test_bouncing_ball():
    impact = solved("bouncing_ball")
    # µ is above (2/7) |v_t|/((1 + e) |v_n|): it rolls off with 5/7 of its speed along.
    assert 0.3 > 2 / 7 * 2 / (1.8 * 3)
    assert impact.velocity_at("ball").after == about([10 / 7, 0, 2.4])
    assert impact.v_after[4] == about(10 / 7 / 0.05)
    assert impact.contacts[0].mode == "sticking"
    assert impact.contacts[0].impulse == about([-0.5 * 4 / 7, 0, 0.5 * 5.4])
    # Rebound, slip lost: ½ m (1 − e²) v_n² and ½ (2/7) m v_t².
    assert -impact.energy.change == about(0.25 * (0.36 * 9 + 2 / 7 * 4))


def test_hammer_and_nail():
    impact = solved("hammer_nail")
    robot = impact.scene.robot
    handle, head = (
        next(x for x in robot.links if x.name == f"hammer/{n}") for n in ("handle", "head")
    )
    mass = handle.mass + head.mass
    centre = (handle.mass * 0.15 + head.mass * 0.3125) / mass
    inertia = 0.0011334375 + handle.mass * (centre - 0.15) ** 2
    inertia += 0.00043385416666666664 + head.mass * (0.3125 - centre) ** 2
    # The hammer counts at its face as 1/(1/m + d²/I), with d from its mass centre.
    arm = 0.3125 - centre
    hammer = 1 / (1 / mass + arm**2 / inertia)
    impulse = 1.4 * (10 * 0.3125) * hammer * 0.0154 / (hammer + 0.0154)
    assert impact.contacts[0].impulse == about([impulse, 0, 0], rel=1e-10)
    assert impact.velocity_at("nail/nail").after == about([-impulse / 0.0154, 0, 0], rel=1e-10)
    butt = impulse * (1 / mass - centre * arm / inertia)
    assert impact.velocity_at("hammer/handle").after[0] == about(butt, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "speeds"),
    [("billiard", [-1 / 3, 2 / 3, 2 / 3]), ("billiard_sequential", [0, 0, 1])],
)
def test_billiard(name, speeds):
    impact = solved(name)
    for ball, speed in zip(("first", "second", "third"), speeds, strict=True):
        assert impact.velocity_at(f"{ball}/ball").after == about([speed, 0, 0])
    assert impact.energy.change == pytest.approx(0, abs=1e-15)


@pytest.mark.slow
def test_newtons_cradle():
    rows = printed("newtons_cradle")[1:]
    assert len(rows) == 6
    for count, order, *numbers in rows:
        n = int(count)
        *speeds, kept = map(float, numbers)
        if order == "sequential":
            wanted = [0] * (5 - n) + [1] * n
        else:
            # One pair of neighbours approaches; both sides rebound as wholes.
            left = n / 5 - (5 - n) / 5
            wanted = [left] * n + [2 * n / 5] * (5 - n)
        assert speeds == pytest.approx(wanted, abs=6e-3), (n, order)
        assert kept == 1


def test_rocking_block():
    impact = solved("rocking_block")
    assert impact.v_after[2] == about(7 / 13)
    left, right = impact.contacts
    assert left.mode == "sticking"
    assert right.mode == "separated"
    assert right.impulse == pytest.approx(np.zeros(3), abs=1e-15)
    assert right.velocity_after == about([0, 0.2 * 7 / 13, 0])
    # Energy goes with the square of the rate: both edges are equally far.
    assert impact.energy.after / impact.energy.before == about((7 / 13) ** 2)


def test_solo12_landing():
    impact = solved("solo12_landing")
    assert impact.status is ik.Status.SOLVED
    for result in impact.contacts:
        assert result.mode == "sticking"
        assert result.velocity_after == pytest.approx(np.zeros(3), abs=1e-12)
    # All that the floor gives is the momentum of the whole.
    total = sum(result.impulse for result in impact.contacts)
    assert total == about(momentum_jump(impact), rel=1e-11)
    # Left and right are nearly mirror images.
    front = [result.impulse for result in impact.contacts[:2]]
    assert front[0] == pytest.approx(front[1] * [1, -1, 1], rel=2e-3)


def test_talos_heel_strike():
    impact = solved("talos_heel_strike")
    assert impact.status is ik.Status.SOLVED
    modes = {result.name: result.mode for result in impact.contacts}
    # The heel stops, the toe slams down at once, and the unloaded right foot lifts off.
    assert all((mode == "sticking") == name.startswith("left") for name, mode in modes.items())
    for result in impact.contacts:
        assert result.unique == result.name.startswith("right")
        if result.name.startswith("left"):
            assert result.velocity_after == pytest.approx(np.zeros(3), abs=1e-12)
        else:
            assert result.velocity_after[2] > 1e-3
    total = sum(result.impulse for result in impact.contacts)
    assert total == about(momentum_jump(impact), rel=1e-11)


def momentum_jump(impact):
    """Σ m Δv of all links [N s]."""
    masses = {link.name: link.mass for link in impact.scene.robot.links}
    return sum(masses[name] * jump.dv_com for name, jump in impact.bodies.items())


def test_thrown_ball():
    impact = solved("thrown_ball")
    hit = impact.contacts[0]
    point = hit.points[0]
    centre = np.array([0.1, -0.0734, 0.66])
    # The ball meets the forearm a radius from its centre, where the normal says.
    assert centre - 0.05 * point.normal == pytest.approx(point.position, abs=1e-4)
    assert hit.velocity_after @ point.normal == about(-0.7 * hit.velocity_before @ point.normal)
    assert 0.5 * impact.bodies["ball/ball"].dv_com == about(hit.impulse)
    turned = 0.0005 * impact.bodies["ball/ball"].domega
    assert turned == about(np.cross(point.position - centre, hit.impulse), rel=1e-10)
    if hit.mode == "sticking":
        across = hit.velocity_after - (hit.velocity_after @ point.normal) * point.normal
        assert across == pytest.approx(np.zeros(3), abs=1e-12)


def test_racket_rubbers():
    """κ of racket 1 and of long pips: e_t in closed form, two springs and a last slip."""
    made = runpy.run_path(str(EXAMPLES / "racket_rubbers.py"))
    for number, e_t in ((1, 0.7036), (6, -0.3817)):
        _, e, fall, k_p = made["RACKETS"][number]
        assert made["measured"](k_p) == pytest.approx(e_t, abs=1e-4)
        ratio, e = made["ratio_of"](e, fall, made["measured"](k_p)), e - 6.0 * fall
        angle = ratio * 6.0 / (made["GRIP"] * 6.0)
        assert -angle_after(angle, 1.25 * ratio, e) / angle == pytest.approx(e_t, abs=1e-4)
    *_, anti_spin = printed("racket_rubbers")
    # It slips throughout: µ (1 + e) of the normal speed, five halves of it at the rim.
    rim = 6.0 - 2.5 * made["ANTI_SPIN_FRICTION"] * (1.0 + 0.53578 - 6.0 * 0.000451) * 6.0
    assert float(anti_spin[3]) == pytest.approx(-rim / 6.0, abs=0.006)
