"""Contacts in a plane and scenes written in other ways: small shares of both sweeps."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.bench.stress.in_plane import STATES, SWEEPS, judged, plane_scene
from impulsekit.bench.stress.mechanisms import built, random_world
from impulsekit.bench.stress.rewritten import REWRITTEN
from impulsekit.bench.stress.rewritten import SWEEPS as REWRITTEN_SWEEPS
from impulsekit.bench.stress.run import jobs_of, solved_case, sweep_named
from impulsekit.bench.stress.told import Told
from impulsekit.bench.truths.enumerated import PlaneProblem, whole_answers
from impulsekit.bench.urdf import joint_text, link_text, robot_text


@pytest.mark.slow
@pytest.mark.parametrize("sweep", SWEEPS, ids=lambda sweep: sweep.name)
def test_every_answer_in_a_plane_is_one_of_all_modes_and_several_are_told(sweep):
    points = [p for job in jobs_of([sweep], seed=1, share=4 / 500) for p in solved_case(job)]
    assert len(points) == 4 * 4 * 6 * 2
    assert [p for p in points if p.verdict == "wrong"] == []
    assert sum(p.verdict == "right" for p in points) > len(points) // 3


@pytest.mark.slow
def test_scenes_written_in_other_ways_have_the_same_answer():
    jobs = jobs_of(REWRITTEN_SWEEPS, seed=1, share=6 / 2500)
    points = [p for job in jobs for p in solved_case(job)]
    assert {p.method for p in points} >= {"moved", "mirrored", "units", "order", "split", "batch"}
    assert [p for p in points if p.verdict == "wrong"] == []


@pytest.mark.parametrize(
    ("contacts", "place"),
    [
        # The least split was 1e-13 off, and another taken in its place: v⁺ moved by 0.08.
        (3, (2, 83, 902)),
        # Of two answers the one was found that the directions of the tangents led to.
        (4, (3, 89, 2)),
    ],
)
def test_which_answer_is_found_knows_no_units_and_no_axes(contacts, place):
    (sweep,) = REWRITTEN_SWEEPS
    rng = sweep.rng(*place)
    world = random_world(contacts, rng)
    scene, q, v = built(world)
    first = ik.solve(scene, q, v)
    for name, rewrite in REWRITTEN.items():
        other = rewrite(world, rng)
        if name in ("moved", "units", "order"):
            scene, q, v = built(other.world)
            back = (ik.solve(scene, q, v).v_after - other.shift) / other.ratio
            np.testing.assert_allclose(back, first.v_after, rtol=0, atol=1e-11)


def test_other_answers_are_told_where_one_load_has_many_shares():
    # Some fifty shares of one compression, with all their expansions, hid the other compression.
    (sweep,) = (one for one in SWEEPS if one.name == "plane-poisson")
    rng = sweep.rng(3, 7, 2)
    case = plane_scene(4, ik.Law(restitution="poisson"), rng)
    v = rng.normal(size=(4, case.rows.shape[1]))[3]
    impact = ik.solve(case.scene, case.scene.robot.neutral(), v)
    assert impact.status is ik.Status.MANY_SOLUTIONS
    found = sorted(np.abs(one).max() for one in (impact.v_after, *impact.uniqueness.others))
    np.testing.assert_allclose(found, [0.0, 1.055675], atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "place,repeat,seed",
    [
        pytest.param(3, 288, 31, id="slip of a contact without a load"),
        pytest.param(0, 405, 34, id="a contact across a locked joint"),
        pytest.param(3, 28, 36, id="shares that hold"),
        pytest.param(1, 28, 41, id="another answer by another share"),
        pytest.param(3, 190, 41, id="directions of the tangents"),
        pytest.param(3, 27, 44, id="where Newton's method wandered to"),
        pytest.param(0, 495, 44, id="the rounding of what cannot move"),
        pytest.param(3, 12, 46, id="loads beyond all measure"),
        pytest.param(3, 96, 46, id="slip that turns by rounding in a long series"),
        pytest.param(3, 434, 47, id="what hits of light bodies hand on"),
        pytest.param(1, 1290, 0, id="slip by the rounding of constraints"),
        pytest.param(2, 564, 0, id="shares of a slow series"),
        pytest.param(3, 1040, 0, id="rounding that hits hand on"),
        pytest.param(3, 346, 0, id="an answer that no iteration comes to"),
        pytest.param(3, 2217, 0, id="several answers of four that rub"),
    ],
)
def test_rounding_decides_nothing(place, repeat, seed):
    points = solved_case(("rewritten", place, repeat, seed))
    assert len(points) >= 8
    assert {point.verdict for point in points} in ({"right"}, {"said so"})


@pytest.mark.slow
def test_an_answer_is_found_where_sweeps_diverge():
    """On one body whatever its axes, with nothing to swap."""
    points = solved_case(("rewritten", 3, 492, 48))
    assert {point.method for point in points} > {"moved", "mirrored", "units", "order", "split"}
    assert {point.verdict for point in points} == {"right"}


@pytest.mark.parametrize(
    "place,repeat,seed",
    [
        pytest.param(1, 269, 1, id="another answer for what rests and is struck"),
        pytest.param(0, 232, 1, id="a contact on what is pinned, beside what moves"),
        pytest.param(3, 227, 1, id="constraints of what hardly moves"),
    ],
)
def test_a_blow_is_the_velocity_that_it_leaves(place, repeat, seed):
    points = solved_case(("struck", place, repeat, seed))
    assert {point.method for point in points} == {"velocity", "batch", "velocity in a batch"}
    assert {point.verdict for point in points} in ({"right"}, {"said so"})


@pytest.mark.slow
@pytest.mark.parametrize("sweep", SWEEPS, ids=lambda sweep: sweep.name)
def test_of_many_scenes_in_a_plane_none_is_silently_wrong(sweep):
    points = [p for job in jobs_of([sweep], seed=2, share=0.01) for p in solved_case(job)]
    assert [p for p in points if p.verdict == "wrong"] == []


@pytest.mark.slow
@pytest.mark.parametrize("sweep", REWRITTEN_SWEEPS, ids=lambda sweep: sweep.name)
def test_of_many_scenes_written_in_other_ways_none_has_another_answer(sweep):
    points = [p for job in jobs_of([sweep], seed=2, share=0.01) for p in solved_case(job)]
    assert [p for p in points if p.verdict == "wrong"] == []


def test_the_truth_knows_loads_of_rows_that_depend_on_each_other_up_to_rounding():
    """A body that slides on a second one, held to it at two points: four rows of rank three, to
    fractions of rank four. The answer is lawful; another 1e-6 beside it is not."""
    sweep = sweep_named("plane-newton")
    rng = sweep.rng(2, 19, 43)
    case = plane_scene(3, ik.Law(), rng)
    v = rng.normal(size=(STATES, case.rows.shape[1]))[3]
    impact = ik.solve(case.scene, case.scene.robot.neutral(), v)
    inverse = np.array(case.inverse_masses)
    told = [
        Told("SOLVED", True, True, False, impact.v_after + beside * inverse)
        for beside in (0.0, 1e-6 / inverse.max())
    ]
    assert [judged(case, [], v, one)[1] for one in told] == ["right", "wrong"]


def test_the_truth_knows_poissons_law_of_a_ball_on_a_floor():
    # Compression with friction µ = 0.2 at slip 1: P = (−0.2, 1); release adds e of it.
    rows, inverse = [[1.0, 0.0], [0.0, 1.0]], [1.0, 1.0]
    problem = PlaneProblem(rows, inverse, [1.0, -1.0], [0.2], [0.5])
    (only,) = whole_answers(problem, "poisson")
    np.testing.assert_allclose(only.velocity, [1.0 - 0.2 * 1.5, 0.5], atol=1e-15)
    assert not only.gains


def test_the_truth_finds_both_ways_of_a_contact_that_friction_could_press_in():
    # One motion, (t, n) = (4, 1) of it: it parts, or sticks by friction.
    problem = PlaneProblem([[4.0], [1.0]], [1.0], [1.0], [2.0], [0.0])
    found = sorted(one.velocity.item() for one in whole_answers(problem, "newton"))
    assert found == [0.0, 1.0]


def slider_on_a_slope(friction):
    """A block that slides along (4, 1, 0) and touches the floor."""
    slide = joint_text("j", "prismatic", "base", "b", "4 1 0", far=9)
    robot = ik.Robot.from_urdf(robot_text("r", link_text("base"), link_text("b", 1), slide))
    contact = ik.Contact("b", normal=[0, 1, 0], friction=friction)
    return ik.Scene(robot, contacts=[contact])


def test_a_lone_contact_that_parts_gets_no_impulse_and_the_other_answer_is_told():
    # µ > 1/4 wedges the block, and then v⁺ = 0 obeys Coulomb's law as well.
    for friction, wedges in ((0.2, False), (0.3, True), (2.0, True)):
        scene = slider_on_a_slope(friction)
        impact = ik.solve(scene, [0.0], [1.0])
        assert impact.is_valid() and impact.v_after[0] == 1.0
        assert impact.uniqueness.several == wedges and impact.uniqueness.proven != wedges
        for other in impact.uniqueness.others:
            np.testing.assert_allclose(other, 0.0, atol=1e-12)
        batch = ik.solve_batch(scene, [[0.0]], [[1.0]])
        assert batch.uniqueness[0] == (2 if wedges else 0) and batch.status[0] == impact.status
