"""Balls, rods, blocks and robots that strike something, against closed forms."""

import numpy as np
import pytest

import impulsekit as ik

from . import EXAMPLES, printed, solved


def about(value, rel=1e-12):
    return pytest.approx(value, rel=rel, abs=1e-13)


def test_bouncing_ball():
    impact = solved("bouncing_ball")
    # µ is above (2/7) |v_t|/((1 + e) |v_n|): it rolls off with 5/7 of its speed along.
    assert 0.3 > 2 / 7 * 2 / (1.8 * 3)
    assert impact.velocity_at("ball/ball").after == about([10 / 7, 0, 2.4])
    assert impact.v_after[4] == about(10 / 7 / 0.05)
    assert impact.contacts[0].mode == "sticking"
    assert impact.contacts[0].impulse == about([-0.5 * 4 / 7, 0, 0.5 * 5.4])
    # Rebound, slip lost: ½ m (1 − e²) v_n² and ½ (2/7) m v_t².
    assert -impact.energy.change == about(0.25 * (0.36 * 9 + 2 / 7 * 4))


@pytest.mark.slow
def test_the_bouncing_ball_ends_up_rolling():
    file = ik.load_scene(EXAMPLES / "bouncing_ball.toml")
    motion = ik.simulate(file.scene, file.q, file.v, settings=file.motion)
    assert motion.status.finished
    # Bounces last 2 u/g each, with u = 2.4, 2.4 e, 2.4 e², ...
    rolls = 2 * 2.4 / 9.81 / (1 - 0.8)
    assert [rest.start for rest in motion.rests] == pytest.approx([rolls], abs=1e-5)
    # The impact at the start is the last that changes its speed along the floor.
    np.testing.assert_allclose(motion.q[:, 0], 10 / 7 * motion.t, atol=1e-8)
    np.testing.assert_allclose(motion.v[-1, 4], 10 / 7 / 0.05, rtol=1e-8)
    assert motion.q[:, 2].min() > 0.05 - 1e-8


def test_falling_rod():
    impact = solved("falling_rod")
    assert impact.contacts[0].impulse == about([0, 6 / 7, 0])
    assert impact.velocity_at("rod", [0.5, 0, 0]).after == about([0, -1 + 6 / 7, 0])
    assert impact.v_after[2] == about(-12 * 6 / 7 / 2 * 0.5)
    assert impact.contacts[0].velocity_after[1] == about(0.5)


@pytest.mark.slow
def test_falling_rods_at_all_angles():
    rows = np.array([[float(x) for x in line] for line in printed("falling_rod")[1:]])
    angles = np.radians(rows[:, 0])
    impulse = 1.5 / (1 + 3 * np.cos(angles) ** 2)
    assert rows[:, 0].tolist() == [0, 15, 30, 45, 60, 75, 90]
    assert rows[:, 1] == pytest.approx(impulse, abs=6e-6)
    assert rows[:, 2] == pytest.approx(impulse, abs=6e-6)
    assert rows[:, 3] == pytest.approx(6 * impulse * np.cos(angles), abs=6e-5)


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


@pytest.mark.slow
def test_standing_blocks_rock_on_and_lying_ones_stop():
    standing, lying = printed("rocking_block")[1:]
    assert standing[0] == "standing"
    assert float(standing[4]) == float(standing[3]) == pytest.approx(7 / 13, abs=1e-4)
    assert standing[5] == "separated"
    assert lying[0] == "lying"
    assert float(lying[3]) < 0
    assert float(lying[4]) == 0
    assert lying[5] == "sticking"


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


@pytest.mark.slow
def test_rough_floor_by_hand():
    """M Δq̇ = Jᵀ P for two rods, with the angles from the vertical, and the laws' own words."""
    after = {}
    for line in printed("rough_floor")[1:]:
        after[line[0], line[1]] = (*map(float, line[2:5]), line[5])
    a, b = np.radians([20, 30])
    e, friction = 0.7, 0.5
    mass = np.array([[4 / 3, np.cos(a - b) / 2], [np.cos(a - b) / 2, 1 / 3]])
    # Of the end, x towards -sin, z up; rates are those of the absolute angles.
    rows = np.array([[-np.cos(a), -np.cos(b)], [np.sin(a), np.sin(b)]])
    rates = np.array([-0.1, -0.2])
    before = rows @ rates
    across = rows @ np.linalg.solve(mass, rows.T)
    energy = rates @ mass @ rates / 2

    def kept(impulse):
        left = rates + np.linalg.solve(mass, rows.T @ impulse)
        return left @ mass @ left / 2 / energy

    # Newton, slip at the end: the end leaves at e times its approach, still sliding, now
    # towards -x, so that friction points to +x.
    pushed = -(1 + e) * before[1] / (across[1, 1] + friction * across[1, 0])
    impulse = pushed * np.array([friction, 1])
    velocity = before + across @ impulse
    assert velocity[0] < 0
    newton = after["newton", "end"]
    assert newton[:3] == pytest.approx((kept(impulse), *velocity), abs=6e-4)
    assert newton[0] > 2.7
    assert newton[3] == "ENERGY_GAIN"
    assert solved("rough_floor").energy.after / solved("rough_floor").energy.before == about(
        kept(impulse)
    )
    # Nothing else gains, and Newton's law along the path has its own word kept, too.
    for laws, (share, _, up, status) in after.items():
        if laws != ("newton", "end"):
            assert share < 1
            assert status == "SOLVED"
        if laws[0] == "newton":
            assert up == pytest.approx(-e * before[1], abs=6e-5)


def test_stronge_on_the_rough_floor_regains_e_squared_of_the_work():
    """The impact run in small steps of the normal impulse."""
    impact = solved("rough_floor")
    scene = ik.Scene(
        impact.scene.robot,
        contacts=impact.scene.contacts,
        law=ik.Law("stronge", "path"),
    )
    kept = ik.solve(scene, impact.q, impact.v_before)
    jacobian = contact_rows(impact)
    across = jacobian @ np.linalg.solve(impact.mechanics.mass_matrix, jacobian.T)
    step = 4e-6
    u = impact.contacts[0].velocity_before[[0, 2]]
    spent, regained = 0.0, 0.0
    while regained < 0.7**2 * spent or u[1] < 0:
        # µ = 0.5 is too little to hold the end once it stops: it slips back.
        following = u + across @ [-0.5 * np.sign(u[0]) * step, step]
        work = step * (u[1] + following[1]) / 2
        u = following
        if work < 0:
            spent -= work
        else:
            regained += work
    assert kept.contacts[0].velocity_after[[0, 2]] == pytest.approx(u, abs=1e-5)


def contact_rows(impact):
    """(2, 2) the Jacobian of the lower end, x and z."""
    a, b = np.radians([20, 30])
    absolute = np.array([[-np.cos(a), -np.cos(b)], [np.sin(a), np.sin(b)]])
    # The joints' rates: the first is the rod's own, the second adds to it.
    return absolute @ np.array([[1, 0], [1, 1]])


@pytest.mark.slow
def test_the_law_that_was_at_work_predicts_best():
    lines = printed("which_law")
    assert lines[1][:4] == ("Stronge,", "along", "the", "path")
    assert float(lines[1][4]) < 2.0 < float(lines[2][5])
    # The probability that another law is better.
    assert all(line[line.index("tip:") - 1] == "0.000" for line in lines[2:4])
