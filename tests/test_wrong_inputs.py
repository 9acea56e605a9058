"""What is most often given wrong, and the sentence that it gives."""

import warnings

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, NotFiniteError, RangeError, ShapeError, UnknownNameError

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
ARM = ik.Robot.from_example("ur5")
FLOOR = ik.Contact("ball", at=[0, 0, -0.05], name="floor")
Q, V = BALL.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1]), BALL.velocity()

WRONG = {
    "a collision with a ground that is not there": (
        lambda: ik.Scene(BALL, contacts=[ik.Collision("ball", "ground")]),
        UnknownNameError,
        'contacts[0]: unknown link or geometry "ground"; robot.with_ground() gives the world one, '
        'called "ground"',
    ),
    "a contact against the ground": (
        lambda: ik.Scene(BALL, contacts=[ik.Contact("ball", against="ground")]),
        UnknownNameError,
        'contacts[0]: unknown frame "ground"; the fixed frame is "world", and a Contact is with '
        "the plane z = 0 of it",
    ),
    "text for a state": (
        lambda: ik.solve(ik.Scene(BALL, contacts=[FLOOR]), "here", V),
        InputError,
        'configuration q must be 7 numbers, got "here"',
    ),
    "a state of another length": (
        lambda: ik.solve(ik.Scene(ARM), [0.0, 0.0, 0.0], ARM.velocity()),
        ShapeError,
        "configuration q: expected shape (6,), got (3,)",
    ),
    "a state for a scene": (
        lambda: ik.Scene(ARM, ARM.neutral(), ARM.velocity()),
        InputError,
        "Scene: impulses must be a list of entries, got numbers; a state goes to "
        "solve(scene, q, v) or simulate(scene, q, v, duration)",
    ),
    "an unknown law": (
        lambda: ik.Law(restitution="newtn"),
        RangeError,
        'law: restitution must be "newton" or "poisson" or "stronge" or "lzb", got "newtn"',
    ),
    "a motion that starts inside the floor": (
        lambda: ik.simulate(ik.Scene(BALL, contacts=[FLOOR]), BALL.neutral(), V, 1.0),
        InputError,
        "floor starts 0.05 m in penetration; raise the robot or move the plane",
    ),
    "a negative duration": (
        lambda: ik.simulate(ik.Scene(BALL, contacts=[FLOOR]), Q, V, -1.0),
        RangeError,
        "motion: duration must be 0 to 1e9 s, got -1.0",
    ),
    "a root that is none": (
        lambda: ik.Robot.from_urdf("models/ball.urdf", root="floating"),
        UnknownNameError,
        'unknown root "floating"; choose "fixed", "planar", "sagittal" or "freeflyer"',
    ),
}  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_input_gives_the_sentence(wrong):
    call, kind, sentence = WRONG[wrong]
    with pytest.raises(kind) as caught:
        call()
    assert str(caught.value) == sentence
    assert not (kind is InputError and isinstance(caught.value, NotFiniteError))


def test_a_motion_without_a_duration_says_how_long_it_is():
    with pytest.warns(ik.errors.SetupWarning, match="the motion ends after 1 s") as caught:
        motion = ik.simulate(ik.Scene(BALL, contacts=[FLOOR]), Q, V)
    assert caught[0].filename == __file__ and motion.t[-1] == 1.0


def test_a_quaternion_in_the_order_of_others_is_doubted():
    given = [0, 0, 1, 1, 0, 0, 0]
    with pytest.warns(ik.errors.SetupWarning, match="order x, y, z, w half a turn about x"):
        q = BALL.configuration(root_joint=given)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        impact = ik.solve(ik.Scene(BALL, contacts=[FLOOR]), np.array(given), V)
    assert np.array_equal(q, given) and any("half a turn" in doubt for doubt in impact.doubts)
    assert not any("turn" in d for d in ik.solve(ik.Scene(BALL, contacts=[FLOOR]), Q, V).doubts)
