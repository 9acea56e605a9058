"""Random scenes of one to three example robots, against Kane's equations and the laws."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik

from ..robots import random_state

ROBOTS = ("double_pendulum", "ur5", "panda", "solo12", "anymal", "allegro_right_hand")
LAWS = [
    ik.Law(restitution=restitution, slip=slip, order=order)
    for restitution in ("newton", "poisson")
    for slip in ("end", "path")
    for order in ("simultaneous", "sequential")
    if not (slip == "path" and order == "simultaneous")
]
# Of velocities, over the largest of them.
EXACT = 1e-9


def random_scene(rng, law):
    """Blows, a pin, a lock and up to two contacts on robots side by side."""
    names = rng.choice(ROBOTS, int(rng.integers(1, 4)))
    robot = ik.combine(
        {
            f"r{k}": ik.Robot.from_example(
                str(name), root="freeflyer" if rng.random() < 0.5 else "fixed"
            )
            for k, name in enumerate(names)
        },
        placements={f"r{k}": rng.normal(size=3) for k in range(len(names))},
    )
    links = [link.name for link in robot.links if link.joint_id > 0 and link.mass > 0.0]

    def link():
        return str(rng.choice(links))

    blows = [
        ik.AppliedImpulse(link(), linear=rng.normal(size=3), at=0.1 * rng.normal(size=3))
        for _ in range(int(rng.integers(0, 3)))
    ]
    holds = []
    if rng.random() < 0.4:
        holds.append(ik.PointAnchor(link(), at=0.1 * rng.normal(size=3)))
    if rng.random() < 0.4:
        joint = str(rng.choice([n for n in robot.joint_names if "root" not in n]))
        holds.append(ik.JointLock(joint))
    contacts = []
    for k in range(int(rng.integers(0, 3))):
        normal = rng.normal(size=3)
        contacts.append(
            ik.Contact(
                link(),
                at=0.1 * rng.normal(size=3),
                normal=normal / np.linalg.norm(normal),
                restitution=float(rng.uniform(0.0, 1.0)),
                friction=float(rng.choice([0.0, 0.3, 1.0])),
                name=f"contact {k}",
            )
        )
    return ik.Scene(robot, blows, holds, contacts, law=law)


def assert_lawful(impact):
    """What every law says of its answer, out of velocities at the points alone."""
    scale = max(
        [1e-3]
        + [np.abs(c.velocity_before).max() for c in impact.contacts]
        + [np.abs(c.velocity_after).max() for c in impact.contacts]
    )
    load = max([1e-12] + [np.abs(c.impulse).max() for c in impact.contacts])
    for entry, found in zip(impact.scene.contacts, impact.contacts, strict=True):
        normal = np.array(entry.normal)
        pressed = float(normal @ found.impulse)
        rubbed = np.linalg.norm(found.impulse - pressed * normal)
        assert pressed >= -EXACT * load
        assert rubbed <= entry.friction * pressed + EXACT * load
        assert normal @ found.velocity_after >= -EXACT * scale
    # Impulses work on the mean of the velocities before and after, and nothing else does.
    energy = impact.energy
    size = max(energy.before, energy.after, *map(abs, energy.work.values()), 1e-12)
    assert abs(energy.change - sum(energy.work.values())) <= EXACT * size


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.slip}-{law.order}")
@pytest.mark.parametrize(
    "count", [pytest.param(3, id="few"), pytest.param(60, id="many", marks=pytest.mark.slow)]
)
def test_valid_answers_are_those_of_kane_and_keep_the_law(law, count):
    rng = np.random.default_rng(count)
    judged = 0
    for seed in range(count):
        scene = random_scene(rng, law)
        q, v = random_state(scene.robot, seed)
        try:
            impact = ik.solve(scene, q, v)
        except (ik.errors.ContradictionError, ik.errors.InputError):
            continue
        if not impact.is_valid():
            continue
        judged += 1
        assert_lawful(impact)
        found = ik.check(impact)
        assert found.agrees, found
    assert judged >= count // 3
