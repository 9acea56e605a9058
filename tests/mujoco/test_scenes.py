"""Impacts in random scenes of MuJoCo: e is kept, energy falls, and a Scene says the same."""

import importlib
import itertools
import pickle
from pathlib import Path

import mujoco
import numpy as np
import pytest

import impulsekit as ik
from impulsekit.mujoco import Impacts
from impulsekit.robot.examples import example_names, example_path

from .scenes import random_scene, urdf_scene

POISSON, SEQUENCE = ik.Law("poisson"), ik.Law("newton", order="sequential")
ALONG_PATH = ik.Law("stronge", slip="path")
MANY = pytest.mark.sweep


def impacts_of(scene, count, steps=4000, **given):
    """The impacts of a scene, as many as asked for."""
    impacts = Impacts(scene.model, scene.restitution, **given)
    log = impacts.log()
    for _ in range(steps):
        impacts.step(scene.data)
        if len(log) >= count:
            break
    return log


def check_restitution(hits):
    """Check that each contact that carried an impulse parts at e times its approach speed."""
    for hit in hits:
        target = hit.restitution * np.maximum(hit.approach, 0.0)
        impulses = np.einsum("ni,ni->n", hit.impulses, hit.normals)
        pressed = impulses > 1e-12 * impulses.sum()
        # Rounding of J (v + Δv).
        J = np.abs(hit.parts.J[: len(pressed), 2])
        bar = 1e-12 * (J @ (np.abs(hit.qvel) + np.abs(hit.dv))).max(initial=0.0)
        assert (np.abs(hit.separation - target)[pressed] < bar).all()
        assert (hit.separation - target > -bar).all()


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
@pytest.mark.parametrize(
    ("seeds", "count"), [(range(8), 20), pytest.param(range(100), 120, marks=MANY)]
)
def test_restitution_is_kept_by_every_contact(seeds, count):
    hits = [hit for seed in seeds for hit in impacts_of(random_scene(seed), count)]
    kept = [hit for hit in hits if hit.status.valid]
    # Newton's law raises the energy of some impacts with friction; they are flagged.
    assert len(kept) > 0.95 * len(hits) > 60
    check_restitution(kept)


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
@pytest.mark.parametrize(
    ("package", "folder", "names"),
    [
        ("gymnasium", "envs/mujoco/assets", ["ant", "half_cheetah", "hopper", "humanoid"]),
        ("dm_control", "suite", ["walker", "quadruped", "humanoid_CMU", "manipulator"]),
    ],
)
def test_models_of_others_keep_restitution(package, folder, names):
    home = Path(pytest.importorskip(package).__file__).parent / folder
    texts = {}
    if package == "dm_control":
        texts = importlib.import_module("dm_control.suite.common").ASSETS
    for name in names:
        text = (home / f"{name}.xml").read_text(encoding="utf-8")
        model = mujoco.MjModel.from_xml_string(text, texts)
        kept = kept_impacts(model, ik.Law())
        check_restitution(kept)
        for hit in kept_impacts(model, POISSON):
            # Equalities do work where MuJoCo's softness lets them move.
            if not hit.parts.equalities:
                assert hit.energy_change < 1e-12 * abs(hit.parts.mass @ hit.qvel @ hit.qvel), name


def kept_impacts(model, law):
    """The impacts of a model that falls for 600 steps, nearly all of them with an answer."""
    data, impacts = mujoco.MjData(model), Impacts(model, 0.5, law=law, limits=0.2)
    log = impacts.log()
    data.qvel[:] = np.random.default_rng(1).normal(size=model.nv)
    for _ in range(600):
        impacts.step(data)
    kept = [hit for hit in log if hit.status.valid]
    assert len(kept) > 0.8 * len(log) > 0
    return kept


def scene_of(hit, random, robot, law):
    """The impact as a scene of the robot that is read from the same MJCF."""
    model, data = random.model, mujoco.MjData(random.model)
    data.qpos[:], data.qvel[:] = hit.qpos, hit.qvel
    mujoco.mj_kinematics(model, data)
    slide, spin, roll = random.friction
    contacts = []
    for (first, second), at, normal, e in zip(
        hit.pairs, hit.positions, hit.normals, hit.restitution, strict=True
    ):
        bodies = [data.body(model.geom(name).bodyid[0]) for name in (first, second)]
        (own, moved), (plane, origin) = (
            (body.xmat.reshape(3, 3), at - body.xpos) for body in reversed(bodies)
        )
        contacts.append(
            ik.Contact(
                bodies[1].name, at=own.T @ moved, against=bodies[0].name, origin=plane.T @ origin,
                normal=plane.T @ normal, restitution=e,
                friction=slide if random.condim > 1 else 0.0,
                torsion=spin if random.condim > 3 else 0.0,
                rolling=roll if random.condim == 6 else 0.0,
            )
        )  # fmt: skip
    return ik.Scene(robot, contacts=contacts, law=law), *ik.mujoco_state(data)


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
@pytest.mark.parametrize(
    ("condim", "law"),
    # A sequence takes no resistance to rolling.
    [*itertools.product([1, 3, 4, 6], [ik.Law(), POISSON]), (1, SEQUENCE), (3, SEQUENCE)],
)
def test_a_scene_of_the_same_robot_says_the_same(condim, law):
    compared = 0
    for seed in range(4):
        random = random_scene(seed, condim)
        robot = ik.Robot.from_mjcf(random.model)
        for hit in impacts_of(random, 6, law=law):
            scene, q, v = scene_of(hit, random, robot, law)
            impact = ik.solve(scene, q, v)
            assert impact.status == hit.status
            if hit.status.valid:
                check_velocity(random, hit, impact, q)
                compared += 1
    assert compared > 15


def check_velocity(scene, hit, impact, q):
    """Check v⁺ inside MuJoCo against that of an impact of the same robot at q."""
    data = mujoco.MjData(scene.model)
    ik.set_mujoco_state(data, q, impact.v_after)
    after = hit.qvel + hit.dv
    assert np.allclose(data.qvel, after, rtol=1e-10, atol=1e-10 * np.abs(after).max())


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
def test_an_impact_reports_the_same_after_pickling():
    for hit in impacts_of(random_scene(3, 6), 3, limits=0.5):
        again = pickle.loads(pickle.dumps(hit))
        assert again.to_dict() == hit.to_dict()
        assert repr(again) == repr(hit)
        assert (again.residual, again.status) == (hit.residual, hit.status)
        for name in ("positions", "normals", "moments", "restitution", "dv"):
            assert np.array_equal(getattr(again, name), getattr(hit, name))
        for body, wrench in hit.joint_impulses.items():
            assert np.array_equal(again.joint_impulses[body], wrench)


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
def test_robots_of_urdf_files_keep_restitution_and_velocities():
    paths = sorted({example_path(name) for name in example_names()})
    scenes = [scene for scene in map(urdf_scene, paths) if scene is not None]
    assert len(scenes) > 40
    compared = 0
    for random in scenes:
        kept = [hit for hit in impacts_of(random, 12, steps=300) if hit.status.valid]
        check_restitution(kept)
        robot = ik.Robot.from_mjcf(random.model)
        for hit in kept if not random.model.neq else ():
            scene, q, v = scene_of(hit, random, robot, ik.Law())
            impact = ik.solve(scene, q, v)
            assert impact.status == hit.status
            check_velocity(random, hit, impact, q)
            compared += 1
    assert compared > 200


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
@pytest.mark.parametrize(("law", "bodies"), [(POISSON, 2), (SEQUENCE, 2), (ALONG_PATH, 1)])
@pytest.mark.parametrize("seeds", [range(6), pytest.param(range(340), marks=MANY)])
def test_no_impact_of_a_fall_adds_energy(law, bodies, seeds):
    count = 0
    for seed in seeds:
        # Stronge's law along the path is of one contact at a time.
        order = "sequential" if law is ALONG_PATH else law.order
        own = ik.Law(law.restitution, slip=law.slip, order=order)
        random = random_scene(seed, 3, bodies)
        for hit in impacts_of(random, 20, law=own):
            if hit.status.valid:
                size = abs(hit.parts.mass @ hit.qvel @ hit.qvel)
                assert hit.energy_change < 1e-12 * size
                count += 1
    assert count > 60
