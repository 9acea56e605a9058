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
    with pytest.raises(errors.CallbackError, match=r"motor: .*ValueError.*read-only"):
        ik.simulate(scene, chain.neutral(), chain.velocity())


@pytest.mark.parametrize("given", [True, "2", b"2", np.True_, None, 1j, [1.0]])
def test_text_and_truth_values_are_no_numbers(given):
    with pytest.raises(errors.NotFiniteError, match="must be a number"):
        ik.Contact("ball", friction=given)
