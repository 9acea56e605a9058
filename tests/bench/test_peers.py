"""Other programs agree with the exact answers, as far as what they do promises."""

import pathlib
import sys

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.methods import crocoddyl
from benchmarks.methods.mechanism import mechanism_of
from benchmarks.methods.method import Method, damping_ratio, restitution_of
from benchmarks.problems.problem import Problem
from benchmarks.problems.registry import problems
from benchmarks.timing import TimesItself, time_in_turn
from impulsekit.errors import ImpulsekitError
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
def test_rates_of_slides_and_turns_are_pinocchios_velocities(problem):
    """The kinetic energy of the plain bodies is that of the model."""
    model, v = problem.scene.robot.model, np.random.default_rng(0).normal(size=len(problem.v))
    mechanism, turning, moving, energy = mechanism_of(problem), [], [], 0.0
    for i, body in enumerate(mechanism.bodies):
        rotation, place = mechanism.rotations[i], mechanism.places[i]
        omega, speed = np.zeros(3), np.zeros(3)
        if body.parent >= 0:
            omega = turning[body.parent]
            arm = place - mechanism.places[body.parent]
            speed = moving[body.parent] + np.cross(omega, arm)
        for n, (slides, axis) in enumerate(zip(body.slides, body.axes, strict=True)):
            rate = v[body.first + n] * (rotation @ axis)
            omega, speed = (omega, speed + rate) if slides else (omega + rate, speed)
        turning.append(omega)
        moving.append(speed)
        of_centre = speed + np.cross(omega, rotation @ body.centre)
        inertia = rotation @ body.inertia @ rotation.T
        energy += 0.5 * body.mass * of_centre @ of_centre + 0.5 * omega @ inertia @ omega
    whole = pin.computeKineticEnergy(model, model.createData(), problem.q, v)
    assert energy == pytest.approx(whole, rel=1e-13)


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.4, 0.9, 1.0, 1.5, 4.0])
def test_a_damper_gives_its_restitution(ratio):
    from scipy.integrate import solve_ivp

    def force(t, y):
        return y[0] + 2 * ratio * y[1]

    force.terminal, force.direction = True, -1
    run = solve_ivp(
        lambda t, y: [y[1], -force(t, y)], (0, 50), [0, 1], events=force, rtol=1e-12, atol=1e-14
    )
    assert restitution_of(ratio) == pytest.approx(-run.y[1, -1], abs=1e-10)
    assert damping_ratio(restitution_of(ratio)) == pytest.approx(ratio, abs=1e-12)


@pytest.mark.parametrize("problem", some(*BLOWS), ids=lambda p: p.name)
@pytest.mark.parametrize("way", ["mass matrix", "forward", "batch"])
def test_mujoco_gives_the_jump_of_a_known_blow(way, problem):
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import mujoco

    assert errors(of(mujoco.METHODS, f"mujoco, {way}"), problem) < problem.tolerance


def test_a_step_of_mujoco_is_off_by_its_length():
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import mujoco

    long, short = errors(of(mujoco.METHODS, "mujoco, one step"), some("struck robot")[0])
    assert long / short == pytest.approx(1000, rel=0.1)


def test_mujocos_soft_contacts_come_nearer_with_their_steps():
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import mujoco

    found = errors(of(mujoco.METHODS, "mujoco, soft contacts"), smooth_rod())
    assert (found[:-1] / found[1:] > 5).all()
    assert found[-1] < 2e-3


def test_mujocos_soft_contacts_stick_but_lift_what_slides():
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import mujoco

    soft = of(mujoco.METHODS, "mujoco, soft contacts")
    assert errors(soft, some("rocking block")[0])[-1] < 1e-5
    sliding = next(p for p in some("foot") if p.family == "foot that slides")
    assert errors(soft, sliding)[-1] > 1e-2


@pytest.mark.parametrize("problem", some(*BLOWS), ids=lambda p: p.name)
def test_exudyn_gives_the_jump_of_a_known_blow(problem):
    pytest.importorskip("exudyn", reason='Exudyn is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import exudyn

    assert errors(of(exudyn.METHODS, "exudyn, mass matrix"), problem) < problem.tolerance
    assert errors(of(exudyn.METHODS, "exudyn, one step"), problem) < 1e-5


@pytest.mark.parametrize("problem", some("held robot", "closed chain"), ids=lambda p: p.name)
def test_mujocos_soft_holds_are_off_by_how_long_they_take(problem):
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import mujoco

    assert errors(of(mujoco.METHODS, "mujoco, soft contacts")[:1], problem) < 1e-5


@pytest.mark.parametrize("family", ["swing", "flight"])
def test_mujocos_motions_are_of_the_order_of_its_integrators(family):
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import mujoco

    problem = some(family)[-1]
    euler = errors(of(mujoco.METHODS, "mujoco, Euler"), problem)
    assert euler[0] / euler[1] == pytest.approx(10, rel=0.2)
    coarse, fine = errors(of(mujoco.METHODS, "mujoco, RK4")[:2], problem)
    assert coarse / fine > 100
    assert fine < problem.tolerance


def test_mujocos_soft_contact_leaves_an_error_at_any_step():
    pytest.importorskip("mujoco", reason='MuJoCo is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import mujoco, own

    problem = some("sliding block")[-1]
    theirs = errors(of(mujoco.METHODS, "mujoco, contact, Euler")[:3], problem)
    assert 1e-6 < min(theirs) < max(theirs) < 1e-2
    assert max(errors(of(own.METHODS, "impulsekit, simulate dop853"), problem)) < 1e-12


def test_exudyns_motions_are_of_the_order_of_its_solvers():
    pytest.importorskip("exudyn", reason='Exudyn is a peer: pip install "impulsekit[peers]"')
    from benchmarks.methods import exudyn

    problem = some("swing")[-1]
    implicit = errors(of(exudyn.METHODS, "exudyn, generalized alpha"), problem)
    assert implicit[0] / implicit[1] == pytest.approx(100, rel=0.2)
    coarse, fine = errors(of(exudyn.METHODS, "exudyn, RK44")[:2], problem)
    assert coarse / fine == pytest.approx(256, rel=0.2)
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
    pytest.importorskip("exudyn", reason='Exudyn is a peer: pip install "impulsekit[peers]"')
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


def test_an_interpreter_without_crocoddyl_is_an_error(monkeypatch, capfd):
    (method,) = crocoddyl.METHODS
    monkeypatch.setenv(crocoddyl.VARIABLE, sys.executable)
    with pytest.raises(ImpulsekitError, match="has ended"):
        method.prepare(some("held robot")[0])
    assert "crocoddyl" in capfd.readouterr().err


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


def test_crocoddyl_does_not_take_blows_alone_nor_bounces():
    (method,) = crocoddyl.METHODS
    assert not any(method.suits(p) for p in some(*BLOWS, "foot", "cradle"))


def test_a_method_says_which_package_it_lacks():
    method = Method("x", lambda problem: True, lambda problem: list, needs=("no-such-package",))
    assert "no-such-package" in method.missing()
    assert "peers" in method.missing()


def test_what_times_itself_is_not_timed_from_here():
    class Elsewhere:
        def __call__(self):
            return 1

        def seconds(self, repeats):
            return 0.25

    assert time_in_turn({"there": Elsewhere()}, rounds=3)["there"].rounds == (0.25, 0.25, 0.25)
