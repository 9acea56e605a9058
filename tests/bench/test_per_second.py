"""The cases of "Impacts per second": what is counted is solved."""

import pytest

import impulsekit as ik
from benchmarks.per_second import cases, chain, states_of, worst_residual


@pytest.mark.parametrize("name, scene, q, v", cases(), ids=lambda x: x if type(x) is str else "")
def test_every_impact_that_is_counted_holds(name, scene, q, v):
    many = states_of(scene, q, v, 100)
    assert ik.solve_batch(scene, *many).valid.all()
    assert worst_residual(scene, *many) < 1e-10


def test_a_chain_of_many_links_is_struck_at_its_end():
    scene = chain(20)
    impact = ik.solve(scene, scene.robot.neutral(), scene.robot.velocity())
    assert impact.residuals.largest < 1e-14
    assert abs(impact.dv[-1]) > 1.0
