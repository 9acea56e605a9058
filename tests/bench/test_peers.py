"""Other programs agree with the exact answers, as far as what they do promises."""

import pathlib

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.methods import crocoddyl
from benchmarks.methods.mechanism import mechanism_of
from benchmarks.methods.method import Method
from benchmarks.problems.problem import Problem
from benchmarks.problems.registry import problems
from benchmarks.timing import TimesItself
from impulsekit.robot import Robot
from impulsekit.scene import Contact, Scene

MODELS = pathlib.Path(__file__).parents[2] / "models"
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


@pytest.mark.parametrize("problem", some("held robot", "closed chain"), ids=lambda p: p.name)
def test_mujocos_soft_holds_are_off_by_how_long_they_take(problem):
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install ".[peers]"')
    from benchmarks.methods import mujoco

    assert errors(of(mujoco.METHODS, "mujoco, soft contacts")[:1], problem) < 1e-5


@pytest.mark.parametrize("family", ["swing", "flight"])
def test_mujocos_motions_are_of_the_order_of_its_integrators(family):
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install ".[peers]"')
    from benchmarks.methods import mujoco

    problem = some(family)[-1]
    euler = errors(of(mujoco.METHODS, "mujoco, Euler"), problem)
    assert euler[0] / euler[1] == pytest.approx(10, rel=0.2)
    coarse, fine = errors(of(mujoco.METHODS, "mujoco, RK4")[:2], problem)
    assert coarse / fine > 100
    assert fine < problem.tolerance


def smooth_rod(e=0.5, angle=1.0):
    """The rod of 1 kg and 1 m that falls on its end at 1 m/s: P = (1 + e) m v/(1 + 3 cos² θ)."""
    rod = Robot.from_urdf(MODELS / "rod.urdf", root="planar")
    c, s = np.cos(angle), np.sin(angle)
    blow = (1 + e) / (1 + 3 * c**2)
    spin = -12 * blow * c / 2
    x, y = spin * s / 2, blow - 1 - spin * c / 2
    return Problem(
        "smooth rod",
        1,
        Scene(rod, contacts=[Contact("rod", normal=[0, 1, 0], restitution=e)]),
        rod.configuration(root_joint=[0, 0, angle]),
        np.array([-s, -c, 0.0]),
        lambda: np.array([c * x + s * y, c * y - s * x, spin]),
        "closed form",
    )


def test_exudyns_contacts_come_nearer_as_the_root_of_the_stiffness():
    pytest.importorskip("exudyn", reason='Exudyn is a peer: pip install ".[peers]"')
    from benchmarks.methods import exudyn

    contacts = of(exudyn.METHODS, "exudyn, contacts")
    softer, stiffer = errors([contacts[0], contacts[2]], smooth_rod())
    assert contacts[2].setting / contacts[0].setting == pytest.approx(100)
    assert softer / stiffer == pytest.approx(10, rel=0.2)
    # With friction its damper's restitution is nearly Stronge's, not quite.
    rough = errors(contacts[1:-1], some("rod along its path")[0])
    assert rough == pytest.approx(0.0085, rel=0.1)


def test_without_crocoddyl_it_says_how_to_get_it(monkeypatch):
    (method,) = crocoddyl.METHODS
    monkeypatch.delenv(crocoddyl.VARIABLE, raising=False)
    assert "--set-up" in method.missing()
    monkeypatch.setenv(crocoddyl.VARIABLE, "/no/such/python")
    assert "/no/such/python" in method.missing()


def test_crocoddyl_holds_robots_as_exactly():
    (method,) = crocoddyl.METHODS
    if method.missing():
        pytest.skip(method.missing())
    for problem in some("held robot", "closed chain"):
        assert method.suits(problem)
        answer = method.prepare(problem)
        assert isinstance(answer, TimesItself)
        assert problem.error(answer()) < problem.tolerance
        assert 0.0 < answer.seconds(10) < 1.0


def test_a_method_says_which_package_it_lacks():
    method = Method("x", lambda problem: True, lambda problem: list, needs=("no-such-package",))
    assert "no-such-package" in method.missing()
    assert "peers" in method.missing()
