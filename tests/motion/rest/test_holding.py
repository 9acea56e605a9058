"""Motions of what sticks up to a force: pads, magnets, suction cups; against closed forms."""

import numpy as np
import pytest

import impulsekit as ik

from ...robots import one_body

G = 9.81
BLOCK = one_body("block", 2, 0.02)


def pad(at=(0, 0, 0), normal=(0, 0, -1), **more):
    return ik.Contact("block", at=at, normal=normal, **({"name": "pad", "friction": 0.5} | more))


def moved(contacts, duration, v=None, q=(0, 0, 0, 0, 0, 0, 1), **more):
    scene = ik.Scene(BLOCK, contacts=contacts, **more)
    start = BLOCK.velocity() if v is None else BLOCK.velocity(root_joint=v)
    return ik.simulate(scene, BLOCK.configuration(root_joint=q), start, duration)


@pytest.mark.slow
def test_it_hangs_until_the_pull_is_more_than_the_pad_bears():
    """A pull of 5 t: let go where m g + 5 t is the pad's 30 N."""
    pull = ik.AppliedForce("block", linear=lambda t: [0, 0, -5 * t])
    motion = moved([pad(adhesion=1.0, holding_force=30.0)], 3.0, forces=[pull])
    end = (30 - 2 * G) / 5
    assert motion.status.name == "FINISHED"
    (rest,) = motion.rests
    assert rest.end == pytest.approx(end, abs=1e-8)
    assert not motion.impacts
    assert motion.v[-1][2] == pytest.approx(-G * (3 - end) - 1.25 * (9 - end**2), abs=5e-8)
    assert motion.contacts["pad"].force(1.0) == pytest.approx([0, 0, 2 * G + 5], abs=1e-10)
    assert np.abs(motion.balance(0.0, 3.0).residual).max() < 1e-8


@pytest.mark.parametrize(("force", "stays"), [(20.0, True), (19.0, False)])
def test_thrown_to_the_ceiling_it_stays_if_the_pad_bears_its_weight(force, stays):
    motion = moved(
        [pad(adhesion=1.0, holding_force=force)], 1.0, [0, 0, 2, 0, 0, 0], (0, 0, -0.1, 0, 0, 0, 1)
    )
    up = (2 - np.sqrt(4 - 2 * G * 0.1)) / G
    assert len(motion.impacts) == 1
    assert motion.impacts[0][0] == pytest.approx(up, abs=1e-10)
    assert motion.v[-1][2] == pytest.approx(0 if stays else -G * (1 - up), abs=1e-8)


def test_a_blow_beyond_its_adhesion_takes_it_off():
    """A stop at the end of a fall asks the pad for m v: more than it bears in one of two."""
    for adhesion, stays in ((4.1, True), (3.9, False)):
        pull = ik.AppliedImpulse("block", linear=[0, 0, -4.0])
        motion = moved([pad(adhesion=adhesion, holding_force=25.0)], 0.2, impulses=[pull])
        lost = 0.0 if stays else -(4.0 - adhesion) / 2 - 0.2 * G
        assert motion.v[-1][2] == pytest.approx(lost, abs=1e-9)


@pytest.mark.parametrize("force", [45.0, 35.0])
def test_on_a_wall_friction_has_the_pull_to_rub_with(force):
    wall = pad(normal=(1, 0, 0), holding_force=force)
    motion = moved([wall], 1.0)
    rate = max(G - 0.5 * force / 2, 0.0)
    assert motion.v[-1][2] == pytest.approx(-rate, abs=1e-9)
    held = min(2 * G, 0.5 * force)
    assert motion.contacts["pad"].force(0.5) == pytest.approx([0, 0, held], abs=1e-9)


@pytest.mark.slow
def test_what_is_peeled_off_turns_about_its_other_pad():
    """Two pads under a ceiling, weight between them, pulled at one end until the near one goes.

    Statics: pads at ±a bear (W + F)/2 ± F b/(2a); the near one at F (1 + b/a) = 2 R − W.
    """
    a, b, bears = 0.1, 0.2, 30.0
    pads = [
        pad((x, 0, 0), name=name, holding_force=bears) for x, name in ((a, "near"), (-a, "far"))
    ]
    pull = ik.AppliedForce("block", at=[b, 0, 0], linear=lambda t: [0, 0, -20 * t])
    motion = moved(pads, 0.8, forces=[pull])
    end = (2 * bears - 2 * G) / (20 * (1 + b / a))
    assert min(rest.end for rest in motion.rests) == pytest.approx(end, abs=1e-8)
    assert motion.rests[0].contact == "near"
    near = motion.contacts["near"].force(0.5)[2]
    assert near == pytest.approx((2 * G + 10) / 2 + 10 * b / (2 * a), abs=1e-9)
