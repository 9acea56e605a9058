"""Broken files: loaded or refused by us, whatever is in them; and the fuzzer sees crashes."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.fuzz import pool, target
from benchmarks.fuzz.grammar import random_scene
from benchmarks.fuzz.target import KINDS, SECRET, Fault, file_of, prepare, try_file

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


def test_a_file_is_its_number_and_the_seed():
    for number in range(8):
        assert file_of(3, number) == file_of(3, number)
        assert file_of(3, number)[0] == KINDS[number % 4]
    assert file_of(3, 0) != file_of(4, 0)


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 70_000])
def test_two_hundred_files(folder, first):
    outcomes = {try_file(folder, *file_of(7, n), n) for n in range(first, first + 100)}
    # Some are struck, and some are refused, on both ways.
    assert {"SOLVED", "UrdfError", "SceneFileError"} <= outcomes


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
    target._examine_words("robot.urdf: there is no such file")


def _dies(folder, kind, content, number):
    if number == 5:
        os.abort()
    if number == 7:
        raise ZeroDivisionError("seven")
    if number == 9:
        while True:
            pass
    return "fine"


@pytest.mark.slow
def test_a_crash_and_a_hang_are_laid_at_the_files_door(monkeypatch):
    monkeypatch.setattr(pool, "try_file", _dies)
    # Processes by fork have the patched function; those of the fuzzer begin afresh.
    monkeypatch.setattr(pool.multiprocessing, "get_context", lambda _: _Forking())
    monkeypatch.setattr(pool, "SECONDS_A_FILE", 0.5)
    monkeypatch.setattr(pool, "CHUNK", 4)
    tally = pool.fuzz(14, jobs=2)
    assert tally.files == 14
    assert [finding.number for finding in tally.findings] == [5, 7, 9]
    crash, error, hang = tally.findings
    assert "SIGABRT" in crash.words
    assert "_dies" in crash.words
    assert "ZeroDivisionError: seven" in error.words
    assert "Timeout" in hang.words


class _Forking:
    """The parts of a context that the pool uses, by fork."""

    def __getattr__(self, name):
        import multiprocessing.context

        return getattr(multiprocessing.context.ForkContext(), name)
