"""Contacts that cannot move along their own normal: they carry nothing, as if they were not there.

Such a row is exactly zero; in doubles the rounding of places is left of it.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

BODY = """<inertial><origin xyz=".01 .02 .03"/><mass value="1"/>
<inertia ixx=".02" iyy=".03" izz=".04" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius=".1"/></geometry></collision>"""
PLACE = np.array([0.3, 0.2, 0.1])
TURN = pin.rpy.rpyToMatrix(0.4, 0.5, 0.6)
HINGE, SLIDE = "continuous", "prismatic"
OUTPUTS = ("v_after", "contact_impulses")


def two_links(kind: str, root: str = "freeflyer") -> ik.Robot:
    """A base and a link on it, by a skew joint about or along the link's y."""
    return ik.Robot.from_urdf(
        f"""<robot name="d"><link name="b">{BODY}</link><link name="s">{BODY}</link>
        <joint name="j" type="{kind}"><parent link="b"/><child link="s"/>
        <origin xyz=".3 .2 .1" rpy=".4 .5 .6"/><axis xyz="0 1 0"/>
        <limit lower="-9" upper="9"/></joint></robot>""",
        root=root,
    )


COEFFICIENTS = {"restitution": 0.5, "stiffness": 1e4}
ON_AXIS = {"frame": "s", "against": "b", "at": [0, 0.3, 0], "normal": [0.3, 0.2, 0.9]}
# By name: the joint, and a contact that it leaves no motion along the normal.
CASES = {
    "on a hinge's axis": (HINGE, ik.Contact(**ON_AXIS, **COEFFICIENTS)),
    "on a hinge's axis, rough": (HINGE, ik.Contact(**ON_AXIS, friction=0.4, **COEFFICIENTS)),
    "along a hinge": (
        HINGE,
        ik.Contact("b", against="s", at=[0.5, 0.1, 0.4], normal=[0, 1, 0], **COEFFICIENTS),
    ),
    "across a slide": (
        SLIDE,
        ik.Contact("s", against="b", at=[0.1, 0.2, 0.3], normal=TURN[:, 2], **COEFFICIENTS),
    ),
    "a rope to a point of the axis": (
        HINGE,
        ik.Rope("s", "b", [0.2, 0.1, 0.3], PLACE + TURN @ [0, 0.4, 0], length=0.1, **COEFFICIENTS),
    ),
}
LAWS = {
    "newton": ik.Law(),
    "poisson": ik.Law("poisson"),
    "stronge": ik.Law("stronge", "path"),
    "path": ik.Law(slip="path"),
    "sequential": ik.Law(order="sequential"),
}


def state(robot: ik.Robot, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q = pin.integrate(robot.model, robot.neutral(), rng.normal(size=robot.nv))
    return q, rng.normal(size=robot.nv)


def moved_nothing(contact: object) -> bool:
    """Whether a contact carries nothing."""
    return all(not point.impulse.any() for point in contact.points)


@pytest.mark.parametrize("root", ["fixed", "planar", "freeflyer"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("case", CASES)
def test_it_carries_nothing(case: str, law: str, root: str) -> None:
    kind, contact = CASES[case]
    robot, blow = two_links(kind, root), [ik.JointImpulse("j", 0.3)]
    scene = ik.Scene(robot, blow, contacts=[contact], law=LAWS[law], gap_bound=1e9)
    without = ik.Scene(robot, blow)
    rows, singles = [], []
    for seed in range(12):
        q, v = state(robot, seed)
        impact = ik.solve(scene, q, v)
        assert impact.status is ik.Status.SOLVED
        assert moved_nothing(impact.contacts[0])
        np.testing.assert_allclose(
            impact.v_after, ik.solve(without, q, v).v_after, rtol=0, atol=1e-13
        )
        rows.append((q, v))
        singles.append(impact.v_after)
    states = map(np.array, zip(*rows, strict=True))
    batch = ik.solve_batch(scene, *states, outputs=OUTPUTS)
    assert batch.valid.all()
    np.testing.assert_allclose(batch.v_after, singles, rtol=0, atol=1e-13)
    assert not batch.contact_impulses.any()


def test_a_point_off_the_axis_by_a_micrometre_is_hit() -> None:
    """W_nn of 1e-12 m² is no rounding: P = −(1 + e) u_n/W_nn, and u_n⁺ = −e u_n⁻."""
    robot = two_links(HINGE)
    touch = ik.Contact("s", against="b", at=[1e-6, 0.3, 0], normal=[0, 0, 1], restitution=0.5)
    scene = ik.Scene(robot, contacts=[touch])
    hit = 0
    for seed in range(12):
        q, v = state(robot, seed)
        before, after = (c := ik.solve(scene, q, v).contacts[0]).velocity_before, c.velocity_after
        normal = c.points[0].normal
        if before @ normal < 0:
            assert after @ normal == pytest.approx(-0.5 * (before @ normal), rel=1e-6)
            hit += 1
    assert hit > 2


def test_tangents_that_cannot_move_carry_nothing() -> None:
    """On a slide straight into a plane: P = (1 + e) m u_n, and no friction, which nothing asks."""
    robot = two_links(SLIDE, "fixed")
    touch = ik.Contact("s", at=[0.1, 0.2, 0.3], normal=TURN[:, 1], restitution=0.5, friction=0.7)
    scene = ik.Scene(robot, contacts=[touch])
    impact = ik.solve(scene, [0.2], [-2.0])
    batch = ik.solve_batch(scene, [[0.2]], [[-2.0]], outputs=OUTPUTS)
    exact = 1.5 * 2.0 * TURN[:, 1]
    np.testing.assert_allclose(impact.contacts[0].impulse, exact, rtol=0, atol=1e-14)
    np.testing.assert_allclose(batch.contact_impulses[0, 0], exact, rtol=0, atol=1e-14)
    assert impact.status is ik.Status.SOLVED
