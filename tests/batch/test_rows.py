"""Each row of a batch is what ``solve`` says of its state: every kind of scene, in one table."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import impulsekit as ik

from .compare import random_states, scene_of_row, worst_difference

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
COUNT = 9
CORNERS = ((0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
panda = cache(lambda: ik.Robot.from_example("panda"))
solo = cache(lambda: ik.Robot.from_example("solo12", root="freeflyer"))
four_bar = cache(lambda: ik.Robot.from_urdf("models/four_bar.urdf"))
ball = cache(lambda: ik.Robot.from_urdf("models/ball.urdf", root="freeflyer"))
box = cache(lambda: ik.Robot.from_urdf("models/box.urdf", root="freeflyer"))

# An impulse that all scenes of Solo12 take.
KICK = ik.AppliedImpulse("base_link", [0.3, -0.2, -1], name="kick")
LOOP = ik.PointAnchor("coupler", "rocker", at=[0.5, 0, 0], other_at=[0, 0.5, 0])
PUSH = ik.AppliedImpulse("coupler", linear=[1, 0, 0], at=[0.25, 0, 0])

Case = tuple[ik.Scene, np.ndarray, np.ndarray, dict[str, Any]]


def scene(robot, *, spread=1.5, down=0.0, varying=None, **entries) -> Case:
    """A scene with random states, and what varies row by row."""
    q, v = random_states(robot, COUNT, spread=spread)
    v[:, 2] -= down
    return ik.Scene(robot, gap_bound=np.inf, **entries), q, v, varying or {}


def feet(*names, **coefficients):
    return [ik.Contact(name, at=[0, 0, -0.01], **coefficients) for name in names]


def rng():
    return np.random.default_rng(1)


def two_balls() -> Case:
    robot = ik.combine(a=ball(), b=ball(), floor=ik.Robot.from_urdf("models/floor.urdf"))
    contacts = [
        ik.Collision("a/ball", "floor/floor", restitution=0.7, friction=0.3),
        ik.Collision("floor/floor", "b/ball", restitution=0.5, friction=0.2),
        ik.Collision("a/ball", "b/ball", restitution=ik.RestitutionTable([0, 2], [0.9, 0.3])),
    ]
    q, angle = np.tile(robot.neutral(), (COUNT, 1)), rng().uniform(0, 2 * np.pi, COUNT)
    q[:, 0:3] = np.c_[rng().uniform(-1, 1, (COUNT, 2)), np.full(COUNT, 0.05)]
    q[:, 7:10] = q[:, 0:3] + 0.1 * np.c_[np.cos(angle), np.sin(angle), np.zeros(COUNT)]
    # Some are apart.
    q[::3, 9] += 0.01
    own = ik.Scene(robot, contacts=contacts, law=ik.Law(order="sequential"))
    return own, q, rng().normal(size=(COUNT, robot.nv)), {}


def ball_on_box() -> Case:
    robot = ik.combine(ball=ball(), box=box())
    collision = ik.Collision("ball/ball", "box/box", restitution=0.6, friction=0.4)
    q, v = random_states(robot, COUNT)
    for i, (state, side) in enumerate(zip(q, rng().permuted(np.arange(COUNT) % 3), strict=True)):
        place = robot.placement(state, "box/box")
        away = np.eye(3)[side] * (np.array([0.15, 0.1, 0.05])[side] + 0.05 + 0.003 * (i % 4 == 3))
        state[:3] = place.point(away + 0.03 * np.eye(3)[(side + 1) % 3])
    return ik.Scene(robot, contacts=[collision], gap_bound=np.inf), q, v, {}


def boxes() -> Case:
    """Two corners of a box land on another: geometry that finds several points."""
    robot = box().with_ground()
    q = np.tile(robot.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1]), (COUNT, 1))
    v = np.c_[0.2 * rng().normal(size=(COUNT, 6))]
    v[:, 2] = -1.0
    return ik.Scene(robot, contacts=[ik.Collision("box", "ground", friction=0.9)]), q, v, {}


def mimic(name: str, root: str) -> Case:
    robot = ik.Robot.from_example(name, root=root, mimic=True)
    follower = robot.model.mimicking_joints[0]
    frame = next(one.name for one in robot.links if one.joint_id == follower and one.mass > 0)
    blow = ik.AppliedImpulse(frame, [1, 2, 3], [0.1, 0.2, 0], at=[0.01, 0.02, 0])
    contact = ik.Contact(frame, friction=0.3, restitution=0.4)
    return scene(robot, spread=0.3, impulses=[blow], contacts=[contact])


def varied() -> Case:
    given = {
        "impulses": {"kick": rng().normal(size=(COUNT, 3)), "motor": rng().normal(size=(COUNT, 1))},
        "restitution": rng().uniform(size=(COUNT, 2)),
        "friction": rng().uniform(0, 0.6, size=(COUNT, 2)),
        "points": {"toe": rng().uniform(-0.1, 0.1, (COUNT, 3))},
    }
    contacts = [ik.Contact("FR_FOOT", name="toe"), ik.Contact("FL_FOOT", name="other")]
    blows = [KICK, ik.JointImpulse("FR_KFE", 0.1, name="motor")]
    return scene(solo(), impulses=blows, contacts=contacts, varying=given)


def far_turned() -> Case:
    own, q, v, given = scene(panda(), impulses=[ik.AppliedImpulse("panda_hand", [0, 0, 1])])
    q[3, 2], q[4, 1], q[5, 0] = 1e7, -3e4, 6.3
    return own, q, v, given


def thrown_leg() -> Case:
    """The blow alone would throw the foot at up to 1000 m/s."""
    bolt = ik.Robot.from_example("bolt")
    blow = ik.AppliedImpulse(
        "FL_UPPER_LEG", [0.54, -0.88, -1.07], [0.2, 0.68, 1.28], at=[0.04, 0.03, 0.13]
    )
    foot = ik.Contact(
        "FL_LOWER_LEG", [0.1, -0.12, 0.09], [0.8, -0.42, 0.42], friction=0.3, restitution=0.4
    )
    return scene(bolt, impulses=[blow], contacts=[foot])


def two_arms() -> Case:
    both = ik.combine(a=panda(), b=panda(), placements={"b": [0.5, 0, 0]})
    held = [
        ik.FrameAnchor("a/panda_hand", "b/panda_hand", directions=("x", "rz"), axes="local"),
        ik.PointAnchor("a/panda_link6", "b/panda_link5", at=[0.1, 0, 0], other_at=[0, 0.2, 0]),
        ik.JointCoupling("a/panda_joint1", "b/panda_joint1", 0.5),
    ]
    contacts = [
        ik.Contact("a/panda_link7", [0, 0, 0.1], against="b/panda_link7", friction=0.3),
        ik.JointStop("b/panda_joint2", lower=-9.0, upper=-8.0),
    ]
    blow = ik.AppliedImpulse("a/panda_link4", [1, 2, 3])
    return scene(both, impulses=[blow], constraints=held, contacts=contacts)


CASES: dict[str, Callable[[], Case]] = {
    "angles far beyond a turn": far_turned,
    "branches that nothing reaches": lambda: scene(
        ik.Robot.from_example("allegro_right_hand"), spread=0.5,
        impulses=[ik.AppliedImpulse("link_3.0_tip", [0, 0.1, 0])],
    ),
    "the ground touches the robot": lambda: scene(
        solo(), contacts=[ik.Contact("world", [0.1, 0, 0], [0, 0, -1], against="FR_FOOT")]
    ),
    "joints at their stops alone": lambda: scene(
        panda(), spread=0.5, contacts=[
            ik.JointStop("panda_joint1", lower=-0.1, upper=0.1, restitution=0.3),
            ik.JointStop("panda_joint2", lower=-0.1, upper=0.1, restitution=0.5),
        ],
    ),
    "a planar loop closed twice": lambda: scene(
        four_bar(), spread=0.5, impulses=[PUSH], constraints=[LOOP, LOOP]
    ),
    "a body pinned at three points": lambda: scene(
        solo(), down=2.0, impulses=[KICK], contacts=feet("FL_FOOT", restitution=0.3),
        constraints=[ik.PointAnchor("base_link", at=at, velocity=(0, 0, 1)) for at in CORNERS],
    ),
    "pins that contradict each other": lambda: scene(
        solo(),
        constraints=[
            ik.PointAnchor("base_link", at=at, velocity=(0, 0, k))
            for k, at in enumerate(CORNERS * 2)
        ],
    ),
    "a contact of a body that is held": lambda: scene(
        solo(), contacts=[ik.Contact("base_link")],
        constraints=[ik.PointAnchor("base_link", at=at) for at in CORNERS],
    ),
    "a pin on the axis of all that moves": lambda: scene(
        panda(), impulses=[ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])],
        constraints=[ik.PointAnchor("panda_link1", at=(0.0, 0.0, 0.1))],
    ),
    "followers on a fixed base": lambda: mimic("tiago_pro", "fixed"),
    "followers that float": lambda: mimic("panda", "freeflyer"),
    "all that may vary": varied,
    "a leg that a blow alone would throw": thrown_leg,
    "two arms held together": two_arms,
    "two balls on a floor": two_balls,
    "a ball on a box": ball_on_box,
    "a box on the ground": boxes,
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_rows_are_those_of_solve(name):
    own, q, v, given = CASES[name]()
    # Loads of what stands behind points that vary, or are found by geometry, follow from solve.
    worst, batch = worst_difference(own, q, v, **given)
    assert worst < 1e-11
    assert batch.valid.any() or name == "pins that contradict each other"


def test_a_pose_all_but_singular_is_as_solve_has_it():
    """An arm held at its tip loses a row as it stretches out: by what angle, ``solve`` decides."""
    arm = ik.Robot.from_urdf("models/whittaker_chain_10.urdf")
    blow = ik.AppliedImpulse("link_2", linear=[0.0, 1.0, 0.0], at=(0.3, 0.0, 0.0))
    own = ik.Scene(arm, [blow], constraints=[ik.PointAnchor("link_10", at=(1.0, 0.0, 0.0))])
    for angle in (1e-14, 1e-9, 1e-5, 1e-3):
        q = angle * rng().uniform(-1, 1, (4, arm.nq))
        batch = ik.solve_batch(own, q, np.zeros((4, arm.nv)))
        for i, pose in enumerate(q):
            impact = ik.solve(own, pose, np.zeros(arm.nv))
            assert impact.is_valid() == batch.valid[i]
            off = np.abs(batch.v_after[i] - impact.v_after).max()
            assert off < (1e-15 / angle + 1e-12) * np.abs(impact.dv).max()


def test_few_rows_many_rows_and_threads_give_the_same_bits():
    own = ik.Scene(solo(), contacts=feet("FR_FOOT", friction=0.5), gap_bound=np.inf)
    q, v = random_states(solo(), 37)
    many = ik.solve_batch(own, q, v, threads=2)
    for size in (1, 5, 8, 9, 36):
        few = ik.solve_batch(own, q[:size], v[:size], threads=1).v_after
        assert np.array_equal(few, many.v_after[:size])
    q[3, 9], v[11, 0], q[20, 3:7] = np.nan, np.inf, q[20, 3:7] * 1.01
    other = ik.solve_batch(own, q, v)
    bad = [3, 11, 20]
    assert not other.valid[bad].any() and np.isnan(other.v_after[bad]).all()
    good = np.setdiff1d(np.arange(37), bad)
    assert np.array_equal(other.v_after[good], many.v_after[good])


def chosen(given: Any, rows: np.ndarray) -> Any:
    """Some rows of what varies by row."""
    if isinstance(given, dict):
        return {name: chosen(own, rows) for name, own in given.items()}
    return given[rows]


@pytest.mark.parametrize(
    "name", [*CASES, "feet that turn", "one lands, another is struck in some rows"]
)
def test_rows_at_one_configuration_have_the_bits_of_each_alone(name):
    own, q, v, given = {
        **CASES,
        "feet that turn": lambda: scene(
            solo(), contacts=feet("FL_FOOT", "FR_FOOT", friction=0.5, torsion=0.01)
        ),
        "one lands, another is struck in some rows": lambda: scene(
            ik.combine(a=ball(), b=ball()),
            impulses=[ik.AppliedImpulse("b/ball", [0, 0, 1], name="kick")],
            contacts=[ik.Contact("a/ball", friction=0.5)],
            varying={"impulses": {"kick": np.arange(COUNT)[:, None] // 2 * [0.1, 0.2, -0.3]}},
        ),
    }[name]()
    # One configuration for blocks of eight, another one, and the first one again.
    at, rows = np.repeat([0, 1, 0], [21, 12, 9]), np.arange(42) // 5
    parts = ("v_after", "generalized_impulse", "energy_change")
    batch = ik.solve_batch(own, q[at], v[rows], **chosen(given, rows), outputs=parts, threads=1)
    for i in range(0, 42, 3):
        more = chosen(given, rows[i : i + 1])
        alone = ik.solve_batch(
            own, q[at[i] : at[i] + 1], v[rows[i] : rows[i] + 1], **more, outputs=parts
        )
        for part in ("status", *parts):
            np.testing.assert_array_equal(getattr(batch, part)[i], getattr(alone, part)[0])


def apart() -> Case:
    """Two balls that do not act on each other."""
    both = ik.combine(a=ball(), b=ball())
    return scene(
        both,
        contacts=[ik.Contact(name, friction=0.4, restitution=0.5) for name in ("a/ball", "b/ball")],
        varying={"friction": rng().choice([0.0, 0.3, 2.0], (COUNT, 2))},
    )


def soles() -> Case:
    """Corners of two soles: more rows than ways to move."""
    talos = ik.Robot.from_example("talos", root="freeflyer")
    contacts = [
        ik.Contact(f"{side}_sole_link", at=[x, y, 0], friction=0.7, restitution=0.2)
        for side in ("left", "right")
        for x, y in ((0.1, 0.06), (0.1, -0.06), (-0.1, 0.06), (-0.1, -0.06))
    ]
    return scene(talos, contacts=contacts, spread=0.02, down=2.0)


def limits() -> Case:
    """A joint at its limit in some rows, beside a foot."""
    found = scene(
        solo(),
        contacts=[*feet("FL_FOOT", friction=0.8), ik.JointStop("HR_KFE", lower=-1, upper=1)],
    )
    found[1][:, -1] = [-1.0, 0.0, 1.0] * (COUNT // 3)
    return found


ALIKE: dict[str, Callable[[], Case]] = {
    "one foot": lambda: scene(solo(), contacts=feet("FL_FOOT", friction=0.8)),
    "four feet": lambda: scene(
        solo(),
        contacts=feet("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT", friction=0.8, restitution=0.3),
        spread=0.3,
        down=1.0,
    ),
    "smooth feet": lambda: scene(solo(), contacts=feet("FL_FOOT", "HR_FOOT"), down=0.5),
    "balls apart": apart,
    "soles": soles,
    "limits": limits,
}


@pytest.mark.parametrize("restitution", ["newton", "poisson"])
@pytest.mark.parametrize("name", ALIKE)
def test_rows_side_by_side_have_the_bits_of_each_alone(name, restitution):
    """Rows stick, slip, part and touch in all mixtures."""
    own, q, v, given = ALIKE[name]()
    own = own.replace(law=ik.Law(restitution))
    at, rows = rng().integers(0, COUNT, (2, 64))
    parts = ("dv", "contact_impulses", "normal_components", "gaps", "energy_change")
    batch = ik.solve_batch(own, q[at], v[rows], **chosen(given, rows), outputs=parts, threads=1)
    for i, (a, b) in enumerate(zip(at, rows, strict=True)):
        more = chosen(given, rows[i : i + 1])
        alone = ik.solve_batch(own, q[a : a + 1], v[b : b + 1], **more, outputs=parts)
        for part in ("status", *parts):
            np.testing.assert_array_equal(getattr(batch, part)[i], getattr(alone, part)[0])
        state = scene_of_row(own, 0, **more)
        np.testing.assert_array_equal(batch.dv[i], ik.solve(state, q[a], v[b]).dv)


def test_a_row_that_cannot_be_is_flagged_and_the_others_solved():
    body = ball()
    floor = ik.Contact("ball", restitution=0.5, friction=0.3, name="floor")
    q = np.tile(body.neutral(), (4, 1))
    v = np.tile(body.velocity(root_joint=[0, 0, -1, 0, 0, 0]), (4, 1))
    q[1] = 0.0
    v[2, 0] = np.nan
    batch = ik.solve_batch(
        ik.Scene(body, contacts=[floor]), q, v, restitution=np.array([[0.5], [0.5], [0.5], [2.0]])
    )
    assert batch.valid.tolist() == [True, False, False, False]
    assert len(set(batch.status.tolist())) == 4
    assert batch.v_after[0, 2] == pytest.approx(0.5, abs=1e-12)
    assert np.isnan(batch.v_after[1:]).all()
