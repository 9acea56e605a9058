"""``Simulation``: the same motion as ``simulate``, step by step."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np
import pinocchio as pin
import pytest

from impulsekit import Actuator, Contact, JointSpring, Robot, Scene, Simulation, simulate
from impulsekit.errors import InputError, RangeError, ShapeError, SolveError


def ball(spin=2.0, friction=0.3, **settings):
    """A ball thrown from 1 m."""
    robot = Robot.from_urdf("models/ball.urdf", root="freeflyer")
    floor = Contact("ball", normal=[0, 0, 1], restitution=0.7, friction=friction, name="floor")
    q = robot.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    v = robot.velocity(root_joint=[0.3, 0, 0, 0, spin, 0])
    return Simulation(Scene(robot, contacts=[floor]), q, v, **settings, accuracy="high")


def chain():
    """A pendulum of two links, with a torque to be set at each joint."""
    robot = Robot.from_urdf("models/double_pendulum.urdf")
    return Simulation(Scene(robot), robot.configuration(), robot.velocity(), accuracy="high")


def joint_of(sim):
    return next(iter(sim.controls))


@pytest.mark.parametrize("dt", [0.001, 0.0137, 0.4])
def test_steps_add_up_to_simulate(dt):
    sim = ball()
    steps = int(np.ceil(1.2 / dt))
    for _ in range(steps):
        sim.step(dt)
    q, v = ball().q, ball().v
    whole = simulate(sim._followed.scene, q, v, duration=sim.t, accuracy="high")
    np.testing.assert_allclose(sim.q, whole.q[-1], atol=1e-12)
    np.testing.assert_allclose(sim.v, whole.v[-1], atol=1e-12)
    assert [t for t, _ in sim.impacts] == pytest.approx([t for t, _ in whole.impacts], abs=1e-13)


def test_the_way_is_given_as_simulate_gives_it():
    sim = ball().run_until(1.0)
    way = sim.trajectory(samples=11)
    whole = simulate(way.scene, way.q[0], way.v[0], duration=1.0, samples=11, accuracy="high")
    np.testing.assert_allclose(way.t, whole.t, atol=1e-15)
    np.testing.assert_allclose(way.q, whole.q, atol=1e-12)
    assert len(way.impacts) == len(whole.impacts) == len(sim.impacts)


def test_impacts_come_one_by_one():
    sim = ball(spin=0.0, friction=0.0)
    first = sim.next_impact()
    speed = -first.v_before[2]
    assert sim.v[2] == pytest.approx(0.7 * speed, rel=1e-9)
    assert sim.t == pytest.approx(speed / 9.81, rel=1e-9)
    t = sim.t
    second = sim.next_impact()
    assert sim.t - t == pytest.approx(2 * 0.7 * speed / 9.81, rel=1e-9)
    assert second.v_before[2] == pytest.approx(-0.7 * speed, rel=1e-9)
    t = sim.t
    assert sim.next_impact(until=t + 1e-3) is None and sim.t == t + 1e-3


def test_torques_that_are_set_act_from_then_on():
    sim = chain()
    sim.step(0.2)
    free, driven = sim.copy(), sim.copy()
    name = joint_of(sim)
    driven.controls[name] = 3.0
    free.step(1e-4)
    driven.step(1e-4)
    robot = sim._followed.scene.robot
    impact = np.zeros(robot.nv)
    impact[robot.model.joints[robot.joint_id(name)].idx_v] = 3.0 * 1e-4
    expected = np.linalg.solve(mass_matrix(robot, sim.q), impact)
    np.testing.assert_allclose(driven.v - free.v, expected, rtol=1e-2)
    driven.controls[name] = 0.0
    assert driven.step(0.1).controls[name] == 0.0


@pytest.mark.parametrize("friction", [0.6, 0.05])
def test_a_control_loop_is_the_motion_under_the_torques_it_has_set(friction):
    """Solo12 on its feet, which stick or slide: one motion under torques that are steps in time."""
    robot, dt, count = Robot.from_example("solo12", root="freeflyer"), 1e-3, 40
    legs = ("FL", "FR", "HL", "HR")
    feet = [Contact(f"{leg}_FOOT", friction=friction) for leg in legs]
    bend = {f"{leg}_HFE": 0.8 for leg in legs} | {f"{leg}_KFE": -1.6 for leg in legs}
    q = robot.configuration(**bend)
    q[2] -= min(robot.placement(q, foot.frame).position[2] for foot in feet)
    sim = Simulation(Scene(robot, contacts=feet), q, robot.velocity(), accuracy="high")
    torques = np.zeros((count, robot.nv))
    for k in range(count):
        torques[k, 6:] = 6.0 * (q[7:] + 0.1 * np.sin(0.3 * k) - sim.q[7:]) - 0.15 * sim.v[6:]
        sim.control(torques[k]).run_until((k + 1) * dt)
    times = np.arange(count) * dt
    driven = [
        Actuator(
            robot.model.names[j],
            lambda t, _q, _v, i=robot.model.joints[j].idx_v: torques[
                np.searchsorted(times, t, side="right") - 1, i
            ],
        )
        for j in range(2, robot.model.njoints)
    ]
    whole = simulate(
        Scene(robot, contacts=feet, forces=driven),
        q,
        robot.velocity(),
        duration=sim.t,
        stop_times=times[1:],
        accuracy="high",
    )
    np.testing.assert_allclose(sim.q, whole.q[-1], atol=1e-9)
    np.testing.assert_allclose(sim.v, whole.v[-1], atol=1e-9)


def test_torques_that_are_set_twice_at_once_leave_no_trace():
    free, driven = chain(), chain()
    for sim in (free, driven):
        sim.control([0.3, -0.2])
        sim.step(0.01)
    driven.control([4e3, -7e3])
    driven.step(0.0)
    for sim in (free, driven):
        sim.control([0.1, 0.2])
        sim.step(0.01)
    np.testing.assert_array_equal(driven.q, free.q)
    np.testing.assert_array_equal(driven.v, free.v)


def mass_matrix(robot, q):
    return pin.crba(robot.model, robot.model.createData(), q)


def test_copies_go_on_alone_and_are_restored():
    sim = ball().run_until(0.3)
    kept = sim.copy()
    sim.run_until(0.9)
    q, v, hits = sim.q, sim.v, len(sim.impacts)
    assert kept.t == 0.3 and len(kept.impacts) == 0
    sim.restore(kept)
    assert sim.t == 0.3
    sim.run_until(0.9)
    np.testing.assert_array_equal(sim.q, q)
    np.testing.assert_array_equal(sim.v, v)
    assert len(sim.impacts) == hits
    with pytest.raises(InputError, match="another scene"):
        sim.restore(ball())


def test_without_record_the_way_is_forgotten():
    sim, kept = ball(record=False), ball()
    for _ in range(100):
        sim.step(0.01)
        kept.step(0.01)
    np.testing.assert_array_equal(sim.q, kept.q)
    with pytest.raises(InputError, match="record=False"):
        sim.trajectory()


def test_wrong_input_is_told():
    sim = chain()
    name = joint_of(sim)
    with pytest.raises(RangeError, match="time reached"):
        sim.step(0.1).run_until(0.05)
    with pytest.raises(InputError, match="dt"):
        sim.step("soon")
    with pytest.raises(ShapeError, match="controls"):
        sim.controls[name] = [1.0, 2.0]
    with pytest.raises(InputError, match="nothing_such"):
        sim.controls["nothing_such"] = 1.0


def test_a_motion_that_cannot_go_on_says_so_and_where():
    sim = ball(max_steps=1)
    with pytest.raises(SolveError, match="steps"):
        sim.run_until(5.0)
    assert 0 <= sim.t < 5.0


def test_a_second_thread_is_refused_while_one_steps():
    robot = Robot.from_urdf("models/double_pendulum.urdf")
    stepping, seen = Event(), Event()

    def torque(t, q, v):
        if t > 0.0:
            stepping.set()
            assert seen.wait(20.0)
        return 0.0

    joint = next(iter(robot.joint_names))
    sim = Simulation(Scene(robot, forces=[Actuator(joint, torque)]), robot.neutral(), [0.0, 0.0])
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(sim.step, 0.1)
        assert stepping.wait(20.0)
        for call in (lambda: sim.step(0.1), lambda: sim.q, sim.copy, sim.next_impact):
            with pytest.raises(InputError, match="own copy"):
                call()
        seen.set()
        assert first.result() is sim
    assert sim.step(0.1).t == pytest.approx(0.2)


def test_a_ball_stepped_by_several_threads_stays_above_the_floor():
    sim, alone = ball(), ball()

    def step(_):
        try:
            sim.step(0.01)
        except InputError as error:
            assert "another thread" in str(error)
            return 0
        return 1

    with ThreadPoolExecutor(4) as pool:
        made = sum(pool.map(step, range(400)))
    np.testing.assert_allclose(sim.q, alone.run_until(sim.t).q, atol=1e-9)
    assert made > 0 and sim.t == pytest.approx(0.01 * made)


def test_a_simulation_can_be_restored_to_itself():
    sim = ball().run_until(0.3)
    sim.restore(sim)
    assert sim.run_until(0.5).q.tolist() == ball().run_until(0.5).q.tolist()


def test_torques_set_anew_on_a_hard_damper_take_few_evaluations():
    """Of 10⁷ 1/s: what is stiff is known from the step before, and what is fast moves first."""
    ends, robot = [], Robot.from_example("panda")
    scene = Scene(robot, forces=[JointSpring("panda_joint7", 0.0, damping=1e4)])
    for method in ("dop853", "radau"):
        sim = Simulation(scene, robot.neutral(), robot.velocity(), record=False, method=method)
        torques, before = robot.velocity(), 0
        for k in range(20):
            torques[6] = 0.1 * np.sin(0.02 * k)
            sim.control(torques).step(1e-3)
            if k == 9:
                before = sim._followed.core.evaluations
        ends.append((sim.v, sim._followed.core.evaluations - before))
    (v, evaluations), (known, _) = ends
    assert evaluations < 10 * 200
    np.testing.assert_allclose(v, known, atol=1e-12)
