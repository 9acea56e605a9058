"""Chang & Huston's method against Pinocchio on every robot of example-robot-data."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from impulsekit.errors import UrdfError
from impulsekit.reference import KaneSystem, Load

from .models import ROBOTS, jacobian_at, mass_matrix, pinocchio_model, random_state, relative

# Refused by the reference, and why.
REFUSED = {
    "romeo_description/urdf/romeo.urdf": "neither mass nor inertia",
    "romeo_description/urdf/romeo_laas_small.urdf": "neither mass nor inertia",
    "ur_description/urdf/ur3.urdf": "no link",
}
# Refused by Pinocchio, and why.
REFUSED_BY_PINOCCHIO = {"ur_description/urdf/ur3.urdf": "valid URDF"}
# Past a condition of 1e6 the bar on the velocity change rises with the condition.
ILL_CONDITIONED = {
    "alex_description/urdf/alex_psyonic_hands.urdf",
    "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
    "icub_description/robots/icub.urdf",
    "pr2_description/urdf/pr2.urdf",
    "talos_data/robots/talos_full_v2.urdf",
    "talos_data/robots/talos_full_v2_box.urdf",
    "tiago_description/robots/tiago_dual.urdf",
    "tiago_description/robots/tiago_no_hand.urdf",
    "tiago_pro_description/robots/tiago_pro.urdf",
}
READ = sorted(set(ROBOTS) - set(REFUSED))
BAR = 1e-11


@pytest.mark.slow
@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
@pytest.mark.parametrize("name", READ)
def test_masses_impulses_and_velocity_changes_agree(name, root):
    model = pinocchio_model(ROBOTS[name], root)
    system = KaneSystem.from_urdf(ROBOTS[name], root)
    assert [n for n in system.joint_names if system.joint(n).kind != "fixed"] == list(model.names)[
        1:
    ]
    assert system.n == model.nv
    rng = np.random.default_rng(len(name))
    for seed in range(2):
        q, v = random_state(model, seed)
        linear, angular, at = rng.normal(size=3), rng.normal(size=3), rng.uniform(-0.2, 0.2, 3)
        struck = str(rng.choice(system.link_names[len(system.link_names) // 2 :]))
        impact = system.impact(q, v, [Load(struck, linear, angular, at)])

        masses = mass_matrix(model, q)
        assert relative(impact.generalized_masses, masses) < BAR
        impulse = jacobian_at(model, q, struck, at).T @ np.concatenate([linear, angular])
        scale = max(np.abs(impulse).max(initial=0), 1.0)
        assert np.abs(impact.generalized_impulse - impulse).max(initial=0) < BAR * scale

        condition = np.linalg.cond(masses) if system.n else 1.0
        assert condition < 1e6 or name in ILL_CONDITIONED, f"cond(M) = {condition:.1e}"
        data = model.createData()
        pin.crba(model, data, q)
        pin.cholesky.decompose(model, data)
        dv = pin.cholesky.solve(model, data, impulse)
        assert relative(impact.dy, dv) < BAR * max(1.0, condition / 1e6)


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_a_refused_robot_is_refused_for_its_reason(name):
    with pytest.raises(UrdfError, match=REFUSED[name]):
        KaneSystem.from_urdf(ROBOTS[name])
    if name in REFUSED_BY_PINOCCHIO:
        with pytest.raises(ValueError, match=REFUSED_BY_PINOCCHIO[name]):
            pinocchio_model(ROBOTS[name])
    else:
        # Pinocchio reads it, and its mass matrix has directions without mass.
        model = pinocchio_model(ROBOTS[name])
        assert mass_matrix(model, random_state(model, 0)[0]).diagonal().min() == 0
