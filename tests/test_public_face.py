"""The names of the package: few at the top, the rest one module down, and what editors learn."""

import importlib
import inspect
import re
import subprocess
import sys

import pytest

import impulsekit as ik

MODULES = ["compliance", "design", "errors", "long", "measured", "models", "plots", "study"]
FURTHER = {
    "compliance": [
        "ForceHistory",
        "peak_forces",
        "PowerCurve",
        "TransientContact",
        "BodyRegion",
        "ISO_TS_15066",
    ],
    "design": ["effective_mass", "impact_ellipsoid", "least_blow", "worst_blow", "spare_joint"],
    "measured": ["fit_impacts", "Measurement", "Fit", "Recording", "load_measurements"],
    "study": ["Study", "Variation", "run_study", "open_study", "load_study", "summarize"],
    "long": ["long_chain", "long_tree", "LongTree", "LongImpact"],
    "models": ["chain_urdf", "pendulum_urdf", "example_names", "rotor_inertias"],
    "impact": ["ImpactSolver", "Outcomes"],
    "scene": ["MotionSettings", "ReportPoint", "DesignPoint"],
    "scenefile": ["SceneFile", "dump_scene"],
    "checking": ["Check"],
    "view": ["Replay"],
}


def test_names_of_the_first_hour_stand_at_the_top():
    assert {*MODULES, "Robot", "Scene", "solve", "solve_batch", "simulate"} <= set(ik.__all__)
    assert set(dir(ik)) == set(ik.__all__)
    functions_and_classes = [n for n in ik.__all__ if n not in MODULES]
    # A list that is read in one look: what comes later belongs into a module.
    assert len(functions_and_classes) <= 68, functions_and_classes


@pytest.mark.parametrize(("room", "names"), FURTHER.items())
def test_the_rest_stands_one_module_down(room, names):
    module = importlib.import_module(f"impulsekit.{room}")
    for name in names:
        assert name in module.__all__ and name not in ik.__all__
        assert getattr(module, name) is getattr(ik, name, getattr(module, name))
    with pytest.raises(AttributeError, match="nothing"):
        _ = module.nothing


def test_a_name_that_is_elsewhere_is_found():
    for name, room in (("effective_mass", "design"), ("Check", "checking"), ("LongTree", "long")):
        with pytest.raises(AttributeError, match=f"at the top; it is impulsekit.{room}.{name}"):
            getattr(ik, name)
    assert importlib.import_module("impulsekit.plots") is ik.plots


def test_a_module_that_is_not_there_yet_has_to_be_imported(monkeypatch):
    monkeypatch.delattr(ik, "jax", raising=False)
    with pytest.raises(AttributeError, match="import impulsekit"):
        _ = ik.jax


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="simulat"):
        _ = ik.simulat


def test_the_methods_of_a_robot_have_types():
    """Whatever a robot is read from, built with or asked for."""
    for name in dir(ik.Robot):
        method = inspect.getattr_static(ik.Robot, name)
        function = getattr(method, "__func__", method)
        if not name.startswith("_") and inspect.isfunction(function):
            assert "Any" not in str(inspect.signature(function)), name
    assert "Any" not in str(inspect.signature(ik.combine))


PROGRAM = """
import numpy as np

import impulsekit as ik
from impulsekit.measured import Measurement, fit_impacts

robot = ik.combine(arm=ik.Robot.from_example("panda"))
scene = ik.Scene(
    robot,
    impulses=[ik.AppliedImpulse("arm/panda_hand", linear=[0, 0, 1]), ik.JointImpulse("a", [0.4])],
    constraints=[ik.JointLock("panda_joint1"), ik.PointAnchor("b", velocity="kept")],
    contacts=[ik.Contact("c", normal=np.array([0, 0, 1.0]), restitution=0.2, friction=0.6)],
    forces=[ik.JointSpring("arm/panda_joint2", stiffness=5)],
    law=ik.Law(restitution="poisson", slip="end"),
    gravity=[0, 0, -9.81],
)
q, v = robot.configuration(elbow=0.3), robot.velocity({"elbow": -1.0})
impact = ik.solve(scene, q, v)
batch = ik.solve_batch(scene, np.tile(q, (4, 1)), [[0.0]], restitution=0.5)
motion = ik.simulate(scene, q, v, duration=0.1)
reveal_type(impact)  # Impact
reveal_type(impact.v_after)  # ndarray
reveal_type(impact.energy.change)  # float
reveal_type(impact.energy.work)  # Mapping[str, float]
reveal_type(impact.status)  # Status
reveal_type(impact.residuals.momentum)  # float
reveal_type(impact.is_valid())  # bool
reveal_type(impact.contacts[0])  # ContactResult
reveal_type(impact.contacts["floor"].impulse)  # ndarray
reveal_type(impact.contacts[0].mode)  # str
reveal_type(impact.contacts[:1][0].work)  # float
reveal_type([each.name for each in impact.contacts])  # list[str]
reveal_type(impact.constraints[0].unique)  # bool
reveal_type(impact.bodies["hand"].dv_com)  # ndarray
reveal_type(impact.reactions["elbow"])  # ndarray
reveal_type(batch)  # ImpactBatch
reveal_type(batch.v_after)  # ndarray
reveal_type(batch.status)  # ndarray
reveal_type(motion)  # Trajectory
reveal_type(motion.q)  # ndarray
reveal_type(motion.impacts[0])  # tuple[float, Impact]
reveal_type(motion.at(0.05)[0])  # ndarray
reveal_type(motion.energy().total)  # ndarray
reveal_type(motion.status)  # MotionStatus
reveal_type(ik.check(impact).agrees)  # bool
reveal_type(ik.report(impact))  # str
reveal_type(ik.derivatives(impact)["v_after", "q"])  # ndarray
reveal_type(ik.load_scene("a.toml").scene)  # Scene
reveal_type(ik.design.effective_mass(robot, q, "hand", [0, 0, 1]))  # float
reveal_type(fit_impacts([Measurement(scene, q, v, v)]))  # Fit
"""


@pytest.mark.slow
def test_a_strict_checker_knows_the_type_of_every_result(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "program.py").write_text(PROGRAM)
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    done = subprocess.run(
        [*command, "program.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    lines = PROGRAM.splitlines()
    found = re.findall(r'program\.py:(\d+): note: Revealed type is "(.+)"', done.stdout)
    assert len(found) == PROGRAM.count("reveal_type")
    for number, revealed in found:
        expected = lines[int(number) - 1].rpartition("# ")[2]
        # numpy's own Any is the shape and, of a plain ndarray, the dtype.
        short = re.sub(r"numpy\.ndarray\[.*?dtype\[.*?\]\]", "ndarray", revealed)
        short = re.sub(r"\b(?:\w+\.)+", "", short)
        assert short == expected, (expected, revealed)
