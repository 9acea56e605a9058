"""Jobs that are timed but have no answer of the benchmark's: what the table of claims names."""

from __future__ import annotations

import math
import pathlib
import tempfile
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio as pin

from impulsekit._core import find_outcomes
from impulsekit.batch.derivatives import vjp
from impulsekit.batch.long import long_chain
from impulsekit.batch.problems import solve_contact_problems
from impulsekit.batch.solve import solve_batch
from impulsekit.checking import check
from impulsekit.impact import solve
from impulsekit.impact.contact_law import ContactProblem
from impulsekit.impact.derivatives import derivatives
from impulsekit.measured.recording import Recording
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import AppliedImpulse, Contact, FrameAnchor, Law, Scene
from impulsekit.view.replay import replay

from .methods.bare import Points
from .problems.blows import AT, LINEAR
from .problems.contacts import CORNERS, FEET, SOLES, landing_state
from .problems.problem import drawn_state
from .problems.registry import problem_named
from .timing import Times, import_times, in_turn

PINOCCHIO = "import pinocchio"
BARE = "import impulsekit"
# How often batches are timed.
ROUNDS = 15
NAMES = "from impulsekit import Robot, Scene"
SOLVING = "from impulsekit import Robot, Scene, solve"
# Laws beside the default: their words, at how many feet of Solo12, and how many times quicker
# a state of a batch is.
LAWS = (
    ("Stronge along the path", 1, Law("stronge", slip="path"), 50.0),
    ("Poisson", 1, Law("poisson"), 30.0),
    ("Poisson at four feet", 4, Law("poisson"), 20.0),
    ("four feet in sequence", 4, Law(order="sequential"), 40.0),
)


def one_of_four() -> Times:
    """A blow on one of four Pandas, against one on a lone Panda."""
    panda = Robot.from_example("panda")
    four = combine(a=panda, b=panda, c=panda, d=panda)
    return in_turn(_blow(four, "c/panda_hand"), _blow(panda, "panda_hand"))


def _blow(robot: Robot, frame: str) -> Callable[[], object]:
    scene = Scene(robot, [AppliedImpulse(frame, LINEAR, at=AT)])
    q, v = drawn_state(robot, 0)
    return lambda: solve(scene, q, v).dv


def importing(statement: str) -> Times:
    """An import of ours against Pinocchio's."""
    times = import_times([PINOCCHIO, statement])
    return Times(times[statement], times[PINOCCHIO])


def _derivatives(held: bool, points: int) -> Times:
    """All derivatives of an impact of Talos against the solve itself."""
    talos = Robot.from_example("talos", root="freeflyer")
    q, v = _above_ground(talos)
    blow = AppliedImpulse("arm_left_7_link", linear=(1.0, 0.0, 0.0), at=(0.1, 0.0, 0.0))
    scene = Scene(
        talos,
        [] if points else [blow],
        [FrameAnchor(SOLES[0])] if held else [],
        [Contact(SOLES[0], at=corner, friction=0.5) for corner in CORNERS[:points]],
    )
    impact = solve(scene, q, v)
    return in_turn(lambda: derivatives(impact)["v_after", "q"], lambda: solve(scene, q, v))


DERIVATIVES: dict[str, Callable[[], Times]] = {
    "Talos, one blow": partial(_derivatives, False, 0),
    "Talos, a foot that is held": partial(_derivatives, True, 0),
    "Talos, one frictional contact": partial(_derivatives, False, 1),
    "Talos, four frictional contacts": partial(_derivatives, False, 4),
}


# By robot: its root and the frames that touch, the most that all derivatives of one impact may
# take, and the gradient of a row on two cores [µs].
GRADIENTS = {
    "panda": ("fixed", ("panda_hand",), 40.0, 2.0),
    "talos": ("freeflyer", ("left_sole_link", "right_sole_link"), 120.0, 10.0),
}


def _gradient_job(name: str, touches: bool, count: int) -> tuple[Scene, np.ndarray, np.ndarray]:
    """A blow on a frame, or frames that land, at many states."""
    root, frames = GRADIENTS[name][:2]
    robot, rng = Robot.from_example(name, root=root), np.random.default_rng(0)
    blow = AppliedImpulse(frames[0], linear=(0.0, 1.0, 5.0))
    contacts = [Contact(frame, friction=0.3, restitution=0.3) for frame in frames]
    scene = Scene(robot, [] if touches else [blow], contacts=contacts if touches else [])
    steps = rng.uniform(-0.3, 0.3, (count, robot.nv))
    q = np.array([pin.integrate(robot.model, robot.neutral(), step) for step in steps])
    v = rng.normal(size=(count, robot.nv))
    v[:, 2 if root == "freeflyer" else 0] -= 2.0
    return scene, q, v


def gradient_of_batch(name: str, touches: bool) -> Times:
    """Weighted gradients of a batch against the batch itself."""
    scene, q, v = _gradient_job(name, touches, 4096)
    return in_turn(
        lambda: vjp(scene, q, v, v), lambda: solve_batch(scene, q, v), 4096, 4096, ROUNDS
    )


def gradient_of_a_row(name: str, touches: bool) -> list[float]:
    """Processor time of a row's gradient, shared by two cores [µs]."""
    scene, q, v = _gradient_job(name, touches, 4096)
    return _taken(lambda: vjp(scene, q, v, v), 1, 2 * len(q))


def all_derivatives(name: str, touches: bool) -> list[float]:
    """Processor time of ∂v⁺ of one impact by everything [µs]."""
    scene, q, v = _gradient_job(name, touches, 1)
    impact = solve(scene, q[0], v[0])
    return _taken(lambda: derivatives(impact)["v_after", "q"], 200, 200)


def _taken(call: Callable[[], object], calls: int, share: int) -> list[float]:
    """Processor time of calls over a share [µs], by round."""
    call()
    taken = []
    for _ in range(ROUNDS):
        start = time.process_time()
        for _ in range(calls):
            call()
        taken.append(1e6 * (time.process_time() - start) / share)
    return taken


def _above_ground(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Near the neutral pose, on the way down."""
    q, v = drawn_state(robot, 0, spread=0.1)
    q[:7] = robot.neutral()[:7]
    return q, 0.2 * v - np.eye(robot.nv)[2]


def first_solve() -> list[float]:
    """Processor time of a new ``Scene`` of Solo12 on four feet and its first solve [µs]."""
    solo = Robot.from_example("solo12", root="freeflyer")
    q, v = solo.neutral(), -np.eye(solo.nv)[2]
    q[2] -= solo.placement(q, FEET[0]).position[2]

    def made() -> object:
        return solve(Scene(solo, contacts=[Contact(foot, friction=0.6) for foot in FEET]), q, v).dv

    return _taken(made, 200, 200)


def batch_of(feet: int, law: Law) -> Times:
    """Solo12 on some feet under a law: a batch against one state after the other."""
    solo = Robot.from_example("solo12", root="freeflyer")
    contacts = [Contact(foot, friction=0.6, restitution=0.3) for foot in FEET[:feet]]
    scene = Scene(solo, contacts=contacts, law=law)
    rng = np.random.default_rng(0)
    steps = rng.uniform(-1.0, 1.0, (4096, solo.nv))
    q = np.array([pin.integrate(solo.model, solo.neutral(), step) for step in steps])
    v = rng.normal(size=(4096, solo.nv))

    def one_by_one() -> None:
        # What a row of a batch is: Δv and the status.
        for state in zip(q[:64], v[:64], strict=True):
            _ = solve(scene, *state).status

    return in_turn(lambda: solve_batch(scene, q, v), one_by_one, 4096, 64, ROUNDS)


def compliant_contacts() -> Times:
    """A body that strikes at 64 random points, against Coulomb's friction along their paths."""
    rng = np.random.default_rng(0)
    body = Robot.from_urdf(
        "<robot name='body'><link name='body'><inertial><mass value='1'/><inertia ixx='.02'"
        " iyy='.03' izz='.04' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>",
        root="freeflyer",
    )
    states, points = [], []
    for _ in range(64):
        e, mu, ratio = rng.uniform([0.1, 0.05, 0.3], [0.95, 1.5, 2.0])
        at, v = rng.uniform(-0.1, 0.1, 3), rng.normal(size=6)
        v[2] = -abs(v[2]) - 1.0
        states.append(v)
        points.append(
            Contact("body", at=at, restitution=e, friction=mu, stiffness_ratio=ratio, origin=at)
        )

    def under(law: Law) -> Callable[[], object]:
        scenes = [Scene(body, contacts=[point], law=law) for point in points]
        q = body.neutral()
        return lambda: [solve(*job).dv for job in zip(scenes, [q] * 64, states, strict=True)]

    compliant, path = Law(slip="compliant"), Law("stronge", slip="path")
    return in_turn(under(compliant), under(path), 64, 64, ROUNDS)


def time_of_compliance() -> list[float]:
    """[µs] of a solve of one compliant contact, several times."""
    return [1e6 / 64 * seconds for seconds in compliant_contacts().ours.rounds]


def outcomes_of_two(in_plane: bool) -> Times:
    """4096 outcomes of two coupled contacts, against as many sequences of whole impacts."""
    rng = np.random.default_rng(5)
    J = rng.normal(size=(6, 7))
    if in_plane:
        J[1::3] = 0.0
    W, u, mu = J @ J.T, J @ rng.normal(size=7), np.full(2, 0.5)
    u[2::3] = -np.abs(u[2::3])
    contacts = ContactProblem(W, u, u, 0 * mu, mu, 0 * mu).contacts()
    directions, rows = np.zeros((0, 6)), np.tile(u, (4096, 1))
    law = Law(slip="path", order="sequential")
    return in_turn(
        lambda: find_outcomes(W, u, contacts, 4096, directions, 0, 0, 2),
        lambda: solve_contact_problems(W, rows, friction=0.5, law=law, threads=2),
        rounds=ROUNDS,
    )


def time_of_outcomes(in_plane: bool) -> list[float]:
    """[ms] of 4096 outcomes of two contacts on two threads, several times."""
    return [1e3 * seconds for seconds in outcomes_of_two(in_plane).ours.rounds]


def falling_talos(count: int) -> tuple[Scene, np.ndarray, np.ndarray]:
    """A scene, (count, nq) and (count, nv): Talos falls forward, both hands strike the floor."""
    talos = Robot.from_example("talos", root="freeflyer")
    hands = [
        Contact(f"gripper_{side}_base_link", [0, 0, -0.1], restitution=0.1, friction=0.5)
        for side in ("left", "right")
    ]
    # The poses are drawn at random: hands are near the floor, not on it.
    scene = Scene(talos, contacts=hands, gap_bound=math.inf)
    rng = np.random.default_rng(0)
    step, v = (size * rng.normal(size=(count, talos.nv)) for size in (0.4, 0.3))
    step[:, :6] *= [0, 0, 0, 0.5, 0.5, 0.5]
    step[:, 4] += 1.2
    q = np.array([pin.integrate(talos.model, talos.neutral(), one) for one in step])
    for own, pose in zip(v, q, strict=True):
        own[:3] += pin.Quaternion(pose[3:7]).toRotationMatrix().T @ [0.0, 0.0, -2.0]
    return scene, q, v


def reactions_of_a_fall() -> Times:
    """What every joint of Talos carries when it falls on its hands: a batch against a loop."""
    scene, q, v = falling_talos(1000)
    joints = scene.robot.joint_names

    def one_by_one() -> None:
        for state in zip(q[:50], v[:50], strict=True):
            impact = solve(scene, *state)
            _ = impact.status, [impact.reactions[joint] for joint in joints]

    batch = partial(solve_batch, scene, q, v, outputs=("reactions",))
    return in_turn(batch, one_by_one, len(q), 50, ROUNDS)


def _seconds(
    job: Callable[[], object], rounds: int = 5, clock: Callable[[], float] = time.perf_counter
) -> list[float]:
    """How long each of some rounds took."""
    taken = []
    for _ in range(rounds):
        start = clock()
        job()
        taken.append(clock() - start)
    return taken


def second_check() -> list[float]:
    """Seconds to hold Talos, both feet held, against Kane once its URDF has been read."""
    robot = Robot.from_example("talos", root="freeflyer")
    scene = Scene(
        robot,
        [AppliedImpulse("gripper_left_base_link", [0, 0, 1])],
        constraints=[FrameAnchor(sole) for sole in SOLES],
    )
    q = robot.neutral()
    check(solve(scene, q, robot.velocity()))
    return _seconds(lambda: check(solve(scene, q, robot.velocity())))


def page() -> list[float]:
    """Seconds to write the page of a 10 s motion of Talos at 60 Hz."""
    robot = Robot.from_example("talos", root="freeflyer")
    t = np.arange(601) / 60.0
    v = 0.3 * np.random.default_rng(0).normal(size=robot.nv)
    q = [pin.integrate(robot.model, robot.neutral(), math.sin(x) * v) for x in t]
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "talos.html"
        return _seconds(lambda: replay(Recording(robot, t, q), path, play=False), rounds=2)


def growth() -> list[float]:
    """The slope of log time over log links, from 10³ to 10⁶ links; 1 is linear. Three times."""
    sizes = (1_000, 10_000, 100_000, 1_000_000)
    slopes = []
    for _ in range(3):
        taken = []
        for links in sizes:
            chain = long_chain(links)
            blow = [AppliedImpulse(f"link_{links}", linear=[0, 5, 0], at=[1, 0, 0])]
            chain.solve(blow)
            # In processor time: the longest take so long that other load always breaks in.
            taken.append(min(_seconds(partial(chain.solve, blow), clock=time.process_time)))
        slopes.append(float(np.polyfit(np.log(sizes), np.log(taken), 1)[0]))
    return slopes


# Calls in turn.
BARE_ROUNDS = 301
# Singular values of W, relative, below which rows are redundant: what numpy is told.
REDUNDANT = 1e-10

Case = Callable[[], tuple[Scene, np.ndarray, np.ndarray]]


def landing(
    name: str, friction: float, e: float = 0.0, along: float = 0.0, law: Law | None = None
) -> tuple[Scene, np.ndarray, np.ndarray]:
    """Solo12 on four feet or Talos on eight points of its soles, down at some 1 m/s."""
    robot = Robot.from_example(name, root="freeflyer")
    points = [(foot, (0.0, 0.0, 0.0)) for foot in FEET]
    if name == "talos":
        points = [(sole, at) for sole in SOLES for at in CORNERS]
    contacts = [Contact(f, at=at, friction=friction, restitution=e) for f, at in points]
    state = landing_state(robot, len(points), along)
    return Scene(robot, contacts=contacts, law=law or Law()), *state


def _one_foot() -> tuple[Scene, np.ndarray, np.ndarray]:
    """A corner of one sole along its path, Stronge's restitution."""
    scene, q, v = landing("talos", 0.5, 0.3)
    law = Law("stronge", slip="path")
    return Scene(scene.robot, contacts=scene.contacts[:1], law=law), q, v


def _pinned() -> tuple[Scene, np.ndarray, np.ndarray]:
    """Talos struck at a hand, both soles held."""
    problem = problem_named("held robot", "held robot 12")
    return problem.scene, problem.q, problem.v


def _four_bar() -> tuple[Scene, np.ndarray, np.ndarray]:
    """Three rods between two pins, struck."""
    problem = problem_named("closed chain", "closed chain 3")
    return problem.scene, problem.q, problem.v


def _by_hand(scene: Scene, q: np.ndarray, v: np.ndarray) -> Callable[[], np.ndarray]:
    """v⁺ with all rows held."""
    import scipy.linalg

    points = Points(scene)
    model, data = points.model, points.data
    blows = [entry for entry in scene.impulses if isinstance(entry, AppliedImpulse)]
    rows = [(frame, len(kept)) for frame, kept in points.rows]
    jacobian = np.zeros((sum(count for _, count in rows), model.nv))
    world = pin.LOCAL_WORLD_ALIGNED

    def velocity_after() -> np.ndarray:
        upper = pin.crba(model, data, q)
        factor = scipy.linalg.cho_factor(np.triu(upper) + np.triu(upper, 1).T)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        first = 0
        for frame, count in rows:
            part = pin.getFrameJacobian(model, data, frame, world)[:count]
            jacobian[first : first + count] = part
            first += count
        before = v
        if blows:
            total = points.joint_impulse.copy()
            for frame, wrench in points.blows:
                total += wrench @ pin.getFrameJacobian(model, data, frame, world)
            before = v + scipy.linalg.cho_solve(factor, total)
        moved = scipy.linalg.cho_solve(factor, jacobian.T)
        right = -jacobian @ before
        return before + moved @ np.linalg.lstsq(jacobian @ moved, right, rcond=REDUNDANT)[0]

    return velocity_after


def _beside_bare(case: Case) -> Times:
    scene, q, v = case()
    return in_turn(partial(solve, scene, q, v), _by_hand(scene, q, v), rounds=BARE_ROUNDS)


def _rows(*cases: tuple[str, Case, float]) -> tuple[tuple[str, Callable[[], Times], float], ...]:
    return tuple((label, partial(_beside_bare, case), bound) for label, case, bound in cases)


# What is solved, its times, and the bound of solve over the calls by hand.
BESIDE_BARE = _rows(
    ("Solo12 on four feet", partial(landing, "solo12", 0.6, 0.3), 0.3),
    ("Solo12, four feet, Poisson", partial(landing, "solo12", 0.6, 0.3, law=Law("poisson")), 0.35),
    (
        "Solo12, four feet in sequence",
        partial(landing, "solo12", 0.6, 0.3, law=Law(order="sequential")),
        0.35,
    ),
    ("Talos on a corner along the path, Stronge", _one_foot, 0.7),
    ("Talos on eight points", partial(landing, "talos", 0.5), 0.5),
    ("Talos on eight points, all slip", partial(landing, "talos", 0.5, 0.3), 2.7),
    ("Talos on eight points, half of them slip", partial(landing, "talos", 0.1), 0.8),
    ("Talos on eight points, sliding", partial(landing, "talos", 0.3, along=2.0), 1.0),
    ("Talos, eight points, Poisson", partial(landing, "talos", 0.5, 0.3, law=Law("poisson")), 1.3),
    ("Talos held at both feet", _pinned, 0.4),
    ("struck four-bar", _four_bar, 0.2),
)
