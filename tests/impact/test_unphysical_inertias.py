"""Inertias that no body has: M may be indefinite, yet M Δv = I is solved and judged alike."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik


def _link(name, mass, moment, product):
    return (
        f'<link name="{name}"><inertial><origin xyz="0.1 0.02 0"/><mass value="{mass}"/>'
        f'<inertia ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="{product}" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )


def _joint(number, axis):
    return (
        f'<joint name="j{number}" type="continuous"><parent link="l{number - 1}"/>'
        f'<child link="l{number}"/><origin xyz="0.2 0 0.05"/><axis xyz="{axis}"/></joint>'
    )


@pytest.fixture(scope="module")
def finger():
    links = [_link("l0", 1.0, 0.1, 0.0), _link("l1", 0.1, 1e-4, 3e-4)]
    links += [_link(f"l{i}", 0.05, 1e-5, 1e-3) for i in (2, 3)]
    joints = [_joint(i, axis) for i, axis in ((1, "0 0 1"), (2, "0 1 0"), (3, "1 0 0"))]
    return ik.Robot.from_urdf(f'<robot name="finger">{"".join(links + joints)}</robot>')


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("held", [False, True])
def test_solve_and_batches_judge_them_alike(finger, held):
    rng = np.random.default_rng(0)
    joints = {f"j{i}": rng.uniform(-3.0, 3.0, 40) for i in (1, 2, 3)}
    Q = np.array([finger.configuration(**dict(zip(joints, x, strict=True)))
                  for x in zip(*joints.values(), strict=True)])  # fmt: skip
    blow = ik.AppliedImpulse("l3", linear=[0.3, 0.2, 1.0], at=[0.1, 0.05, 0])
    scene = ik.Scene(finger, [blow], contacts=[ik.Contact("l3")] if held else [])
    batch = ik.solve_batch(scene, Q, np.zeros((len(Q), finger.nv)))
    for i, q in enumerate(Q):
        try:
            impact = ik.solve(scene, q, finger.velocity())
        except ik.errors.SingularMassError:
            assert batch.status[i] == ik.Status.SINGULAR_MASS
            continue
        assert impact.status == batch.status[i]
        assert impact.residuals.largest < 1e-12
        assert impact.v_after == pytest.approx(batch.v_after[i], rel=1e-9, abs=1e-12)
    if not held:
        assert (batch.status == ik.Status.SOLVED).all()
