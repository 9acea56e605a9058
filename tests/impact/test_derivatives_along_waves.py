"""Derivatives of impacts whose contacts are followed in time, against differences of ``solve``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.control import DerivativeStatus

from ..robots import one_body

LAWS = {"compliant": ik.Law(slip="compliant"), "lzb": ik.Law("lzb")}
FEET = [(x, y, -0.05) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]


def struck(law, n, seed):
    """A box that lands on n of its feet, and its state."""
    rng, box = np.random.default_rng(seed), one_body("box", 2.0, 0.05)
    contacts = [
        ik.Contact(
            "box", at=FEET[i] + 0.02 * rng.normal(size=3), name=f"c{i}", stiffness_ratio=0.7,
            restitution=rng.uniform(0.3, 0.8), friction=rng.uniform(0.2, 0.9),
            stiffness=rng.uniform(0.5, 2.0),
        )
        for i in range(n)
    ]  # fmt: skip
    v = np.r_[rng.normal(size=2), -2.0 - rng.random(), rng.normal(size=3)]
    return ik.Scene(box, contacts=contacts, law=LAWS[law], gap_bound=np.inf), box.neutral(), v


def differences(function, count, length=1e-4):
    """(k, count) slopes of fourth order."""
    columns = []
    for unit in length * np.eye(count):
        far, near = (function(s * unit) - function(-s * unit) for s in (1.0, 0.5))
        columns.append((8.0 * near - far) / (6.0 * length))
    return np.array(columns).T


def compared(scene, q, v, found):
    """Derivatives of v⁺ and differences of ``solve``: by v, by q, by e and µ, and by a point."""
    contacts, n, model = scene.contacts, len(scene.contacts), scene.robot.model

    def by_coefficients(x):
        changed = [
            replace(c, restitution=c.restitution + x[i], friction=c.friction + x[n + i])
            for i, c in enumerate(contacts)
        ]
        return ik.solve(scene.replace(contacts=changed), q, v).v_after

    def by_point(x):
        first = replace(contacts[0], at=contacts[0].at + x)
        return ik.solve(scene.replace(contacts=[first, *contacts[1:]]), q, v).v_after

    table = found["v_after", "restitution"], found["v_after", "friction"]
    yield found["v_after", "v"], differences(lambda x: ik.solve(scene, q, v + x).v_after, 6)
    moved = differences(lambda x: ik.solve(scene, pin.integrate(model, q, x), v).v_after, 6)
    yield found["v_after", "q"], moved
    coefficients = np.column_stack([own[f"c{i}"] for own in table for i in range(n)])
    yield coefficients, differences(by_coefficients, 2 * n)
    yield found["v_after", "at"]["c0"], differences(by_point, 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "n", "seeds"),
    [("compliant", 1, range(16)), ("compliant", 2, range(16)), ("lzb", 2, range(18))],
)
def test_they_are_those_of_differences(law, n, seeds):
    at_edges = 0
    for seed in seeds:
        scene, q, v = struck(law, n, seed)
        found = ik.derivatives(ik.solve(scene, q, v))
        if found.status is DerivativeStatus.MODE_EDGE:
            assert "two lengths disagree" in found.edges[0]
            at_edges += 1
            continue
        assert found.status is DerivativeStatus.BY_DIFFERENCES
        for exact, own in compared(scene, q, v, found):
            assert exact == pytest.approx(own, abs=1e-6 * max(1.0, np.abs(own).max()))
    assert at_edges <= 2


def test_a_batch_has_the_same():
    scene, q, v = struck("compliant", 1, 3)
    alone = ik.derivatives(ik.solve(scene, q, v))
    batch = ik.derivatives_batch(scene, np.array([q, q]), np.array([v, v]))
    assert batch["v_after", "v"][1] == pytest.approx(alone["v_after", "v"], abs=1e-12)
