"""Contacts between parts that bilateral rows hold: nothing stops them, so what they do is given.

Held bodies that keep their velocities have v⁺ = v⁻ in closed form, and a contact on them whose
normal velocity is zero needs nothing, at every posture; in doubles rounding is left of that zero.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

BODY = """<inertial><origin xyz=".01 .02 .03"/><mass value="1"/>
<inertia ixx=".02" iyy=".03" izz=".04" ixy="0" ixz="0" iyz="0"/></inertial>"""
HINGE = pin.rpy.rpyToMatrix(0.4, 0.5, 0.6)
PLACE = np.array([0.1, 0.2, 0.3])
LAWS = {
    "newton": ik.Law(),
    "poisson": ik.Law("poisson"),
    "stronge": ik.Law("stronge", "path"),
    "lzb": ik.Law("lzb", "path"),
    "sequential": ik.Law(order="sequential"),
}
KEPT = {"velocity": "kept"}
HOLDS = {
    "weld": [ik.FrameAnchor("b", **KEPT)],
    "pins": [
        ik.PointAnchor("b", at=[0.3, 0.2, 0.1], **KEPT),
        ik.PointAnchor("b", at=[0.31, 0.2, 0.1], **KEPT),
        ik.DistanceAnchor("b", at=[0, 0, 0], other_at=[1, 2, 3], **KEPT),
    ],
}
POSTURES = 16


@pytest.fixture(scope="module")
def robot() -> ik.Robot:
    """A free base and a link on it, by a skew hinge about the link's y."""
    return ik.Robot.from_urdf(
        f"""<robot name="d"><link name="b">{BODY}</link><link name="s">{BODY}</link>
        <joint name="j" type="continuous"><parent link="b"/><child link="s"/>
        <origin xyz=".3 .2 .1" rpy=".4 .5 .6"/><axis xyz="0 1 0"/></joint></robot>""",
        root="freeflyer",
    )


def posture(robot: ik.Robot, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A configuration, and the rotation of its base."""
    q = pin.integrate(robot.model, robot.neutral(), rng.normal(size=robot.nv))
    return q, pin.Quaternion(q[3:7]).matrix()


def contact_on_the_base(
    turn: np.ndarray, rng: np.random.Generator, approach: float
) -> tuple[str, np.ndarray, np.ndarray]:
    """The base turns, and the place on it moves along the plane; on the plane's frame and v."""
    normal, spin = rng.normal(size=3), rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    along = np.cross(normal, rng.normal(size=3)) - approach * normal
    return "b", normal, np.r_[turn.T @ along - np.cross(spin, PLACE), spin, 0.7]


def contact_along_the_hinge(
    turn: np.ndarray, rng: np.random.Generator, approach: float
) -> tuple[str, np.ndarray, np.ndarray]:
    """The link turns about the normal of its contact, and the base moves across that."""
    normal = turn @ HINGE[:, 1]
    along = np.cross(normal, rng.normal(size=3)) - approach * normal
    return "s", normal, np.r_[turn.T @ along, 0.0, 0.0, 0.0, 0.7]


Case = Callable[[np.ndarray, np.random.Generator, float], tuple[str, np.ndarray, np.ndarray]]
CASES: dict[str, Case] = {"base": contact_on_the_base, "hinge": contact_along_the_hinge}


def struck(
    robot: ik.Robot, case: str, hold: str, law: str, approach: float, friction: float
) -> list[tuple[ik.Impact, np.ndarray]]:
    """The impacts at several postures, each with v⁻."""
    impacts = []
    for seed in range(POSTURES):
        rng = np.random.default_rng(seed)
        q, turn = posture(robot, rng)
        frame, normal, v = CASES[case](turn, rng, approach)
        touch = ik.Contact(
            frame, at=PLACE, normal=normal, restitution=0.5, friction=friction, stiffness=1e5
        )
        scene = ik.Scene(
            robot, constraints=HOLDS[hold], contacts=[touch], law=LAWS[law], gap_bound=1e9
        )
        impacts.append((ik.solve(scene, q, v), v))
        batch = ik.solve_batch(scene, q[None], v[None])
        assert batch.status[0] == impacts[-1][0].status.code
    return impacts


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("case", CASES)
def test_what_moves_along_its_plane_needs_nothing(
    robot: ik.Robot, case: str, hold: str, law: str
) -> None:
    for impact, v in struck(robot, case, hold, law, 0.0, 0.0):
        assert impact.status is ik.Status.SOLVED
        assert not impact.contacts[0].impulse.any()
        np.testing.assert_allclose(impact.v_after, v, rtol=0, atol=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("case", CASES)
def test_what_is_led_into_its_plane_has_no_solution(robot: ik.Robot, case: str, law: str) -> None:
    """However slowly: 1e-9 m/s is no rounding of 1 m/s. What parts as slowly needs nothing."""
    for impact, _ in struck(robot, case, "weld", law, 1e-9, 0.0):
        assert impact.status is ik.Status.NO_SOLUTION
    for impact, _ in struck(robot, case, "weld", law, -1e-9, 0.0):
        assert impact.status is ik.Status.SOLVED
