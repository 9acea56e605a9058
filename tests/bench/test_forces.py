"""Peak forces by peers: what is timed is the same impact, to 1 %."""

import numpy as np
import pytest

from benchmarks import forces, forces_exudyn


@pytest.mark.parametrize("name", ["ball", "Panda"])
def test_exudyns_spring_throws_the_contact_back_as_fast_as_it_came(name):
    pytest.importorskip("exudyn")
    problem = forces.STRUCK[name]()
    theirs = forces_exudyn._Theirs(problem)
    rows, _ = forces_exudyn.normal_rows(problem, forces_exudyn.mechanism_of(problem))
    before, after = (float(rows[0] @ v) for v in (problem.v, theirs.run(1.0)))
    assert before < 0.0
    assert after == pytest.approx(-before, rel=1e-3)
    assert forces_exudyn.FEWEST < theirs.steps < forces.MOST - 1
    assert np.allclose(theirs.run(2.0), 2.0 * theirs.run(1.0), rtol=1e-3)
