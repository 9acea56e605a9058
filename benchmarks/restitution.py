"""``python -m benchmarks.restitution``: restitution by MuJoCo's recipes, and by impulsekit in it.

A sphere of 1 kg and 0.1 m drops 0.5 m on a plane, and another meets it at v = (2, -3) m/s with
e 0.6 and µ 0.3. Asked is the e that ``solref`` is to give: direct (-K, -B) with B = 2ζ√K, or (time
constant, ζ), where e = exp(-πζ/√(1-ζ²)) is that of a damped spring. Every recipe runs with both
cones, three integrators and four time steps. Exudyn takes e itself. Then twelve recorded tosses of
a cube.
"""

from __future__ import annotations

import importlib.util
import itertools
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import mujoco
import numpy as np

import impulsekit as ik
from benchmarks.motions import FRICTION, INERTIA, MASS, RESTITUTION, WIDTH, cube_scene
from impulsekit.mujoco import Impacts

from .restitution_exudyn import sphere_in_exudyn

RESULTS = Path(__file__).parent / "results/restitution"
EXAMPLES = Path(__file__).parents[1] / "examples"
ASKED = (0.9, 0.5, 0.25)
STEPS = (0.0005, 0.001, 0.002, 0.005)  # s
CONES, INTEGRATORS = ("pyramidal", "elliptic"), ("Euler", "RK4", "implicitfast")
DROP, GRAVITY, RADIUS = 0.5, 9.81, 0.1
# A sphere that sticks: v_x = 5/7 · 2 m/s, ω = v_x/r.
STICKS = (10 / 7, 100 / 7)


def damping_ratio(e: float) -> float:
    """Return ζ of the damped spring that gives e."""
    return float(-np.log(e) / np.hypot(np.pi, np.log(e)))


@dataclass(frozen=True)
class Recipe:
    """A way to restitution: its name, and solref by e; None for impulsekit inside MuJoCo.

    Attributes:
        frequency: ω [rad/s] by e of the undamped spring that solref means.
    """

    name: str
    solref: Callable[[float], str] | None
    instant: Literal["exact", "step"] = "exact"
    frequency: Callable[[float], float] = lambda e: float("nan")


def direct(stiffness: float) -> Recipe:
    """Return the recipe of a stiffness K [1/s²]."""
    root = float(np.sqrt(stiffness))
    return Recipe(
        f"solref -K -B, K = {stiffness:.0e}",
        lambda e: f"{-stiffness} {-2 * damping_ratio(e) * root}",
        frequency=lambda e: root,
    )


def peak_of_spring(recipe: Recipe, e: float) -> float:
    """Return the peak force on 1 kg of the spring and damper that a recipe means [N].

    MuJoCo's contact beyond the millimetre in which its impedance rises is z̈ = -K z - B ż less
    what is left of gravity, so F = v ω exp(-ζωt) ((1 - 2ζ²)/s sin sωt + 2ζ cos sωt), s = √(1 - ζ²),
    which is largest at cot sωt = ζ (3 - 4ζ²)/((1 - 4ζ²) s) for ζ < 1/2; and the weight.
    """
    ratio, omega = damping_ratio(e), recipe.frequency(e)
    s = np.sqrt(1 - ratio**2)
    angle = np.arctan2((1 - 4 * ratio**2) * s, ratio * (3 - 4 * ratio**2))
    shape = (1 - 2 * ratio**2) / s * np.sin(angle) + 2 * ratio * np.cos(angle)
    speed = np.sqrt(2 * GRAVITY * DROP)
    return float(speed * omega * np.exp(-ratio * angle / s) * shape + GRAVITY)


RECIPES = (
    *(direct(k) for k in (1e3, 1e4, 1e5)),
    Recipe(
        "solref 0.02 s, ζ",
        lambda e: f"0.02 {damping_ratio(e)}",
        frequency=lambda e: 1 / (0.02 * damping_ratio(e)),
    ),
    Recipe("impulsekit in MuJoCo", None),
    Recipe('impulsekit, instant="step"', None, "step"),
)


@dataclass(frozen=True)
class Bounce:
    """One bounce: e reached, depth [m], peak force [N]."""

    e: float
    depth: float
    force: float


def model_of(
    recipe: Recipe, e: float, cone: str, integrator: str, dt: float, more: str = ""
) -> Any:
    """Return the model of a sphere above a plane."""
    solref = f'solref="{recipe.solref(e)}"' if recipe.solref else ""
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
    <option cone="{cone}" integrator="{integrator}" timestep="{dt}" {more}/>
    <default><geom {solref} friction="0.3 0 0" condim="3"/></default><worldbody>
    <geom type="plane" size="9 9 .1"/><body pos="0 0 {RADIUS + DROP}"><freejoint/>
    <geom size="{RADIUS}" mass="1"/></body></worldbody></mujoco>""")


def stepper(recipe: Recipe, model: Any, data: Any, e: float) -> Callable[[], object]:
    """Return what advances the data by a step."""
    if recipe.solref:
        return lambda: mujoco.mj_step(model, data)
    impacts = Impacts(model, restitution=e, instant=recipe.instant)
    return lambda: impacts.step(data)


def bounce(recipe: Recipe, e: float, cone: str, integrator: str, dt: float) -> Bounce:
    """Return what the drop gives: e by the energy once the sphere has left the plane."""
    model = model_of(recipe, e, cone, integrator, dt)
    data = mujoco.MjData(model)
    step, depth, force, touched = stepper(recipe, model, data, e), 0.0, 0.0, False
    for _ in range(int(1.5 / dt)):
        step()
        gap, speed = data.qpos[2] - RADIUS, data.qvel[2]
        depth = max(depth, -gap)
        force = max(force, float(data.qfrc_constraint[2]))
        touched = touched or gap <= 0.0 or speed > 0.0
        if touched and gap > 0.0 and speed > 0.0:
            energy = 0.5 * speed**2 + GRAVITY * gap
            return Bounce(float(np.sqrt(energy / (GRAVITY * DROP))), depth, force)
    return Bounce(0.0, depth, force)


def sticking(recipe: Recipe, cone: str, integrator: str, dt: float) -> tuple[float, float]:
    """Return v_x and ω after the oblique impact, without gravity."""
    model = model_of(recipe, 0.6, cone, integrator, dt, 'gravity="0 0 0"')
    data = mujoco.MjData(model)
    data.qpos[2], data.qvel[:3] = RADIUS + 0.0031, (2.0, 0.0, -3.0)
    step = stepper(recipe, model, data, 0.6)
    for _ in range(int(0.6 / dt)):
        step()
        if data.qvel[2] > 0.0 and data.qpos[2] > RADIUS:
            break
    return float(data.qvel[0]), float(data.qvel[4])


def in_exudyn(stiffness: float) -> list[str]:
    """Return the cells of Exudyn's row, at a stiffness [N/m]."""
    if importlib.util.find_spec("exudyn") is None:
        return ["not installed", *[""] * 6]
    shape: dict[str, Any] = {"radius": RADIUS, "friction": 0.3}
    drop: dict[str, Any] = {
        "height": DROP,
        "v": (0.0, 0.0, 0.0),
        "gravity": GRAVITY,
        "duration": 0.8,
    }
    slide: dict[str, Any] = {
        "height": 0.0031,
        "v": (2.0, 0.0, -3.0),
        "gravity": 0.0,
        "duration": 0.2,
    }
    cells, depths, peaks = [], [], []
    for e in ASKED:
        reached = []
        for dt in STEPS:
            z, v, _, force = sphere_in_exudyn(e, stiffness, dt, **shape, **drop)
            i = int(np.argmax((z > RADIUS) & (v[:, 2] > 0.0)))
            energy = 0.5 * v[i, 2] ** 2 + GRAVITY * (z[i] - RADIUS)
            reached.append(np.sqrt(energy / (GRAVITY * DROP)))
            depths.append(1e3 * (RADIUS - z[: i + 1].min()))
            peaks += [force[: i + 1].max()] if e == 0.5 else []
        cells.append(spread(reached))
    ends = []
    for dt in STEPS:
        z, v, omega, _ = sphere_in_exudyn(0.6, stiffness, dt, **shape, **slide)
        i = int(np.argmax((z > RADIUS) & (v[:, 2] > 0.0)))
        ends.append((v[i, 0], omega[i, 1]))
    sliding = [spread([end[k] for end in ends]) for k in range(2)]
    return [*cells, spread(depths, "{:.2f}"), *sliding, spread(peaks, "{:.0f}"), ""]


def alone(e: float, slide: bool = False) -> np.ndarray:
    """Return the sphere's velocity after its first impact in ``impulsekit.simulate``."""
    model = model_of(RECIPES[-1], e, "elliptic", "RK4", 0.001)
    robot = ik.Robot.from_mjcf(model)
    contacts = ik.collisions(robot, restitution=e, friction=0.3)
    gravity = [0, 0, 0] if slide else [0, 0, -GRAVITY]
    scene = ik.Scene(robot, contacts=contacts, gravity=gravity)
    q, v = ik.mujoco_state(mujoco.MjData(model))
    v[:3] = (2.0, 0.0, -3.0) if slide else (0.0, 0.0, 0.0)
    return np.asarray(ik.simulate(scene, q, v, duration=0.4).impacts[0][1].v_after)


def tossed(name: str) -> list[str]:
    """Return a line of the table of recorded tosses: errors of position and rotation."""
    given = np.load(EXAMPLES / "cube_tosses.npz")
    apart, turned = [], []
    for first, last in itertools.pairwise(given["offset"].tolist()):
        rows = slice(first, last)
        at, turn = given["position"][rows], given["quaternion_wxyz"][rows].astype(float)
        start = at[0], turn[0], given["velocity"][first], given["omega_body"][first]
        found_at, found_turn = FLIGHTS[name](*start, len(at), float(given["rate_hz"]))
        apart.append(np.linalg.norm(found_at - at, axis=1).mean() / WIDTH)
        along = np.abs((found_turn * turn).sum(axis=1)) / np.linalg.norm(turn, axis=1)
        turned.append(np.degrees(2 * np.arccos(np.clip(along, 0.0, 1.0))).mean())
    return [name, f"{100 * np.mean(apart):.1f}", f"{np.mean(turned):.1f}"]


def in_mujoco(with_us: bool) -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """Return what follows a toss in MuJoCo, seven steps a sample."""

    def follow(at: Any, turn: Any, v: Any, omega: Any, count: int, rate: float) -> Any:
        model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="{1 / rate / 7}"
        integrator="RK4" cone="elliptic"/><default><geom friction="{FRICTION} 0 0"/></default>
        <worldbody><geom type="plane" size="9 9 .1"/><body><freejoint/>
        <geom type="box" size="{WIDTH / 2} {WIDTH / 2} {WIDTH / 2}" mass="0"/>
        <inertial pos="0 0 0" mass="{MASS}" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/>
        </body></worldbody></mujoco>""")
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = [*at, *turn], [*v, *omega]
        impacts = Impacts(model, restitution=RESTITUTION, law=ik.Law("poisson"))
        path = [data.qpos.copy()]
        for _ in range(count - 1):
            for _ in range(7):
                impacts.step(data) if with_us else mujoco.mj_step(model, data)
            path.append(data.qpos.copy())
        return np.array(path)[:, :3], np.array(path)[:, 3:]

    return follow


def by_simulate(at: Any, turn: Any, v: Any, omega: Any, count: int, rate: float) -> Any:
    """Follow a toss by ``impulsekit.simulate``."""
    scene = replace(cube_scene(), law=ik.Law("poisson"))
    turn = np.roll(turn / np.linalg.norm(turn), -1)
    rotation = ik.Robot.placement(scene.robot, np.array([*at, *turn]), "cube").rotation
    q, velocity = np.array([*at, *turn]), np.array([*(rotation.T @ v), *omega])
    motion = ik.simulate(scene, q, velocity, duration=(count - 1) / rate)
    path = np.array([motion.at(i / rate)[0] for i in range(count)])
    return path[:, :3], np.roll(path[:, 3:], 1, axis=1)


FLIGHTS = {
    "MuJoCo": in_mujoco(False),
    "impulsekit in MuJoCo": in_mujoco(True),
    "`impulsekit.simulate`": by_simulate,
}


def spread(values: Any, form: str = "{:.3f}") -> str:
    """Return the range of values as text."""
    low, high = form.format(min(values)), form.format(max(values))
    return low if low == high else f"{low} to {high}"


def measured() -> tuple[list[str], dict[str, list[tuple[float, float]]]]:
    """Return the lines of the table, and by recipe (dt, e) for e = 0.5."""
    grid = list(itertools.product(CONES, INTEGRATORS, STEPS))
    heads = ["recipe", *(f"e = {e}" for e in ASKED), "sinks [mm]"]
    heads += [f"v_x, {STICKS[0]:.4f}", f"ω, {STICKS[1]:.3f}", "peak at e = 0.5 [N]"]
    heads += ["over its spring's"]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    points: dict[str, list[tuple[float, float]]] = {}
    for recipe in RECIPES:
        by_e = {e: [bounce(recipe, e, *each) for each in grid] for e in ASKED}
        slides = [sticking(recipe, *each) for each in grid]
        points[recipe.name] = [(g[2], b.e) for g, b in zip(grid, by_e[0.5], strict=True)]
        every = [b for own in by_e.values() for b in own]
        forces, closed = np.array([b.force for b in by_e[0.5]]), peak_of_spring(recipe, 0.5)
        peak = [spread(forces, "{:.0f}"), spread(forces / closed, "{:.2f}")]
        cells = [spread([b.e for b in own]) for own in by_e.values()]
        cells += [spread([1e3 * b.depth for b in every], "{:.2f}")]
        cells += [spread([s[k] for s in slides]) for k in range(2)]
        cells += peak if recipe.solref else ["impulse", ""]
        lines.append(f"| {recipe.name} | {' | '.join(cells)} |")
    for stiffness in (1e4, 1e5):
        cells = in_exudyn(stiffness)
        lines.append(f"| Exudyn, k = {stiffness:.0e} N/m | {' | '.join(cells)} |")
    own = " | ".join(f"{alone(e)[2] / np.sqrt(2 * GRAVITY * DROP):.3f}" for e in ASKED)
    after = alone(0.6, slide=True)
    last = f"{after[0]:.3f} | {after[4]:.3f} | impulse | |"
    lines.append(f"| `impulsekit.simulate` | {own} | rigid | {last}")
    return lines, points


def draw(points: dict[str, list[tuple[float, float]]], path: Path) -> None:
    """Draw e reached against the time step."""
    import matplotlib as mpl

    mpl.use("svg")
    import matplotlib.pyplot as plt

    fig, ax = plt.subplots(figsize=(7, 4))
    for i, (name, own) in enumerate(points.items()):
        dt, e = np.transpose(own)
        ax.plot(dt * 1e3 * (1 + 0.03 * i), e, "o", ms=4, label=name)
    ax.axhline(0.5, color="0.6", lw=0.8, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel="time step [ms]", ylabel="e reached, asked 0.5")
    ax.legend(fontsize=7)
    fig.tight_layout()
    fig.savefig(path)


def main() -> int:
    """Write the table and its picture to ``benchmarks/results``."""
    lines, points = measured()
    lines += [
        "",
        "| recorded tosses | position [% of the width] | rotation [deg] |",
        "|---|---|---|",
    ]
    lines += [f"| {' | '.join(tossed(name))} |" for name in FLIGHTS]
    (RESULTS / "restitution.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    draw(points, RESULTS / "restitution.svg")
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
