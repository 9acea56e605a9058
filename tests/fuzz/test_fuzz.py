"""Broken files: loaded or refused by us, whatever is in them; and the fuzzer sees crashes."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.fuzz import target
from benchmarks.fuzz.grammar import random_scene
from benchmarks.fuzz.target import KINDS, SECRET, Fault, prepare, try_file

QUIET = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@pytest.fixture
def folder(tmp_path):
    prepare(tmp_path)
    return tmp_path


@QUIET
@given(st.randoms(use_true_random=False))
def test_any_scene(folder, rng):
    text = random_scene(rng).encode("utf-8", "surrogatepass")
    try_file(folder, "scene", text, 1)


@QUIET
@given(st.binary(max_size=300))
def test_any_bytes(folder, data):
    for kind in KINDS[:2]:
        try_file(folder, kind, data, 1)
        try_file(folder, kind, b"<robot>" + data, 1)


def test_words_that_give_away_too_much_are_faults():
    for words in (SECRET, "a\x1b[31m", "at 0x7f Traceback (most recent", "x" * 10**5, ""):
        with pytest.raises(Fault):
            target._examine_words(words)
    target._examine_words("robot.urdf: no such file")
