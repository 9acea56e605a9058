"""Problems of contacts that do not act on each other: as each group alone, under every law."""

import numpy as np
import pytest
from scipy.linalg import block_diag

from impulsekit.errors import InputError
from impulsekit.impact.contact_space import ContactProblem, solve_contacts
from impulsekit.impact.contact_space.groups import groups_of
from impulsekit.impact.contact_space.others import find_others
from impulsekit.laws.status import Status
from impulsekit.scene.law import Law

LAWS = [
    Law(),
    Law("poisson"),
    Law("newton", "path"),
    Law("poisson", "path"),
    Law("stronge", "path"),
    Law("lzb", "path"),
]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.slip}")


def body(rng, n, mu=0.4, lean=0.3):
    """Contacts of a body of its own, most of which approach."""
    J = np.tile(np.eye(3), (n, 1)) + lean * rng.normal(size=(3 * n, 3))
    J = np.hstack([J, lean * rng.normal(size=(3 * n, 3 * n))])
    before = 0.5 * rng.normal(size=3 * n)
    before[2::3] = -1.0 - rng.random(n)
    return ContactProblem(
        J @ J.T, before, before, np.full(n, 0.5), np.full(n, mu), np.zeros(n), np.full(n, 1e5)
    )


def beside(*parts):
    """The parts in one problem."""
    names = (
        "velocity_before", "velocity_free", "restitution", "friction", "tangential_restitution",
        "stiffness",
    )  # fmt: skip
    return ContactProblem(
        block_diag(*(part.delassus for part in parts)),
        *(np.concatenate([getattr(part, name) for part in parts]) for name in names),
    )


@every_law
@pytest.mark.parametrize("seed", range(6))
def test_contacts_do_what_their_group_does_alone(law, seed):
    rng = np.random.default_rng(seed)
    # Along the path of one contact no group may have two.
    most = 2 if law.slip == "path" and law.restitution != "lzb" else 4
    parts = [body(rng, int(rng.integers(1, most))) for _ in range(3)]
    both = solve_contacts(beside(*parts), law)
    alone = [solve_contacts(part, law) for part in parts]
    for name in ("impulse", "velocity_after", "velocity_start", "normal_work", "friction_work"):
        expected = np.concatenate([getattr(one, name) for one in alone])
        np.testing.assert_allclose(getattr(both, name), expected, rtol=1e-13, atol=1e-14)
    assert both.status in [one.status for one in alone]
    assert both.residual == max(one.residual for one in alone)


@every_law
def test_contacts_that_are_alone_leave_nothing_open(law):
    rng = np.random.default_rng(1)
    plain = body(rng, 1)
    problem = beside(plain, body(rng, 1))
    assert [members.tolist() for members in groups_of(problem)] == [[0], [1]]
    solution = solve_contacts(problem, law)
    assert solution.status is Status.SOLVED
    assert solution.unique is None
    assert find_others(problem, law, solution).verdict == "proven"


def test_a_wedged_contact_says_the_same_beside_a_ball():
    """It parts, and friction could press it in as well: the rule of parting stays the law's own."""
    W = np.array([[4.0, 0.0, -3.0], [0.0, 4.0, 0.0], [-3.0, 0.0, 2.5]])
    before = np.array([-1.0, 0.0, 0.2])
    none, mu = np.zeros(1), np.full(1, 2.0)
    wedge = ContactProblem(W, before, before, none, mu, none, np.ones(1))
    alone = solve_contacts(wedge, Law())
    found = find_others(wedge, Law(), alone)
    ball = body(np.random.default_rng(2), 1)
    problem = beside(wedge, ball)
    both = solve_contacts(problem, Law())
    beside_it = find_others(problem, Law(), both)
    assert found.verdict == "several" and found.settled
    assert (both.status, beside_it.verdict, beside_it.settled) == (alone.status, "several", True)
    assert (beside_it.reason, beside_it.rule) == (found.reason, found.rule)
    assert len(beside_it.impulses) == len(found.impulses) > 0
    for P, own in zip(beside_it.impulses, found.impulses, strict=True):
        np.testing.assert_allclose(P[:3], own, rtol=1e-12)
        np.testing.assert_array_equal(P[3:], both.impulse[3:])


def test_two_that_act_on_each_other_are_refused_along_the_path():
    problem = body(np.random.default_rng(3), 2)
    for one in (problem, beside(body(np.random.default_rng(4), 1), problem)):
        with pytest.raises(InputError, match="more than one of the"):
            solve_contacts(one, Law("stronge", "path"))


def test_messages_name_the_contacts_of_the_scene():
    rng = np.random.default_rng(5)
    rigid = body(rng, 2)
    rigid.stiffness[1] = np.inf
    with pytest.raises(InputError, match="contact 2 is approached"):
        solve_contacts(beside(body(rng, 1), rigid), Law("lzb", "path"))


def test_a_gain_of_energy_is_avoided_in_its_group_alone():
    """Newton's restitution with friction may gain energy; the other group is left as it is."""
    for seed in range(400):
        rng = np.random.default_rng(seed)
        rough = body(rng, 2, mu=1.5, lean=1.0)
        alone = solve_contacts(rough, Law())
        if alone.status is Status.ENERGY_GAIN:
            break
    assert alone.status is Status.ENERGY_GAIN
    ball = body(rng, 1)
    both = solve_contacts(beside(rough, ball), Law())
    assert both.status is Status.ENERGY_GAIN
    np.testing.assert_array_equal(both.impulse[:6], alone.impulse)
    np.testing.assert_array_equal(both.impulse[6:], solve_contacts(ball, Law()).impulse)


@pytest.mark.parametrize("slip", ["end", "path"])
def test_energy_gained_in_turn_is_not_paid_by_what_lies_apart(slip):
    """Newton's hits may gain where contacts are coupled; what is lost elsewhere hides nothing."""
    law, gained = Law("newton", slip, "sequential"), 0
    heavy = ContactProblem(
        0.2 * np.eye(3), np.array((0.0, 0.0, -20.0)), np.array((0.0, 0.0, -20.0)),
        np.zeros(1), np.zeros(1), np.zeros(1), np.ones(1),
    )  # fmt: skip
    for seed in range(60):
        rng = np.random.default_rng(seed)
        J = rng.normal(size=(6, 3))
        u, two = J @ rng.normal(size=3), np.ones(2)
        part = ContactProblem(J @ J.T, u, u, 0.8 * two, 0.8 * two, 0.0 * two, two)
        alone = solve_contacts(part, law)
        both = solve_contacts(beside(heavy, part), law)
        assert both.status is alone.status
        gained += alone.status is Status.ENERGY_GAIN
    assert gained >= 2
