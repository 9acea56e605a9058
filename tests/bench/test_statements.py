"""Laws of contact against their own statements: a small share, and faults that are seen."""

import copy
import dataclasses

import numpy as np
import pytest

from impulsekit.bench.stress import paths, statements
from impulsekit.bench.stress.run import jobs_of, solved_case
from impulsekit.bench.stress.statements import SWEEPS
from impulsekit.bench.truths import along_paths, slip
from impulsekit.bench.truths.along_paths import Planar, follow_in_time
from impulsekit.reference import Arithmetic

SHARES = {"statement-turning": 8, "statement-adhesion": 10, "statement-friction": 8}


@pytest.mark.slow
@pytest.mark.parametrize("sweep", [*SWEEPS, *paths.SWEEPS], ids=lambda sweep: sweep.name)
def test_every_answer_obeys_its_statement(sweep):
    share = SHARES.get(sweep.name, 1) / sweep.repeats
    points = [p for job in jobs_of([sweep], seed=5, share=share) for p in solved_case(job)]
    assert [p for p in points if p.verdict == "wrong"] == []
    assert sum(p.verdict == "right" for p in points) > 0.9 * len(points)


@pytest.mark.slow
@pytest.mark.parametrize("sweep", [*SWEEPS[:3], *paths.SWEEPS], ids=lambda sweep: sweep.name)
def test_an_impulse_that_is_off_is_seen(sweep, monkeypatch):
    """A thousandth more of all impulses breaks every statement."""
    plain = statements.find_impulses

    def off(problem, law):
        found = plain(problem, law)
        return dataclasses.replace(found, impulse=1.001 * found.impulse)

    monkeypatch.setattr(statements, "find_impulses", off)
    points = sweep.cases(2.0, np.random.default_rng(2))
    moved = [p for p in points if p.error > 0.0]
    assert moved and sum(p.verdict == "wrong" for p in moved) >= len(moved) // 2


@pytest.mark.parametrize(
    ("u", "e", "mu"), [((2.0, -1.0), 0.5, 0.3), ((0.4, -1.0), 0.7, 0.8), ((0.3, -2.0), 1.0, 0.1)]
)
def test_a_path_followed_in_time_is_the_one_in_closed_form(u, e, mu):
    """One contact whose slip goes on, turns back or sticks: Stronge's law by its quadrature."""
    W = np.array([[3.0, 0.0, -1.4], [0.0, 1.0, 0.0], [-1.4, 0.0, 1.5]])
    line = np.array([u[0], 0.0, u[1]])
    known = slip.followed(Arithmetic.double(), W, line, e, mu, "stronge")
    turned = W[np.ix_([2, 0], [2, 0])]
    one, rub = np.array([e]), np.array([[mu]])
    found = follow_in_time(Planar(turned, np.array([u[1], u[0]]), one, np.ones(1), 1.5, rub))
    assert np.abs(found - known[[2, 0]]).max() < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(("points", "seed"), [(2, 0), (3, 1), (3, 2), (4, 3), (4, 4)])
def test_corners_that_share_their_friction_on_one_floor(points, seed):
    """Rods and boxes that stick and slip on several corners, with dependent tangents."""
    rng = np.random.default_rng([0, points, seed])
    problem, planar, at = paths._planar(points, rng, stands=True)
    judged = statements.energetic(problem, paths.Law("lzb", exponent=planar.power))
    after = planar.free + planar.W @ follow_in_time(planar)
    assert judged.left < 1e-9
    assert np.abs(after - judged.solution.velocity_after[at]).max() < 1e-9


def test_slow_slip_of_a_contact_that_holds_has_its_direction():
    """Slip at 4 % of the velocities before: what is left of the law turns it by much more."""
    [state] = [p for p in solved_case(("statement-adhesion", 2, 333, 57)) if p.state == 2]
    assert state.verdict == "right" and state.error < 1e-13


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "repeat", "seed", "state"),
    [
        (3, 223, 0, 5), (2, 360, 0, 4), (1, 262, 0, 4), (2, 54, 0, 5), (3, 125, 0, 2),
        (3, 141, 0, 2), (3, 29, 77, 0),
    ],
    ids=["slip passed over", "met again", "rod", "held", "box", "three corners", "out of its cone"],
)  # fmt: skip
def test_changes_within_one_step_or_at_several_points_at_once(
    place, repeat, seed, state, monkeypatch
):
    """What ends and comes back within one step; dependent points that start together."""
    drawn, energetic, follow = [], paths.energetic, paths.follow_in_time
    monkeypatch.setattr(paths, "energetic", lambda *args: drawn.append(0) or energetic(*args))
    # The states before it are drawn alone.
    monkeypatch.setattr(
        paths, "follow_in_time", lambda planar: follow(planar) if len(drawn) > state else None
    )
    monkeypatch.setattr(statements, "STATES", state + 1)
    found = solved_case(("statement-path", place, repeat, seed))[state]
    assert found.verdict == "right" and found.error < 1e-9


@pytest.mark.parametrize(("place", "repeat", "seed", "state"), [(2, 80, 70, 5), (3, 2653, 74, 4)])
def test_steps_spent_on_the_modes_leave_some_for_the_last_digits(place, repeat, seed, state):
    """Newton from contacts that all stick: 2e-9 of the impulses were left after 8 steps."""
    found = solved_case(("statement-friction", place, repeat, seed))[state]
    assert found.verdict == "right" and found.error < 1e-14


@pytest.mark.slow
def test_slip_from_rest_soon_has_a_direction_of_its_own():
    """Friction against the acceleration up to 3e-7 of the velocities left 3e-8 of them."""
    [state] = solved_case(("statement-path-space", 2, 3, 79))
    assert state.verdict == "right" and state.error < 1e-8


@pytest.mark.slow
def test_what_is_passed_within_a_step_does_not_hang_on_the_steps_of_the_truth(monkeypatch):
    """Friction that leaves its cone for a moment: 4e-8 apart where one way did not see it."""
    rng = paths.SWEEPS[0].rng(3, 29, 77)
    assert rng.random() >= paths.IN_SPACE
    _, planar, _ = paths._planar(4, rng, stands=bool(rng.random() < paths.STANDING))
    again = copy.deepcopy(planar)
    after = planar.free + planar.W @ follow_in_time(planar)
    monkeypatch.setattr(along_paths, "RTOL", 3e-14)
    assert np.abs(again.free + again.W @ follow_in_time(again) - after).max() < 1e-10
