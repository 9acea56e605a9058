"""Functions that users give with an entry: what is wrong with them is one error with its name."""

from pathlib import Path

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors

BALL = Path(__file__).parents[2] / "models" / "ball.urdf"


def fails(*_):
    raise KeyError("wind")


def gives(value):
    return lambda *_: value


BAD_FORCES = [
    (fails, errors.CallbackError, "raised KeyError: 'wind'"),
    (gives("strong"), errors.CallbackError, "gave a str"),
    (gives(["1", "2", "3"]), errors.CallbackError, "expected real numbers"),
    (gives(None), errors.CallbackError, "gave None"),
    (gives([1j, 0, 0]), errors.CallbackError, "complex"),
    (gives(True), errors.CallbackError, "gave a bool"),
    (gives([[1.0], [2.0, 3.0]]), errors.CallbackError, "expected real numbers"),
    (gives([1.0, 2.0]), errors.ShapeError, r"\(2,\)"),
    (gives(np.zeros((3, 1))), errors.ShapeError, r"\(3, 1\)"),
    (gives([0.0, np.nan, 0.0]), errors.NotFiniteError, "nan"),
]


@pytest.fixture(scope="module")
def ball():
    return ik.Robot.from_urdf(BALL, root="freeflyer")


@pytest.mark.parametrize(("function", "error", "words"), BAD_FORCES)
@pytest.mark.parametrize("field", ["linear", "angular"])
def test_a_bad_force_is_one_error_with_its_name(ball, field, function, error, words):
    force = ik.AppliedForce("ball", name="gust", **{field: function})
    scene = ik.Scene(ball, forces=[force])
    with pytest.raises(error, match=f"gust: {field} at t = 0.*{words}") as raised:
        ik.simulate(scene, ball.neutral(), ball.velocity())
    assert raised.value.from_function


@pytest.mark.parametrize(("function", "error", "words"), BAD_FORCES)
def test_a_bad_torque_is_one_error_with_its_name(function, error, words):
    chain = ik.Robot.from_example("panda")
    motor = ik.Actuator("panda_joint2", function, name="motor")
    if error is errors.NotFiniteError:
        # Three numbers for a joint with one degree of freedom.
        error, words = errors.ShapeError, r"expected shape \(1,\), got \(3,\)"
    with pytest.raises(error, match=f"motor: torque at t = 0.*{words}"):
        ik.simulate(ik.Scene(chain, forces=[motor]), chain.neutral(), chain.velocity())


def test_what_a_function_does_to_its_arguments_changes_no_motion():
    chain = ik.Robot.from_example("panda")
    seen = []

    def torque(t, q, v):
        seen.append((q.flags.writeable, v.flags.writeable))
        assert not np.shares_memory(q, kept)
        with pytest.raises(ValueError, match="read-only"):
            q[:] = 99.0
        with pytest.raises(ValueError, match="read-only"):
            v += 1.0
        return 1.0

    start = kept = chain.neutral()
    speed = chain.velocity()
    moved = ik.simulate(
        ik.Scene(chain, forces=[ik.Actuator("panda_joint2", torque)]), start, speed, duration=0.1
    )
    plain = ik.simulate(
        ik.Scene(chain, forces=[ik.Actuator("panda_joint2", 1.0)]), start, speed, duration=0.1
    )
    assert moved.status.finished
    assert set(seen) == {(False, False)}
    np.testing.assert_allclose(moved.q[-1], plain.q[-1], atol=1e-9)


def test_a_function_that_writes_is_told():
    chain = ik.Robot.from_example("panda")

    def torque(t, q, v):
        q[0] = 99.0
        return 0.0

    scene = ik.Scene(chain, forces=[ik.Actuator("panda_joint2", torque, name="motor")])
    with pytest.raises(errors.CallbackError, match=r"motor: .*ValueError.*read-only"):
        ik.simulate(scene, chain.neutral(), chain.velocity())


@pytest.mark.parametrize(
    ("function", "error", "words"),
    [
        (fails, errors.CallbackError, "raised KeyError"),
        (gives("0.5"), errors.CallbackError, "gave a str"),
        (gives(0.5j), errors.CallbackError, "complex"),
        (gives([0.5, 0.5]), errors.ShapeError, r"\(2,\)"),
        (gives(np.nan), errors.NotFiniteError, "nan"),
        (gives(1.5), errors.RangeError, "0 to 1"),
        (gives(-0.1), errors.RangeError, "0 to 1"),
    ],
)
@pytest.mark.parametrize("second", [False, True])
def test_a_bad_restitution_is_one_error_with_its_name(ball, function, error, words, second):
    contacts = [
        ik.Contact(
            "ball", at=[0, 0, -0.05], origin=[0, 0, -0.1], restitution=function, name="floor"
        )
    ]
    if second:
        contacts.append(ik.Contact("ball", at=[0, 0.05, 0], normal=[0, -1, 0], origin=[0, 0.1, 0]))
    scene = ik.Scene(ball, contacts=contacts)
    q, v = ball.neutral(), ball.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    words = f"floor: restitution at .* m/s.*{words}"
    with pytest.raises(error, match=words):
        ik.solve(scene, q, v)
    with pytest.raises(error, match=words):
        ik.solve_batch(scene, q, np.stack([v, v]))
    with pytest.raises(error, match=words):
        ik.simulate(scene, q, v)


@pytest.mark.parametrize("given", [True, "2", b"2", np.True_, None, 1j, [1.0]])
def test_text_and_truth_values_are_no_numbers(given):
    with pytest.raises(errors.NotFiniteError, match="must be a number"):
        ik.Contact("ball", friction=given)
