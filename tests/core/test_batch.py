"""Batches in the core: the same bits by every instruction set, and what happens in threads."""

import os
import signal
import threading

import numpy as np
import pytest

import impulsekit as ik
from impulsekit._core import Contact, instruction_sets, use_instruction_set
from impulsekit.batch.program import program_of

from ..batch.compare import random_states

FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


@pytest.mark.parametrize("struck", [False, True])
def test_every_instruction_set_gives_the_same_bits(solo, struck):
    blow = ik.AppliedImpulse("base_link", linear=[1, 2, 3], at=[0.1, 0, 0])
    feet = [] if struck else [ik.Contact(f, restitution=0.3, friction=0.5) for f in FEET]
    scene = ik.Scene(solo, [blow], contacts=feet)
    q, v = random_states(solo, 203)
    found = []
    for name in instruction_sets():
        use_instruction_set(name)
        found += [ik.solve_batch(scene, q, v, threads=threads).v_after for threads in (1, 3)]
    assert all(np.array_equal(found[0], other) for other in found[1:])


@pytest.mark.parametrize("threads", [1, 3])
def test_a_function_that_fails_ends_the_batch_and_nothing_else(solo, threads):
    calls = []

    def failing(speed):
        calls.append(speed)
        if len(calls) > 20:
            raise ValueError("worn out")
        return 0.5

    scene = ik.Scene(solo, contacts=[ik.Contact("FL_FOOT", restitution=failing)])
    q, v = random_states(solo, 500)
    with pytest.raises(ik.errors.CallbackError, match="worn out"):
        ik.solve_batch(scene, q, v, threads=threads)
    assert len(calls) < 500
    plain = ik.Scene(solo, contacts=[ik.Contact("FL_FOOT", restitution=0.5)])
    assert ik.solve_batch(plain, q, v, threads=threads).valid.all()


def test_ctrl_c_ends_a_batch(solo):
    feet = [ik.Contact(f, restitution=0.3, friction=0.5) for f in FEET]
    q, v = random_states(solo, 500)
    scene, many = ik.Scene(solo, contacts=feet), (np.tile(q, (1000, 1)), np.tile(v, (1000, 1)))
    over = threading.Event()

    def press_until_over():
        while not over.wait(0.02):
            os.kill(os.getpid(), signal.SIGINT)

    def pressed(signum, frame):
        over.set()
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, pressed)  # a job in the background ignores it
    presses = threading.Thread(target=press_until_over)
    try:
        with pytest.raises(KeyboardInterrupt):
            presses.start()
            for _ in range(100):
                ik.solve_batch(scene, *many)
    finally:
        over.set()
        presses.join()
        signal.signal(signal.SIGINT, before)
    assert ik.solve_batch(scene, q, v).valid.all()


def test_a_scene_is_not_changed_while_a_batch_reads_it(solo):
    flats = []

    def of_speed(speed):
        for change in (lambda: flats[0].add_contact(Contact()), lambda: flats[0].add_kick(6)):
            with pytest.raises(ValueError, match="batch that runs now"):
                change()
        return 0.5

    scene = ik.Scene(solo, contacts=[ik.Contact("FL_FOOT", restitution=of_speed)])
    flats.append(program_of(scene).flat.core)
    q, v = random_states(solo, 5)
    assert ik.solve_batch(scene, q, v).valid.all()
