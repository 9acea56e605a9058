"""Errors and warnings reach another process as they were."""

import copy
import pickle

import pytest

from impulsekit import errors

WARNINGS = [
    errors.SetupWarning([f"joint {k} is outside its limits" for k in range(6)]),
    errors.SetupWarning(("nothing strikes",)),
    errors.AssumptionWarning("arm.urdf", ["the inertia of the hand is 0", "no limits"]),
]


@pytest.mark.parametrize("warning", WARNINGS, ids=str)
@pytest.mark.parametrize(
    "again",
    [
        lambda w: pickle.loads(pickle.dumps(w)),
        copy.copy,
        # What a pool of test processes does.
        lambda w: type(w)(*w.args),
    ],
    ids=["pickle", "copy", "args"],
)
def test_a_warning_keeps_its_sentences(warning, again):
    twin = again(warning)
    assert str(twin) == str(warning) and vars(twin) == vars(warning)


def test_a_warning_names_the_first_and_counts_the_rest():
    sentences = [f"{name} is past its limit" for name in "abcdef"]
    assert str(errors.SetupWarning(sentences)) == "; ".join(
        [*sentences[:4], "and 2 more, see Impact.doubts"]
    )


def test_an_error_keeps_its_facts():
    error = errors.RangeError.of("friction", -1.0, "0 or more")
    twin = pickle.loads(pickle.dumps(error))
    assert str(twin) == str(error) == "friction must be 0 or more, got -1.0"
    assert (twin.what, twin.value, twin.allowed) == ("friction", -1.0, "0 or more")


def test_an_unknown_name_lists_what_could_be_meant():
    among = errors.UnknownNameError.among
    choices = ("fixed", "planar", "freeflyer")
    assert str(among("root", "ceiling", choices)) == (
        'unknown root "ceiling"; choose "fixed", "planar" or "freeflyer"'
    )
    assert str(among("root", "fixd", choices)) == 'unknown root "fixd"; did you mean "fixed"?'
    assert str(among("contact", "floor", ())) == 'unknown contact "floor"; there are none'
    assert str(among("joint", "zzz", [f"joint_{k}" for k in range(20)])) == (
        'unknown joint "zzz"; none of the 20 known names is similar'
    )
