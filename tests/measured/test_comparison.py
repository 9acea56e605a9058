"""Laws held against measured impacts whose law is known; signs of axes; many impacts at once."""

import json
from dataclasses import replace

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, RangeError
from impulsekit.measured import (
    LawCandidate,
    Measurement,
    compare_laws,
    fit_impacts,
)
from tests.measured.bodies import ball_scene

NAMES = {"restitution": ["tip"], "friction": ["tip"]}


def rod_impacts(law, e, mu, count, sigma, seed=0):
    """Impacts of a planar body at points beside its mass centre, solved one by one, with noise."""
    rng = np.random.default_rng(seed)
    body = ik.Robot.from_urdf("models/ball.urdf", root="planar")
    tip = ik.Contact("ball", normal=[0, 1, 0], restitution=0.4, friction=0.3, name="tip")
    scene = ik.Scene(body, contacts=[tip])
    found = []
    for _ in range(count):
        at = [*rng.uniform([-0.05, -0.06], [0.05, -0.03]), 0.0]
        v = np.array([rng.normal(), -rng.uniform(1, 3), rng.normal(scale=10)])
        speed = -(v[1] + v[2] * at[0])
        if speed < 0.3:
            continue
        own = e(speed) if callable(e) else e
        true = replace(tip, at=at, restitution=own, friction=mu)
        impact = ik.solve(replace(scene, contacts=[true], law=law), body.neutral(), v)
        after = impact.v_after + sigma * rng.normal(size=3) * [1, 1, 20]
        found.append(
            Measurement(scene, body.neutral(), v, after, sigma=[sigma, sigma, 20 * sigma],
                        points={"tip": at})
        )  # fmt: skip
    return found


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_true_law_predicts_best_and_the_probability_says_so():
    seen = rod_impacts(ik.Law("poisson", "path"), 0.6, 0.3, 120, 0.005)
    laws = [
        LawCandidate("Newton, slip at the end", ik.Law()),
        LawCandidate("Poisson, along the path", ik.Law("poisson", "path")),
    ]
    found = compare_laws(seen, laws, **NAMES, folds=2)
    assert "along the path" in found.names[0] and found.names[0].startswith(("Poi", "Str"))
    end = found.names.index("Newton, slip at the end")
    assert found.better[0, end] > 0.99 and found.better[end, 0] < 0.01
    assert found.better == pytest.approx(1.0 - found.better.T)
    assert np.median(found.errors[0]) < 0.5 * np.median(found.errors[end])
    data = found.to_dict()
    json.dumps(data, allow_nan=False)
    assert data["laws"][0]["name"] == found.names[0] and not found.errors.flags.writeable
    assert "better than the best" in found.report() and "<table" in found._repr_html_()
    assert "impacts" in repr(found)


def test_laws_that_do_not_differ_are_not_told_apart():
    seen = rod_impacts(ik.Law(), 0.5, 0.0, 14, 0.02)
    free = replace(seen[0].scene, contacts=[replace(seen[0].scene.contacts[0], friction=0.0)])
    seen = [replace(m, scene=free) for m in seen]
    laws = [LawCandidate("Newton"), LawCandidate("Poisson", ik.Law("poisson"))]
    found = compare_laws(seen, laws, restitution=["tip"], robust="none", folds=3)
    assert found.errors[0] == pytest.approx(found.errors[1], abs=1e-9)
    assert any("not significantly worse" in note for note in found.notes)


def test_coefficients_by_what_is_known_before_an_impact():
    scene = ball_scene(0.4, 0.3)
    q = scene.robot.neutral()
    # A ball that slides along the floor all through: u_x falls by µ (1 + e) times its fall.
    seen = [
        Measurement(scene, q, [9.0, 0, -w, 0, 0, 0], slid(scene, 9.0, w, e, mu), 1e-3)
        for w, e, mu in ((1.0, 0.6, 0.1), (1.2, 0.6, 0.1), (1.4, 0.6, 0.1),
                         (2.0, 0.3, 0.2), (2.2, 0.3, 0.2), (2.4, 0.3, 0.2))
    ]  # fmt: skip
    by_speed = LawCandidate(
        "by speed", by_group=["restitution", "friction"],
        group_of=lambda m: "slow" if m.v_before[2] > -1.5 else "fast",
    )  # fmt: skip
    laws = [LawCandidate("one e"), by_speed]
    found = compare_laws(seen, laws, restitution=["floor"], friction=["floor"], robust="none",
                         folds=2)  # fmt: skip
    assert found.names[0] == "by speed" and found.errors[0].max() < 1e-6
    fit = found.fits[0]
    assert fit.names == ("floor: restitution, fast", "floor: restitution, slow",
                         "floor: friction, fast", "floor: friction, slow")  # fmt: skip
    assert fit.values == pytest.approx([0.3, 0.6, 0.2, 0.1], abs=1e-6)
    with pytest.raises(InputError, match="by_group must be"):
        fit_impacts(seen, restitution=["floor"], by_group="mass")


def slid(scene, slip, fall, e, mu):
    """v⁺ of the ball, which lies with its centre over the contact, radius r."""
    inertia = scene.robot.model.inertias[1]
    blow = (1 + e) * inertia.mass * fall
    radius = -scene.contacts[0].at[2]
    spin = mu * blow * radius / inertia.inertia[1, 1]
    return np.array([slip - mu * blow / inertia.mass, 0, e * fall, 0, spin, 0])


def test_what_is_given_wrongly_is_said():
    seen = rod_impacts(ik.Law(), 0.5, 0.1, 12, 0.01)
    with pytest.raises(RangeError, match="folds"):
        compare_laws(seen, **NAMES, folds=1)
    with pytest.raises(InputError, match="too few"):
        compare_laws(seen[:3], **NAMES)
    with pytest.raises(InputError, match="one name"):
        compare_laws(seen, [LawCandidate("a"), LawCandidate("a")], **NAMES, folds=2)
    with pytest.raises(InputError, match="name must be text"):
        LawCandidate("")
    with pytest.raises(RangeError, match="speeds"):
        LawCandidate("a", speeds=(2.0, 1.0))
    found = compare_laws(
        seen,
        [LawCandidate("a"), LawCandidate("locked", locked=("knee",))],
        restitution=["tip"],
        robust="none",
        folds=2,
    )
    assert found.names == ("a",) and "knee" in found.left_out[0][1]


@pytest.mark.slow
def test_e_by_speed_is_found_and_told():
    def e(speed):
        return np.interp(speed, [1.0, 3.0], [0.8, 0.5])

    seen = rod_impacts(ik.Law(), e, 0.1, 40, 1e-3)
    laws = [LawCandidate("one e"), LawCandidate("e by speed", speeds=(1.0, 3.0))]
    found = compare_laws(seen, laws, **NAMES, robust="none", folds=4)
    assert found.names[0] == "e by speed" and found.better[0, 1] > 0.99
    fit = found.fits[0]
    assert fit.names[:2] == ("tip: restitution at 1 m/s", "tip: restitution at 3 m/s")
    assert fit.values == pytest.approx([0.8, 0.5, 0.1], abs=5e-3)
