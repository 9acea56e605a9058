"""Poisson's law gives back e times each share: where shares are open and e differs, so is v⁺."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog

import impulsekit as ik
from impulsekit.bench.stress.bodies import Link, robot_of
from impulsekit.impact.contact_space import ContactProblem, solve_contacts
from impulsekit.impact.contact_space.others import find_others

from ...motion.models import MODELS

POISSON = ik.Law("poisson")
BOX = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
PLACES = [(x, y) for x in (-0.15, 0.15) for y in (-0.1, 0.1)]


def struck(restitution, friction=0.0, law=POISSON):
    """A box that lands flat on its four corners, each with its e."""
    contacts = [
        ik.Contact("box", at=[x, y, -0.05], restitution=e, friction=friction)
        for (x, y), e in zip(PLACES, restitution, strict=True)
    ]
    q = BOX.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1])
    v = BOX.velocity(root_joint=[0.1, 0, -1, 0, 0, 0])
    return ik.solve(ik.Scene(BOX, contacts=contacts, law=law), q, v)


def released(share, e):
    """v of the box after its corners gave back e times their shares [N s], all sets tried."""
    body, places = BOX.model.inertias[1], np.array(PLACES)
    rows = np.c_[np.ones(4), places[:, 1], -places[:, 0]]
    W = rows / np.r_[body.mass, body.inertia.diagonal()[:2]] @ rows.T
    back = W @ (share * e)
    for closed in itertools.product([False, True], repeat=4):
        more, on = np.zeros(4), np.array(closed)
        more[on] = np.linalg.lstsq(W[np.ix_(on, on)], -back[on], rcond=None)[0]
        if more.min() >= -1e-12 and (back + W @ more).min() >= -1e-12:
            P = share * e + more
            z, *turns = rows.T @ P / np.r_[body.mass, body.inertia.diagonal()[:2]]
            return np.array([0.1, 0, z, *turns, 0])
    raise AssertionError("no set of closed corners obeys the law")


def test_other_shares_without_friction_are_told_with_their_velocities():
    e = np.array([0.2, 0.5, 0.5, 0.8])
    impact = struck(e)
    assert impact.status is ik.Status.NOT_UNIQUE
    assert impact.uniqueness.several and impact.uniqueness.settled
    # From two corners that carry all to the two others.
    mass = BOX.model.inertias[1].mass
    found = [impact.v_after, *impact.uniqueness.others]
    for share in ([0.25] * 4, [0.5, 0, 0, 0.5], [0, 0.5, 0.5, 0]):
        want = released(mass * np.array(share), e)
        assert min(np.abs(v - want).max() for v in found) < 1e-9
    assert ik.derivatives(impact).status.name == "RANK_CHANGES"


@pytest.mark.parametrize(("e", "law"), [([0.5] * 4, POISSON), ([0.2, 0.5, 0.5, 0.8], ik.Law())])
def test_one_e_or_newtons_law_leaves_one_velocity(e, law):
    assert struck(e, law=law).uniqueness.proven


def test_weak_friction_alone_proves_nothing_where_shares_come_back():
    impact = struck([0.2, 0.5, 0.5, 0.8], friction=1e-3)
    assert not impact.uniqueness.proven


def test_every_other_answer_is_e_times_a_share_that_holds():
    rng = np.random.default_rng(0)
    told = 0
    for _ in range(60):
        n, dof = int(rng.integers(2, 6)), int(rng.integers(1, 4))
        J = np.zeros((3 * n, dof))
        J[2::3] = rng.normal(size=(n, dof))
        W, u = J @ J.T, J @ rng.normal(size=dof)
        e = rng.choice([0.0, 0.3, 0.9], n)
        none = np.zeros(n)
        problem = ContactProblem(W, u, u, e, none, none)
        shown = solve_contacts(problem, POISSON)
        other = find_others(problem, POISSON, shown)
        pressed = solve_contacts(ContactProblem(W, u, u, none, none, none), ik.Law())
        middle = pressed.velocity_after[2::3]
        for P in other.impulses:
            told += 1
            normal, after = P[2::3], (u + W @ P)[2::3]
            assert after.min() > -1e-12
            assert 0.5 * P @ (2.0 * u + W @ P) <= 1e-12
            # Some share s ≥ 0 of that compression: (1 + e) s ≤ P, and = P where contacts part.
            parts, open_ = np.diag(1.0 + e)[after > 1e-9], np.eye(n)[middle > 1e-9]
            share = linprog(
                np.zeros(n),
                np.diag(1.0 + e),
                normal + 1e-9,
                np.vstack([W[2::3, 2::3], parts, open_]),
                np.r_[middle - u[2::3], normal[after > 1e-9], np.zeros(len(open_))],
            )
            assert share.status == 0
    assert told >= 5


@pytest.mark.parametrize("twice", [False, True])
@pytest.mark.parametrize("seed", [2, 3, 11, 20])
def test_rows_that_nearly_depend_leave_no_slip_of_rounding(seed, twice):
    """A point that may only rise, above an oblique plane: it must stick where it is stopped.

    The two couplings differ by 2e-3, so that both joints stand still, and a contact with what
    they hold has nothing to do with the point's: of one contact the friction impulse is the
    least, P_n c = m u, with c and s the cosine and sine of the plane. If the point touches twice,
    the compression of least |P|² lies on the edge of the cone, P_n (c + µ s) = m u. What comes
    back is e of that, and friction then brakes: v⁺ = e (c − µ s) P_n / m.
    """
    rng = np.random.default_rng(seed)
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    links = [
        Link(i - 1, m, joint="prismatic", axis=a)
        for i, (m, a) in enumerate(zip((0.4, 0.3, 0.2), axes, strict=True))
    ]
    robot = robot_of(links, "fixed")
    ratio = rng.uniform(0.5, 2.0)
    rows = [ik.JointCoupling("joint_0", "joint_1", r) for r in (ratio, ratio + 2e-3)]
    tilt, turn = rng.uniform(0.4, 0.9), rng.uniform(-np.pi, np.pi)
    c, s, mu, e = np.cos(tilt), np.sin(tilt), 0.2, 0.7
    normal = (s * np.cos(turn), s * np.sin(turn), c)
    touching = ("link_2", "link_2" if twice else "link_1")
    contacts = [ik.Contact(f, normal=normal, friction=mu, restitution=e) for f in touching]
    scene = ik.Scene(robot, constraints=rows, contacts=contacts, law=ik.Law("poisson"))
    v = np.append(rng.normal(size=2), -1.0)
    impact = ik.solve(scene, robot.neutral(), v)
    assert impact.status is ik.Status.NOT_UNIQUE
    want = e * (c - mu * s) / (c + mu * s if twice else c)
    np.testing.assert_allclose(impact.v_after, [0.0, 0.0, want], atol=1e-11)
