"""Whether other v⁺ obey the law is told: proven, not proven, or the others."""

import json

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.impact.contact_law import ContactProblem
from tests.truths.enumerated import PlaneProblem, all_after

from ..robots import one_body


def body(mass, inertia):
    return one_body("b", mass, (1, 1, inertia), root="planar")


def bodies_in_a_plane(seed, frictions=(0.0, 0.3, 1.0, 3.0), most=3):
    """A scene of one or two bodies with two or more contacts, v⁻, and the same in fractions."""
    rng = np.random.default_rng(seed)
    n, count = int(rng.integers(2, most + 1)), int(rng.integers(1, 3))
    masses = 10.0 ** rng.uniform(-1, 0, count)
    inertias = masses * rng.uniform(0.05, 1, count)
    friction, e = rng.choice(frictions, n).tolist(), rng.choice([0.0, 0.5, 1.0], n).tolist()
    rows, contacts = np.zeros((2 * n, 3 * count)), []
    for i in range(n):
        a, other = int(rng.integers(count)), int(rng.integers(count))
        angle = rng.uniform(0, 2 * np.pi) if rng.random() < 0.7 else 0.0
        c, s = float(np.cos(angle)), float(np.sin(angle))
        x, y = rng.uniform(-1, 1, 2)
        own = np.array([[c, s, x * s - y * c], [-s, c, x * c + y * s]])
        rows[2 * i : 2 * i + 2, 3 * a : 3 * a + 3] = own
        against = "world"
        if other != a and rng.random() < 0.5:
            rows[2 * i : 2 * i + 2, 3 * other : 3 * other + 3] = -own
            against = f"b{other}/b"
        contacts.append(
            ik.Contact(
                f"b{a}/b", at=[x, y, 0], normal=[-s, c, 0], against=against,
                restitution=e[i], friction=friction[i],
            )
        )  # fmt: skip
    robot = ik.combine(
        **{f"b{k}": body(float(masses[k]), float(inertias[k])) for k in range(count)}
    )
    v = rng.normal(size=3 * count)
    inverse = [1 / x for m, j in zip(masses, inertias, strict=True) for x in (m, m, j)]
    return ik.Scene(robot, contacts=contacts), v, PlaneProblem(rows, inverse, v, friction, e)


def test_the_one_answer_is_found_wherever_fractions_find_one():
    for seed in range(1000, 1250):
        scene, v, problem = bodies_in_a_plane(seed, frictions=(0.0, 1.0, 3.0, 10.0))
        exact = all_after(problem)
        if len(exact) != 1:
            continue
        impact = ik.solve(scene, scene.robot.neutral(), v)
        assert np.abs(impact.v_after - exact[0][0]).max() < 1e-7 * np.abs(v).max()


@pytest.mark.parametrize(
    ("friction", "reason"), [(0.0, "nothing rubs"), (0.02, "feeds back weakly")]
)
def test_small_friction_is_proven_without_a_search(friction, reason):
    arms = ik.combine(left=body(1.0, 0.5), right=body(2.0, 0.3))
    contacts = [
        ik.Contact(f"{side}/b", at=[0.4, -0.3, 0], normal=[0, 1, 0], friction=friction)
        for side in ("left", "right")
    ]
    contacts.append(ik.Contact("left/b", against="right/b", at=[0.1, 0.2, 0], normal=[1, 0, 0]))
    scene = ik.Scene(arms, contacts=contacts)
    impact = ik.solve(scene, arms.neutral(), [-0.3, -1, 0.2, 0.4, -1, 0.1])
    assert impact.uniqueness.proven and reason in impact.uniqueness.reason
    assert json.loads(json.dumps(impact.to_dict()))["uniqueness"]["verdict"] == "proven"


def contacts_of_planar_bodies(seed):
    """A problem of 2 or 3 contacts of 1 or 2 bodies in a plane, with what moves out of it."""
    rng = np.random.default_rng([1, seed])
    n, bodies = int(rng.integers(2, 4)), int(rng.integers(1, 3))
    masses = np.repeat(10 ** rng.uniform(-2, 0, bodies), 3)
    masses *= np.tile([1, 1, rng.uniform(0.02, 1)], bodies)
    J = np.zeros((2 * n, 3 * bodies))
    for i in range(n):
        one, angle = rng.integers(bodies), rng.uniform(0, 2 * np.pi)
        c, s = np.cos(angle), np.sin(angle)
        for body, sign in ((one, 1), (int(rng.integers(bodies)), -1)):
            if sign < 0 and (body == one or rng.random() < 0.5):
                continue
            x, y = rng.uniform(-1, 1, 2)
            rows = [[c, s, -y * c + x * s], [-s, c, y * s + x * c]]
            J[2 * i : 2 * i + 2, 3 * body : 3 * body + 3] = sign * np.array(rows)
    u = J @ rng.normal(size=3 * bodies)
    mu, e = rng.choice([0.0, 0.3, 1.0, 3.0, 10.0], n), rng.choice([0.0, 0.5, 1.0], n)
    inside = np.array([[3 * i, 3 * i + 2] for i in range(n)]).ravel()
    W, before = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    W[np.ix_(inside, inside)], before[inside] = J @ np.diag(1 / masses) @ J.T, u
    for i in range(n):
        W[3 * i + 1, 3 * i + 1] = 1.0
    return ContactProblem(W, before, before, e, mu, np.zeros(n)), rng


# One compression brings all contacts to rest and leaves rounding, from which there are expansions.
