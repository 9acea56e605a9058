"""Other programs agree with the exact answers, as far as what they do promises."""

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.methods.mechanism import mechanism_of
from benchmarks.methods.method import Method
from benchmarks.problems.registry import problems

BLOWS = ("struck chain", "struck robot")


def some(*families):
    """Problems of the quick kind."""
    return list(problems(quick=True, families=families))


def of(methods, name):
    """The methods of a name, over their setting."""
    found = [method for method in methods if method.name == name]
    assert found
    return found


def errors(methods, problem):
    """Over the setting."""
    return np.array([problem.error(method.prepare(problem)()) for method in methods])


@pytest.mark.parametrize("problem", some(*BLOWS, "foot", "cradle"), ids=lambda p: p.name)
def test_plain_numbers_tell_where_the_bodies_are(problem):
    mechanism = mechanism_of(problem)
    poses = []
    for body in mechanism.bodies:
        parent = poses[body.parent] if body.parent >= 0 else pin.SE3.Identity()
        pose = parent * pin.SE3(body.rotation, body.offset)
        if body.kind == "turn":
            pose = pose * pin.SE3(
                pin.AngleAxis(body.coordinate, body.axes[0]).matrix(), np.zeros(3)
            )
        if body.kind == "slide":
            pose = pose * pin.SE3(np.eye(3), body.coordinate * body.axes[0])
        poses.append(pose)
    assert np.allclose([p.rotation for p in poses], mechanism.rotations, atol=1e-14)
    assert np.allclose([p.translation for p in poses], mechanism.places, atol=1e-14)


@pytest.mark.parametrize("problem", some(*BLOWS), ids=lambda p: p.name)
@pytest.mark.parametrize("way", ["mass matrix", "forward", "batch"])
def test_mujoco_gives_the_jump_of_a_known_blow(way, problem):
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install ".[peers]"')
    from benchmarks.methods import mujoco

    assert errors(of(mujoco.METHODS, f"mujoco, {way}"), problem) < problem.tolerance


@pytest.mark.parametrize("problem", some(*BLOWS), ids=lambda p: p.name)
def test_exudyn_gives_the_jump_of_a_known_blow(problem):
    pytest.importorskip("exudyn", reason='Exudyn is a peer: pip install ".[peers]"')
    from benchmarks.methods import exudyn

    assert errors(of(exudyn.METHODS, "exudyn, mass matrix"), problem) < problem.tolerance
    assert errors(of(exudyn.METHODS, "exudyn, one step"), problem) < 1e-5


def test_a_method_says_which_package_it_lacks():
    method = Method("x", lambda problem: True, lambda problem: list, needs=("no-such-package",))
    assert "no-such-package" in method.missing()
    assert "peers" in method.missing()
