"""Contact points that vary by row, against a scene of its own for each row."""

import warnings
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, RangeError, ShapeError, UnknownNameError
from impulsekit.laws.status import Status

OUTPUTS = ("v_after", "contact_impulses", "energy_change")


def planar_scene(law):
    """A ball in the plane whose point may be anywhere."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="planar")
    tip = ik.Contact("ball", normal=[0, 1, 0], restitution=0.5, friction=0.3, name="tip")
    return ik.Scene(ball, contacts=[tip], law=law)


def arm_scene(against):
    arm = ik.Robot.from_example("panda")
    contacts = [
        ik.Contact("panda_hand", against=against, restitution=0.5, friction=0.3, name="hand"),
        ik.Contact("panda_link4", at=[0.1, 0, 0], normal=[1, 0, 1], restitution=0.2, friction=0.1,
                   name="elbow"),
    ]  # fmt: skip
    return ik.Scene(arm, contacts=contacts[: 1 if against != "world" else 2])


def row_scene(scene, points, row):
    """The scene with the points of a row, made by hand."""
    contacts = [
        replace(entry, at=points[name][row]) if name in points else entry
        for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True)
    ]
    return replace(scene, contacts=contacts)


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        (planar_scene(ik.Law()), ["tip"]),
        (planar_scene(ik.Law("stronge", "path")), ["tip"]),
        (arm_scene("world"), ["elbow"]),
        (arm_scene("world"), ["hand", "elbow"]),
        (arm_scene("panda_link2"), ["hand"]),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_each_row_is_as_a_scene_with_its_point(scene, names):
    rng, size = np.random.default_rng(0), 12
    robot = scene.robot
    start = robot.neutral()
    q = np.array(
        [pin.integrate(robot.model, start, rng.normal(size=robot.nv)) for _ in range(size)]
    )
    v = rng.normal(size=(size, robot.nv))
    points = {name: rng.uniform(-0.1, 0.1, (size, 3)) for name in names}
    batch = ik.solve_batch(scene, q, v, points=points, outputs=OUTPUTS)
    for row in range(size):
        one = ik.solve(row_scene(scene, points, row), q[row], v[row])
        scale = max(1.0, float(np.abs(one.v_after).max()))
        assert batch.v_after[row] == pytest.approx(one.v_after, abs=1e-12 * scale)
        for own, entry in zip(batch.contact_impulses[row], one.contacts, strict=True):
            assert own == pytest.approx(entry.impulse, abs=1e-12 * scale)
        assert batch.energy_change[row] == pytest.approx(one.energy.change, abs=1e-11 * scale**2)


def test_a_rod_struck_at_its_end_and_at_its_middle():
    # e = 1 at r from the mass centre: P = 2 m u / (1 + r²/k²), k² = I/m.
    scene = planar_scene(ik.Law())
    free = replace(scene, contacts=[replace(scene.contacts[0], restitution=1.0, friction=0.0)])
    inertia = scene.robot.model.inertias[1]
    square = inertia.inertia[2, 2] / inertia.mass
    at = np.array([[0.0, 0, 0], [0.03, 0, 0], [-0.05, 0, 0]])
    batch = ik.solve_batch(
        free, scene.robot.neutral(), [0, -1.0, 0], points={"tip": at}, outputs=OUTPUTS
    )
    found = batch.contact_impulses[:, 0, 1]
    assert found == pytest.approx(2 * inertia.mass / (1 + at[:, 0] ** 2 / square), rel=1e-13)


def test_loads_use_the_points_too():
    scene, rng = arm_scene("world"), np.random.default_rng(1)
    q, v = scene.robot.neutral(), rng.normal(size=(3, scene.robot.nv))
    points = {"hand": rng.uniform(-0.1, 0.1, (3, 3))}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        batch = ik.solve_batch(scene, q, v, points=points, outputs=("reactions",))
        one = ik.solve(row_scene(scene, points, 2), q, v[2])
    first = scene.robot.joint_names[0]
    assert batch.reactions[2, 0] == pytest.approx(one.reactions[first], abs=1e-10)


def test_what_is_given_wrongly_is_said():
    scene = planar_scene(ik.Law())
    q, v = scene.robot.neutral(), np.tile([0, -1.0, 0], (2, 1))
    with pytest.raises(UnknownNameError, match="foot"):
        ik.solve_batch(scene, q, v, points={"foot": [0, 0, 0]})
    with pytest.raises(ShapeError, match="tip"):
        ik.solve_batch(scene, q, v, points={"tip": [0, 0]})
    with pytest.raises(ShapeError, match="leading axes"):
        ik.solve_batch(scene, q, v, points={"tip": np.zeros((3, 3))})
    with pytest.raises(InputError, match="mapping"):
        ik.solve_batch(scene, q, v, points=[0, 0, 0])
    with pytest.raises(RangeError, match="points"):
        ik.solve_batch(scene, q, v, points={"tip": [np.nan, 0, 0]})
    batch = ik.solve_batch(scene, q, v, points={"tip": [[0.0, 0, 0], [np.nan, 0, 0]]})
    assert batch.status.tolist() == [Status.SOLVED, Status.NOT_FINITE]
    assert np.isfinite(batch.v_after[0]).all() and np.isnan(batch.v_after[1]).all()
