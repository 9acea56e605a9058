"""What each step that is skipped saves: the job with it done anyway, against as it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pinocchio as pin

from ..batch.result import OUTPUTS
from ..batch.solve import solve_batch, warm_up
from ..impact import Impact, solve
from ..impact.algorithms import ByCrba, cholesky_solve, crba, decompose
from ..impact.constrained import ConstrainedJump
from ..impact.factor import SparseFactor
from ..impact.known import KnownImpulses
from ..robot import Robot
from ..robot.combine import combine
from ..rows.reach import reached_model, touched_joints
from ..scene import AppliedImpulse, Contact, Scene
from .claim import Claim
from .problems.feet import CORNERS, SOLES
from .problems.robots import AT, LINEAR
from .problems.states import drawn_state
from .timing import Times, Timing, import_times, time_in_turn

__all__ = ["claims"]

HAND = "gripper_left_base_link"


def claims() -> Iterator[Claim]:
    """A row for every step."""
    yield _delassus()
    yield _branches()
    yield _single_contact()
    yield from _results()
    yield from _outputs()
    yield _geometry()
    yield from _imports()


def _saved(label: str, skipped: Timing, done: Timing) -> Claim:
    """How many times longer it takes with the step; skipping it must never cost."""
    return Claim.of_ratio(label, Times(skipped, done), 1.0, at_least=True)


def _delassus() -> Claim:
    """Of a known blow, the response of the struck point to itself is not needed."""
    talos = Robot.from_example("talos", root="freeflyer")
    scene = Scene(talos, [AppliedImpulse(HAND, LINEAR, at=AT)])
    q, _ = drawn_state(talos, 0)
    reached = reached_model(talos.model, touched_joints(scene))
    known = KnownImpulses(scene, reached)
    model, data = reached.model, reached.model.createData()
    own = reached.configuration(q)
    (blow,) = known.blows

    def through_delassus() -> tuple[np.ndarray, np.ndarray]:
        jacobian = pin.computeFrameJacobian(model, data, own, blow.frame_id, blow.reference)
        crba(model, data, own)
        decompose(model, data)
        half = SparseFactor(model, data).half(jacobian)
        return half.T @ half, cholesky_solve(model, data, blow.wrench @ jacobian)

    direct = ByCrba(known, always_regular=True)
    times = time_in_turn({"no": lambda: direct.velocity_jump(own), "yes": through_delassus})
    return _saved("Talos, known blow: no Delassus matrix", times["no"], times["yes"])


def _branches() -> Claim:
    """Four Pandas side by side, one of them struck."""
    panda = Robot.from_example("panda")
    four = combine(a=panda, b=panda, c=panda, d=panda)
    scene = Scene(four, [AppliedImpulse("c/panda_hand", LINEAR, at=AT)])
    q, _ = drawn_state(four, 0)
    ways: dict[str, Callable[[], object]] = {}
    for name, joints in (("no", touched_joints(scene)), ("yes", range(1, four.model.njoints))):
        reached = reached_model(four.model, joints)
        way = ByCrba(KnownImpulses(scene, reached), always_regular=True)
        own = reached.configuration(q)
        ways[name] = lambda way=way, own=own: way.velocity_jump(own)  # type: ignore[misc]
    times = time_in_turn(ways)
    return _saved("one of four Pandas: unreached branches left out", times["no"], times["yes"])


def _single_contact() -> Claim:
    """One contact in closed form, against the way of many contacts."""
    talos = Robot.from_example("talos", root="freeflyer")
    scene = Scene(talos, contacts=[Contact(SOLES[0], at=CORNERS[0], friction=0.5)])
    q, v = talos.neutral(), drawn_state(talos, 0)[1] - 2.0 * np.eye(talos.nv)[2]
    reached = reached_model(talos.model, touched_joints(scene))
    general = ConstrainedJump(scene, KnownImpulses(scene, reached), reached)
    times = time_in_turn(
        {
            "no": lambda: solve(scene, q, v),
            "yes": lambda: Impact(scene, q, v, *general.solve(reached.configuration(q), v)),
        }
    )
    return _saved("Talos, one contact: no general contact solver", times["no"], times["yes"])


def _results() -> Iterator[Claim]:
    """Δv alone, against all that an ``Impact`` can tell."""
    talos = Robot.from_example("talos", root="freeflyer")
    blow = AppliedImpulse(HAND, LINEAR, at=AT)
    feet = [Contact(sole, at=at, friction=0.5) for sole in SOLES for at in CORNERS]
    q = talos.neutral()
    for label, scene, down in (
        ("Talos, known blow", Scene(talos, [blow]), 0.0),
        ("Talos, eight foot points", Scene(talos, contacts=feet), 1.0),
    ):
        v = 0.1 * drawn_state(talos, 0)[1] - down * np.eye(talos.nv)[2]

        def everything(scene: Scene = scene, v: np.ndarray = v) -> object:
            return solve(scene, q, v).to_dict()

        def checked(scene: Scene = scene, v: np.ndarray = v) -> object:
            return solve(scene, q, v).is_valid()

        def jump(scene: Scene = scene, v: np.ndarray = v) -> object:
            return solve(scene, q, v).dv

        times = time_in_turn({"jump": jump, "checked": checked, "everything": everything})
        yield _saved(f"{label}: no residuals and status", times["jump"], times["checked"])
        yield _saved(f"{label}: no results but dv", times["jump"], times["everything"])


def _outputs() -> Iterator[Claim]:
    """A batch with v⁺ alone, against all outputs."""
    talos = Robot.from_example("talos", root="freeflyer")
    scene = Scene(talos, [AppliedImpulse(HAND, LINEAR, at=AT)])
    blows = np.random.default_rng(0).normal(size=(16384, 3))
    q = talos.neutral()
    warm_up(scene)
    times = time_in_turn(
        {
            "no": lambda: solve_batch(scene, q, impulses=blows),
            "yes": lambda: solve_batch(scene, q, impulses=blows, outputs=OUTPUTS),
        },
        rounds=21,
    )
    yield _saved("Talos, batch of 16384: no outputs but v_after", times["no"], times["yes"])


def _geometry() -> Claim:
    """A robot read without its geometry, which is built when first asked for."""

    def with_geometry() -> object:
        robot = Robot.from_example("talos")
        return robot.collision_model

    times = time_in_turn(
        {"no": lambda: Robot.from_example("talos"), "yes": with_geometry}, rounds=5
    )
    return _saved("load Talos: no collision geometry", times["no"], times["yes"])


def _imports() -> Iterator[Claim]:
    """Names that load what they need when they are used, against all of them at once."""
    everything = "import impulsekit; [getattr(impulsekit, name) for name in impulsekit.__all__]"
    times = import_times(["import impulsekit", "from impulsekit import solve", everything], 7)
    bare, some, whole = times.values()
    yield _saved("import impulsekit: no libraries", bare, whole)
    yield _saved("from impulsekit import solve: no other rooms", some, whole)
