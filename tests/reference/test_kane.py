"""Kane's equations and the impact equations, against exact answers and against Pinocchio."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pinocchio as pin
import pytest

from impulsekit.errors import ContradictionError
from impulsekit.reference import Arithmetic, JointSpring, KaneSystem, Load, PointSpring, Rows
from impulsekit.reference.whittaker import struck_chain, struck_pendulum

from .models import (
    EVERY_KIND,
    ROBOTS,
    pinocchio_model,
    random_state,
    relative,
    rods,
    spatial_impulse,
)

FIFTY = Arithmetic.mpmath(50)
TEN_ROBOTS = [
    "a1_description/urdf/a1.urdf",
    "anymal_c_simple_description/urdf/anymal.urdf",
    "baxter_description/urdf/baxter.urdf",
    "double_pendulum_description/urdf/double_pendulum_continuous.urdf",
    "g1_description/urdf/g1_29dof_rev_1_0.urdf",
    "kinova_description/robots/kinova.urdf",
    "panda_description/urdf/panda.urdf",
    "solo_description/robots/solo12.urdf",
    "talos_data/robots/talos_reduced.urdf",
    "ur_description/urdf/ur5_robot.urdf",
]
GRAVITY = np.array([0.3, -0.2, -9.81])


def exactly(fractions):
    """Exact fractions as 50-digit numbers."""
    return np.array([FIFTY.number(value) for value in fractions], dtype=object)


# -- Kane's equations (17) ------------------------------------------------------------


def error_against_aba(name, root="freeflyer"):
    model, system = pinocchio_model(ROBOTS[name], root), KaneSystem.from_urdf(ROBOTS[name], root)
    q, y = random_state(model, 8)
    torque = np.random.default_rng(9).normal(size=model.nv)
    model.gravity.linear = GRAVITY
    wanted = pin.aba(model, model.createData(), q, y, torque)
    torques = {
        joint: torque[system.joint(joint).speeds]
        for joint in system.joint_names
        if system.joint(joint).kind != "fixed"
    }
    found = system.accelerations(q, y, GRAVITY, joint_torques=torques)
    return relative(found, wanted)


@pytest.mark.parametrize("name", TEN_ROBOTS)
def test_accelerations_are_pinocchios_with_gravity_and_velocity(name):
    assert error_against_aba(name) < 1e-10


@pytest.mark.parametrize("root", ["fixed", "planar", "freeflyer"])
def test_accelerations_of_every_kind_of_joint(root):
    model, system = pinocchio_model(EVERY_KIND, root), KaneSystem.from_urdf(EVERY_KIND, root)
    q, y = random_state(model, 11)
    data = model.createData()
    model.gravity.linear = GRAVITY
    pin.framesForwardKinematics(model, data, q)
    outside = [pin.Force.Zero() for _ in range(model.njoints)]
    loads = [
        Load("tool", (1, 2, 3), (0.1, -0.2, 0.3), (0.4, 0.1, 0)),
        Load("drone", (-2, 0, 1), (0, 0.5, 0), (0, 0, 0.2)),
    ]
    for load in loads:
        owner, force = spatial_impulse(model, data, load.link, load.linear, load.angular, load.at)
        outside[owner] += force
    wanted = pin.aba(model, data, q, y, np.zeros(model.nv), outside)
    assert relative(system.accelerations(q, y, GRAVITY, loads), wanted) < 1e-12


def test_springs_give_back_what_they_store():
    """The power of the springs is the rate at which their energy falls, less the dampers'."""
    system = KaneSystem.from_urdf(EVERY_KIND, "freeflyer")
    model = pinocchio_model(EVERY_KIND, "freeflyer")
    q, y = random_state(model, 13)
    springs = [
        JointSpring("elbow", stiffness=7, damping=0.3, rest=0.2),
        JointSpring("zeta", stiffness=5, rest=-0.1),
        JointSpring("alpha", stiffness=3, rest=0.4),
        PointSpring("arm", "drone", (0.1, 0, 0), (0, 0.2, 0), 11, 0.7, 0.3),
        PointSpring("world", "wheel", (1, 2, 3), (0, 0, 0.1), stiffness=2, rest_length=1),
    ]

    def stored(time):
        here = pin.integrate(model, q, y * time)
        at, tree = system.kinematics(here), system

        def end(link, point):
            k = tree.body_of_link(link)
            return np.array(point) if k < 0 else at.origins[k] + at.rotations[k] @ point

        def angle(joint):
            own = here[tree.joint(joint).coordinates]
            return own[0] if len(own) == 1 else np.arctan2(own[1], own[0])

        total = 0.0
        for spring in springs:
            if isinstance(spring, JointSpring):
                stretch = angle(spring.joint) - spring.rest
            else:
                ends = end(spring.link, spring.at) - end(spring.other, spring.other_at)
                stretch = np.linalg.norm(ends) - spring.rest_length
            total += spring.stiffness * stretch**2 / 2
        length = np.linalg.norm(end("arm", (0.1, 0, 0)) - end("drone", (0, 0.2, 0)))
        return total, length

    step = 1e-5
    (ahead, longer), (behind, shorter) = stored(step), stored(-step)
    lost = 0.3 * y[system.joint("elbow").speeds][0] ** 2
    lost += 0.7 * ((longer - shorter) / (2 * step)) ** 2
    power = system.generalized_active_force(q, y, springs=springs) @ y
    assert power == pytest.approx(-(ahead - behind) / (2 * step) - lost, rel=1e-8)


# -- chains whose answers are fractions -------------------------------------------------


def struck_end(count, mass, length, inertia, impulse, hang):
    """The chain of rods struck across its free end, every decimal exact, in 50 digits."""
    system = KaneSystem.from_urdf(
        rods(count, mass, length, inertia, hang),
        "fixed" if hang else "planar",
        arithmetic=FIFTY,
        exact_decimals=True,
    )
    end = [FIFTY.number(length), 0, 0]
    blow = Load(f"rod_{count}", (0, FIFTY.number(impulse), 0), at=end)
    return system, system.impact(system.neutral(), [0] * system.n, [blow])


CASES = {
    # 10 links of 12 kg and 1 m: m l²/12 is 1 kg m²; 60 N s on 12 kg is Whittaker's 5 on 1.
    "whittaker": ("12", "1", "1", "60", False, struck_chain),
    # 1 slug, 1 ft, 30 lbf s: m l²/12 = 14.5939 · 0.3048²/12 kg m², a decimal as well.
    "pendulum": ("14.5939", "0.3048", "0.112984806288", "133.447", True, struck_pendulum),
}


@pytest.mark.parametrize("case", CASES)
def test_a_struck_chain_moves_as_the_fractions_say_to_forty_digits(case):
    mass, length, inertia, impulse, hang, exact = CASES[case]
    assert Fraction(mass) * Fraction(length) ** 2 / 12 == Fraction(inertia)
    chain = exact(10, mass, length, impulse)
    system, impact = struck_end(10, mass, length, inertia, impulse, hang)
    rods_of = [system.body_of_link(f"rod_{k}") for k in range(10, 0, -1)]
    centres = impact.body_dv[rods_of, 1] - exactly(chain.centre_velocities)
    spins = impact.body_domega[rods_of, 2] - exactly(chain.link_rates)
    assert np.abs(centres).max() < 1e-40 * float(chain.point_velocities[0])
    assert np.abs(spins).max() < 1e-40 * float(max(chain.link_rates))
    assert abs(impact.energy_after - exactly([chain.energy])[0]) < 1e-40 * float(chain.energy)


@pytest.mark.parametrize("case", CASES)
def test_freed_joints_carry_whittakers_pin_impulses(case):
    mass, length, inertia, impulse, hang, exact = CASES[case]
    chain = exact(10, mass, length, impulse)
    _, impact = struck_end(10, mass, length, inertia, impulse, hang)
    for k in range(1, 11 if hang else 10):
        # S_k is what link k, counted from the struck end, gives the next one, which is
        # nearer to the root: minus what the parent gives the child.
        reaction = impact.joint_reaction(f"pin_{11 - k}")
        wanted = np.array([0, -exactly(chain.pin_impulses)[k], 0, 0, 0, 0])
        assert np.abs(reaction - wanted).max() < 1e-40 * float(chain.impulse)
    if not hang:
        assert not impact.joint_reaction("root_joint").any()


# -- impacts of robots ---------------------------------------------------------------------


@pytest.mark.parametrize("numbers", [Arithmetic.double(), FIFTY])
def test_rows_that_contradict_each_other_are_named(numbers):
    system = KaneSystem.from_urdf(rods(2, "12", "1", "1"), "planar", arithmetic=numbers)
    q, y = system.neutral(), [1, 2, 3, 4]
    still, moving = (
        system.rows_at_point(q, "rod_2"),
        system.rows_at_point(q, "rod_2", target=[1] * 3),
    )
    with pytest.raises(ContradictionError, match="point of rod_2 against world"):
        system.impact(q, y, rows=Rows.stack(system, [still, moving]))
    # Out of the plane nothing can move: a demand that it stay is met, one that it go is not.
    assert abs(system.impact(q, y, rows=still).body("rod_2")[0][2]) < 1e-15
    out = system.rows_at_point(q, "rod_2", directions=[[0, 0, 1]], target=[1])
    with pytest.raises(ContradictionError):
        system.impact(q, y, rows=out)
