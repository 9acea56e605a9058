"""Calls with wrong arguments: one error of ours, with the nearest name, whatever is called."""

import enum
import importlib
import inspect
import pickle
import threading
import types
import warnings

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors
from impulsekit.errors.calls import public

MODULES = ["impulsekit", *(f"impulsekit.{room}" for room in ik._ROOMS)]


def public_things():
    """Every function and class that a module of the package offers, and their methods."""
    found = {}
    for name in MODULES:
        module = importlib.import_module(name)
        for each in (getattr(module, n) for n in getattr(module, "__all__", dir(module))):
            ours = getattr(each, "__module__", "").startswith("impulsekit")
            if not ours or inspect.ismodule(each):
                continue
            if inspect.isfunction(each):
                found[f"{each.__module__}.{each.__qualname__}"] = each
            elif inspect.isclass(each) and not issubclass(each, (enum.Enum, BaseException)):
                for kind in each.__mro__:
                    if kind.__module__.startswith("impulsekit"):
                        found |= methods_of(kind)
    return found


def methods_of(kind):
    found = {}
    for name, member in vars(kind).items():
        function = getattr(member, "__func__", member)
        if inspect.isfunction(function) and (name == "__init__" or not name.startswith("_")):
            found[f"{kind.__module__}.{kind.__qualname__}.{name}"] = function
    return found


@pytest.mark.parametrize("name", sorted(things := public_things()))
def test_no_public_callable_answers_a_wrong_argument_by_a_bare_error(name):
    function = things[name]
    parameters = inspect.signature(function).parameters.values()
    if any(p.kind is p.VAR_KEYWORD for p in parameters):
        # What it takes is checked by what it hands it to.
        assert inspect.unwrap(function) is not function
        return
    with pytest.raises(errors.UnknownNameError, match='unknown argument "no_such_argument"'):
        # What a method does first with its object, here a lock, comes before its arguments.
        own = [types.SimpleNamespace(_in_use=threading.Lock())]
        function(*own * ("self" in inspect.signature(function).parameters), no_such_argument=1)


def test_what_is_raised_within_passes_unchanged():
    @public
    def fails(x):
        return x + "text"

    with pytest.raises(TypeError, match="unsupported operand") as caught:
        fails(1)
    assert not isinstance(caught.value, errors.ImpulsekitError)
    with pytest.raises(errors.InputError, match=r'fails: argument "x" is missing; it takes x'):
        fails()
    with pytest.raises(errors.InputError, match="too many arguments; it takes x"):
        fails(1, 2)


def test_a_setting_of_the_scene_is_named_as_such():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", name="floor")])
    with pytest.raises(errors.UnknownNameError, match=r"scene\.replace\(law=\.\.\.\)"):
        ik.solve(scene, ball.neutral(), ball.velocity(), law=ik.Law())
    with pytest.raises(errors.UnknownNameError, match='did you mean "friction"'):
        ik.Contact("ball", mu=0.5)


def test_functions_and_classes_are_still_themselves():
    assert pickle.loads(pickle.dumps(ik.solve)) is ik.solve
    entry = ik.Contact("ball", friction=0.3)
    assert pickle.loads(pickle.dumps(entry)) == entry
    assert list(inspect.signature(ik.solve).parameters) == ["scene", "q", "v", "impulses"]
    assert ik.solve.__doc__.startswith("Solve the impact")


def test_a_warning_points_at_the_users_line():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball")])
    wxyz = np.array([0, 0, 0, 1.0, 0, 0, 0])
    for call in (ik.solve, ik.simulate, ik.solve_batch):
        with pytest.warns(errors.SetupWarning, match="half a turn") as caught:
            call(scene, wxyz, ball.velocity(root_joint=[0, 0, -1, 0, 0, 0]))
        assert {one.filename for one in caught} == {__file__}
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            # Of a scene once.
            call(
                scene, wxyz, ball.velocity(root_joint=[0, 0, -1, 0, 0, 0]), **SETTINGS.get(call, {})
            )


SETTINGS = {ik.simulate: {"duration": 0.1}}


def test_entries_are_found_by_name():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    contacts = [ik.Contact("ball", name="floor"), ik.Contact("ball", normal=[1, 0, 0])]
    scene = ik.Scene(ball, contacts=contacts)
    assert scene.contacts["floor"] is scene.contacts[0]
    assert scene.contacts["contacts[1]"] is scene.contacts[1]
    with pytest.raises(errors.UnknownNameError, match='did you mean "floor"'):
        _ = scene.contacts["flor"]
    again = pickle.loads(pickle.dumps(scene))
    assert again.contacts.names == scene.contacts.names == ("floor", "contacts[1]")
    assert scene.replace(contacts=contacts[:1]).contacts.names == ("floor",)
