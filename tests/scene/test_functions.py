"""Functions that users give with an entry: what is wrong with them is one error with its name."""

from pathlib import Path

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors

BALL = Path(__file__).parents[2] / "models" / "ball.urdf"


@pytest.fixture(scope="module")
def ball():
    return ik.Robot.from_urdf(BALL, root="freeflyer")


def test_a_function_that_writes_is_told():
    chain = ik.Robot.from_example("panda")

    def torque(t, q, v):
        q[0] = 99.0
        return 0.0

    scene = ik.Scene(chain, forces=[ik.Actuator("panda_joint2", torque, name="motor")])
    with pytest.raises(ValueError, match="read-only") as caught:
        ik.simulate(scene, chain.neutral(), chain.velocity())
    assert "motor: torque" in caught.value.__notes__[0]


def test_what_a_function_raises_in_a_motion_comes_out_with_a_note(ball):
    class Blown(Exception):
        """The user's own."""

    blown = Blown("no fuel")
    blown.__cause__ = KeyError("tank")

    def thrust(t):
        if t > 0.4:
            raise blown
        return (0.0, 0.0, 1.0)

    scene = ik.Scene(ball, forces=[ik.AppliedForce("ball", linear=thrust, name="engine")])
    q, v = ball.neutral(), ball.velocity()
    runs = (lambda: ik.simulate(scene, q, v, 1.0), lambda: ik.Simulation(scene, q, v).step(1.0))
    for count, run in enumerate(runs):
        with pytest.raises(Blown) as caught:
            run()
        assert caught.value is blown and type(blown.__cause__) is KeyError
        assert blown.__context__ is None and len(blown.__notes__) == count + 1
        assert "engine: linear at t = 0." in blown.__notes__[count]
        assert "in the step of the motion from t = " in blown.__notes__[count]
    with pytest.raises(errors.CallbackError, match="Blown: no fuel") as caught:
        ik.simulate_batch(scene, [q, q], v, 1.0)
    assert caught.value.__cause__ is blown


@pytest.mark.parametrize("given", [True, "2", b"2", np.True_, None, 1j, [1.0]])
def test_text_and_truth_values_are_no_numbers(given):
    with pytest.raises(errors.InputError, match="must be a number"):
        ik.Contact("ball", friction=given)
