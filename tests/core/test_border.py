"""What the core takes from Python: arrays as they are, of the right sizes, or an error."""

import numpy as np
import pytest

from impulsekit import _core


def ball():
    import impulsekit as ik
    from impulsekit.impact.flat.scene import flat_of

    robot = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    flat = flat_of(ik.Scene(robot))
    return robot, flat.core, _core.Links(flat.model.core, [], [], [], [])


INPUTS = (
    "q", "v", "impulses", "restitution", "friction", "masses", "points", "function_rows",
    "function_contacts",
)  # fmt: skip


def solve(**changed):
    robot, scene, links = ball()
    arrays = dict.fromkeys(INPUTS)
    arrays |= {"q": np.tile(robot.neutral(), (3, 1)), "v": np.ones((3, 6))}
    outputs = {"v_after": np.zeros((3, 6))}
    for name, value in changed.items():
        (arrays if name in arrays else outputs)[name] = value
    arrays["codes"], outputs["codes"] = np.zeros((2, 3), dtype=np.int8)
    program = _core.Program(scene, _core.ContactLaw(_core.Law(), []), False, [], links)
    program.solve(arrays, outputs, 1, None)
    return outputs["v_after"]


def test_arrays_of_a_batch_are_taken_as_they_are():
    assert (solve() == 1.0).all()


@pytest.mark.parametrize("name", ["v", "v_after"])
@pytest.mark.parametrize(
    "array", [np.ones((3, 6), dtype=np.float32), np.ones((3, 12))[:, ::2], np.ones((6, 3)).T]
)
def test_what_would_have_to_be_copied_is_refused(name, array):
    with pytest.raises(TypeError, match=f"{name}: must be a C-contiguous array"):
        solve(**{name: array})


def test_a_mass_of_no_degrees_of_freedom_takes_no_vectors():
    empty = np.zeros((0, 0))
    mass = _core.ConstrainedMass(empty, [], empty, [], None)
    assert mass.half(np.zeros((0, 0))).size == 0
    with pytest.raises(ValueError, match="degrees of freedom"):
        mass.half(np.ones((2, 3)))


def test_a_polytope_has_corners():
    with pytest.raises(ValueError, match="corners"):
        _core.polytope_shape(np.zeros((0, 3)), [], 0.0, _core.Place())


def motion_of_a_ball():
    import impulsekit as ik

    robot = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(robot, contacts=[ik.Contact("ball")], gravity=[0, 0, -9.81])
    q = robot.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    return ik.Simulation(scene, q, robot.velocity())


def test_a_motion_takes_numbers_of_gaps_that_it_has():
    held = motion_of_a_ball()
    motion = held._followed.core
    with pytest.raises(ValueError, match="unknown gap"):
        motion.begin(np.zeros(6), [99])


def test_an_impact_is_differentiated_in_its_own_scene():
    import impulsekit as ik

    robot, bare, _ = ball()
    scene = ik.Scene(robot, contacts=[ik.Contact("ball")])
    jump, _, impact = ik.solve(scene, robot.neutral(), -np.eye(6)[2]).solved
    assert _core.Derivation(jump.flat.core, jump.law, impact).unavailable.name == "none"
    law = _core.ContactLaw(_core.Law(), [])
    with pytest.raises(ValueError, match="expected one of this scene"):
        _core.Derivation(bare, law, impact)


def test_each_enumeration_stands_once():
    """Python's words, statuses and sentences are those of the core, name by name."""
    import impulsekit as ik
    from impulsekit.impact.contact_law import REASONS
    from impulsekit.impact.derivatives import DerivativeStatus
    from impulsekit.impact.derivatives.refusals import _EDGES, _UNAVAILABLE
    from impulsekit.scene.law import ORDERS, RESTITUTIONS, SLIPS
    from impulsekit.scene.motion import METHODS

    def names(enumeration):
        return {each.name for each in enumeration}

    assert {each.name.lower(): int(each) for each in ik.Status} == {
        each.name: int(each) for each in _core.Status
    }
    assert names(_core.Restitution) == set(RESTITUTIONS)
    assert names(_core.Slip) == set(SLIPS) and names(_core.Order) == set(ORDERS)
    assert names(_core.Method) == {method.replace("-", "_") for method in METHODS}
    assert {each.upper() for each in names(_core.Existence)} == names(DerivativeStatus)
    ends = {each.upper() for each in names(_core.Ended)} - {"NOT_YET"}
    assert ends == names(ik.MotionStatus) - {"REFUSED"}
    assert set(_EDGES) == set(_core.Edge) and set(REASONS) == set(_core.Verdict)
    assert set(_UNAVAILABLE) == set(_core.Unavailable) - {_core.Unavailable.none}


def test_a_record_takes_fields_that_it_has_and_pickles():
    import pickle

    law = _core.Law(restitution=_core.Restitution.poisson, exponent=2.0)
    again = pickle.loads(pickle.dumps(law))
    assert (again.restitution, again.exponent) == (_core.Restitution.poisson, 2.0)
    assert again.slip == _core.Slip.end
    with pytest.raises(AttributeError):
        _core.Law(bounce=1.0)
    with pytest.raises(ValueError, match="size: expected 3 numbers, got 2"):
        _core.Ball(size=np.zeros(2))
