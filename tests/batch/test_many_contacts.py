"""Several contacts with friction: every answer satisfies the law, whichever it is."""

import pytest

import impulsekit as ik
from impulsekit.impact.laws import frictional
from impulsekit.impact.laws.modes import Modes
from tests.batch.compare import random_states

pytest.importorskip("numba")

CORNERS = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]


@pytest.mark.parametrize(("friction", "restitution"), [(0.5, 0.0), (0.7, 0.1), (0.3, 0.3)])
@pytest.mark.parametrize("spread", [0.1, 1.5])
def test_eight_foot_points(monkeypatch, friction, restitution, spread):
    talos = ik.Robot.from_example("talos", root="freeflyer")
    contacts = [
        ik.Contact(sole, at=at, friction=friction, restitution=restitution)
        for sole in ("left_sole_link", "right_sole_link")
        for at in CORNERS
    ]
    scene = ik.Scene(talos, contacts=contacts)
    q, v = random_states(talos, 16, spread=spread)
    v *= 0.2
    v[:, 2] -= 1.0
    batch = ik.solve_batch(scene, q, v, outputs=("v_after", "contact_impulses"))
    assert batch.plan.kernel
    assert batch.valid.all()
    problems = []

    class Seen(Exception):
        pass

    def keep(delassus, shifted, mu, floor=None):
        problems.append((delassus, shifted, mu))
        raise Seen

    # With friction and redundant points the law may have several answers, so each is held
    # against the law itself, on the matrices of the other way.
    monkeypatch.setattr(frictional, "solve_frictional", keep)
    for i in range(16):
        with pytest.raises(Seen):
            _ = ik.solve(scene, q[i], v[i]).dv
        modes = Modes(*problems[-1], None)
        assert modes.residual(batch.contact_impulses[i].ravel()) < 1e-9
