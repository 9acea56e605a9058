"""Many states: ``solve_batch`` against Python loops over bare Pinocchio, and MuJoCo's batch.

Run with ``python -m impulsekit.bench.batch``. Times are per state; ratios are of medians of
rounds timed in turn.
"""

from __future__ import annotations

import contextlib
import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from ..batch import run
from ..batch.long import long_chain
from ..batch.solve import solve_batch, warm_up
from ..impact import Status, solve
from ..robot import Robot
from ..scene import AppliedImpulse, Contact, Law, Scene
from .claim import Claim
from .contacts import CORNERS, SOLES, bare_admm, bare_impulse_dynamics
from .known_blow import AT, LINEAR, bare_pinocchio
from .timing import time_in_turn

__all__ = ["claims", "main"]

STATES = 16384
HAND = "gripper_left_base_link"
LOOP = 256


def _states(robot: Robot, count: int, spread: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    steps = rng.uniform(-spread, spread, (count, robot.nv))
    q = np.array([pin.integrate(robot.model, robot.neutral(), step) for step in steps])
    return q, rng.normal(size=(count, robot.nv))


def _row(
    label: str,
    batch: Callable[[], object],
    states: int,
    bare: Callable[[], object],
    loop: int,
    goal: float,
) -> Claim:
    times = time_in_turn({"batch": batch, "bare": bare}, rounds=15)
    return Claim.of_ratio(
        label,
        times["batch"],
        times["bare"],
        goal,
        our_calls=states,
        their_calls=loop,
        at_least=True,
    )


def _repeated(calls: Sequence[Callable[[], object]], count: int) -> Callable[[], None]:
    def run() -> None:
        for i in range(count):
            calls[i % len(calls)]()

    return run


def _against_pinocchio() -> Iterator[Claim]:
    for name, root, frame, goal in (
        ("panda", "fixed", "panda_hand", 30.0),
        ("talos", "freeflyer", HAND, 15.0),
    ):
        robot = Robot.from_example(name, root=root)
        q, v = _states(robot, STATES)
        scene = Scene(robot, [AppliedImpulse(frame, LINEAR, at=AT)])
        bare = [bare_pinocchio(robot, frame, one) for one in q[:16]]
        label = f"{name}, nv {robot.nv}: known blow"
        call = _bound(scene, q, v)
        yield _row(label, call, STATES, _repeated(bare, LOOP), LOOP, goal)
    solo = Robot.from_example("solo12", root="freeflyer")
    q, v = _states(solo, STATES)
    scene = Scene(solo, contacts=[Contact("FR_FOOT", friction=0.6, restitution=0.3)])
    few = list(zip(q[:16], v[:16], strict=True))
    call = _bound(scene, q, v)
    stuck = [_bare_stick(solo, "FR_FOOT", *state) for state in few]
    label = "solo12: one contact, friction; theirs sticks"
    yield _row(label, call, STATES, _repeated(stuck, LOOP), LOOP, 20.0)
    stuck = [bare_impulse_dynamics(solo, "FR_FOOT", (0.0, 0.0, 0.0), *state) for state in few]
    label = "the same against impulseDynamics"
    yield _row(label, call, STATES, _repeated(stuck, LOOP), LOOP, 20.0)
    talos = Robot.from_example("talos", root="freeflyer")
    q, v = _states(talos, 1024, spread=0.1)
    v *= 0.2
    v[:, 2] -= 1.0
    contacts = [Contact(sole, at=at, friction=0.5) for sole in SOLES for at in CORNERS]
    eight = [bare_admm(talos, *s, 0.5, 1e-8) for s in zip(q[:16], v[:16], strict=True)]
    call = _bound(Scene(talos, contacts=contacts), q, v)
    found = solve_batch(Scene(talos, contacts=contacts), q, v).count()
    note = ", ".join(f"{n} {code.name}" for code, n in found.items())
    label = "talos: eight foot points, ADMM to 1e-8"
    yield replace(_row(label, call, 1024, _repeated(eight, 16), 16, 5.0), note=note)


def _against_solve() -> Iterator[Claim]:
    """Laws beside the default, against the way without kernels: one state after the other."""
    solo = Robot.from_example("solo12", root="freeflyer")
    q, v = _states(solo, 4096)
    names = ("FR_FOOT", "FL_FOOT", "HR_FOOT", "HL_FOOT")
    feet = [Contact(name, friction=0.6, restitution=0.3) for name in names]
    for what, count, law, goal in (
        ("Stronge along the path", 1, Law("stronge", slip="path"), 50.0),
        ("Poisson", 1, Law("poisson"), 30.0),
        ("Poisson at four feet", 4, Law("poisson"), 20.0),
        ("four feet in sequence", 4, Law(order="sequential"), 40.0),
    ):
        scene = Scene(solo, contacts=feet[:count], law=law)
        single = [
            partial(_solved_alone, scene, *state) for state in zip(q[:64], v[:64], strict=True)
        ]
        label = f"solo12: {what}; theirs solve one by one"
        yield _row(label, _bound(scene, q, v), len(q), _repeated(single, 64), 64, goal)


def _solved_alone(scene: Scene, q: np.ndarray, v: np.ndarray) -> Status:
    """What a row of a batch is: Δv and the status."""
    return solve(scene, q, v).status


def _bare_stick(robot: Robot, frame: str, q: np.ndarray, v: np.ndarray) -> Callable[[], object]:
    """A foot that neither slips nor parts: Jacobian, CRBA, Cholesky, solves, by hand."""
    model = pin.Model(robot.model)
    data, frame_id = model.createData(), model.getFrameId(frame)

    def velocity_after() -> np.ndarray:
        jacobian = pin.computeFrameJacobian(model, data, q, frame_id, pin.LOCAL_WORLD_ALIGNED)[:3]
        pin.crba(model, data, q)
        pin.cholesky.decompose(model, data)
        moved = np.array([pin.cholesky.solve(model, data, row) for row in jacobian])
        impulse = np.linalg.solve(moved @ jacobian.T, -(jacobian @ v))
        return v + impulse @ moved

    return velocity_after


def _bound(scene: Scene, q: np.ndarray, v: np.ndarray) -> Callable[[], object]:
    warm_up(scene)
    return lambda: solve_batch(scene, q, v)


def _against_mujoco() -> Iterator[Claim]:
    try:
        import mujoco
        from mujoco.batch import Batch
    except ImportError:
        return
    count = 4096
    for name, root, frame in (
        ("panda", "fixed", "panda_hand"),
        ("solo12", "freeflyer", "FR_FOOT"),
        ("talos", "freeflyer", HAND),
    ):
        robot = Robot.from_example(name, root=root)
        q, v = _states(robot, count)
        scene = Scene(robot, [AppliedImpulse(frame, LINEAR, at=AT)])
        model = _mujoco_model(mujoco, robot, root)
        peer = Batch(model, count)
        peer.bind("qpos")[:] = _mujoco_q(q, root)
        label = f"{name}, nv {robot.nv}: MuJoCo's batch forward, nv {model.nv}"
        yield _row(label, _bound(scene, q, v), count, peer.forward, count, 5.0)


def _mujoco_model(mujoco: Any, robot: Robot, root: str) -> Any:
    """The same bodies and joints without any geometry, so that nothing but dynamics is timed."""
    text = robot.parts[0].urdf or ""
    text = re.sub(r"<(visual|collision|transmission)\b.*?</\1>", "", text, flags=re.S)
    head = '<mujoco><compiler fusestatic="true" balanceinertia="true"/></mujoco>'
    spec = mujoco.MjSpec.from_string(re.sub(r"(<robot[^>]*>)", rf"\1{head}", text, count=1))
    if root == "freeflyer":
        spec.worldbody.first_body().add_freejoint()
    return spec.compile()


def _mujoco_q(q: np.ndarray, root: str) -> np.ndarray:
    """MuJoCo's quaternions are w, x, y, z."""
    if root == "freeflyer":
        q = q.copy()
        q[:, 3:7] = q[:, [6, 3, 4, 5]]
    return q


def _throughput(write: Callable[[str], object]) -> None:
    solo = Robot.from_example("solo12", root="freeflyer")
    talos = Robot.from_example("talos", root="freeflyer")
    foot = Contact("FR_FOOT", friction=0.6, restitution=0.3)
    for label, scene in (
        ("talos, known blow", Scene(talos, [AppliedImpulse(HAND, LINEAR, at=AT)])),
        ("solo12, one contact with friction", Scene(solo, contacts=[foot])),
    ):
        q, v = _states(scene.robot, 65536)
        write(f"{label}, million states a second, by batch size, threads and lanes\n")
        write(f"{'':16s}{'8 of float64':>28s}{'16 of float32':>28s}\n")
        write(f"{'':16s}{'1 thread':>14s}{'2 threads':>14s}{'1 thread':>14s}{'2 threads':>14s}\n")
        for size in (16, 256, 4096, 65536):
            line = f"  {size:6d} states "
            for dtype in (np.float64, np.float32):
                for threads in (1, 2):
                    call = partial(solve_batch, scene, q[:size], v[:size])
                    taken = _fastest(partial(call, threads=threads, dtype=dtype))
                    line += f"{size / taken / 1e6:14.2f}"
            write(line + "\n")
        write("  65536 states, 2 threads, by blocks of lanes in one call of a kernel:")
        for blocks in (8, 64, 512, 4096):
            with _pieces_of(blocks):
                taken = _fastest(partial(solve_batch, scene, q, v, threads=2))
            write(f"   {blocks}: {len(q) / taken / 1e6:.2f}")
        write("\n")


@contextlib.contextmanager
def _pieces_of(blocks: int) -> Iterator[None]:
    """Kernels called for so many blocks at a time, instead of as many as are good."""
    kept = run.SMALLEST_PIECE, run.LARGEST_PIECE
    run.SMALLEST_PIECE = run.LARGEST_PIECE = blocks
    try:
        yield
    finally:
        run.SMALLEST_PIECE, run.LARGEST_PIECE = kept


def _long_chains(write: Callable[[str], object]) -> None:
    sizes = (1_000, 10_000, 100_000, 1_000_000)
    times = []
    for links in sizes:
        chain = long_chain(links)
        blow = [AppliedImpulse(f"link_{links}", linear=[0, 5, 0], at=[1, 0, 0])]
        times.append(_fastest(partial(chain.solve, blow), 3))
        write(f"chain of {links:8d} links: {1e3 * times[-1]:9.3f} ms\n")
    slope = np.polyfit(np.log(sizes), np.log(times), 1)[0]
    write(f"slope of time over links {slope:.3f}   1.05 {'reached' if slope <= 1.05 else 'NOT'}\n")


def _fastest(call: Callable[[], object], rounds: int = 7) -> float:
    taken = []
    call()
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        taken.append(time.perf_counter() - start)
    return min(taken)


def claims() -> Iterator[Claim]:
    """How many times quicker a state of a batch is."""
    yield from _against_pinocchio()
    yield from _against_solve()
    yield from _against_mujoco()


def main() -> None:
    """Measure and write the rows."""
    write = sys.stdout.write
    for claim in claims():
        write(claim.line())
    _throughput(write)
    _long_chains(write)


if __name__ == "__main__":
    main()
