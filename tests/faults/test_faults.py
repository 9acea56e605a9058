"""Each fault of a user gets one clear error of ours, in the words that the table holds."""

from __future__ import annotations

import collections
import re

import pytest

from tests.faults.__main__ import TABLE
from tests.faults.table import faults_by_room, told_by_room, written

ALL = [fault for faults in faults_by_room().values() for fault in faults]
INTERNALS = (
    "Traceback", " at 0x", "pinocchio::", "pinocchio.", "numpy.", "coal::", "/project/", "errno",
    "Errno", "<class", "object has no attribute", "positional argument", "site-packages", "/tmp",
)  # fmt: skip


@pytest.fixture(scope="module")
def told():
    return told_by_room()


@pytest.fixture(scope="module")
def every(told):
    return [one for room in told.values() for one in room]


def test_there_are_two_hundred_and_more_all_distinct():
    assert len(ALL) >= 200
    assert not [n for n, count in collections.Counter(f.what for f in ALL).items() if count > 1]


@pytest.mark.slow
def test_each_is_an_error_of_ours(every):
    assert not [(one.what, one.kind, one.words) for one in every if not one.is_ours]


def test_more_than_two_hundred_get_words_of_their_own(every):
    assert len({one.words for one in every}) >= 300


def test_each_is_a_short_sentence_without_what_lies_beneath(every):
    for one in every:
        lines = one.words.splitlines()
        # Only a scene file with several faults has a line for each.
        assert len(lines) == 1 or re.search(r": \d+ errors:$", lines[0]), one
        assert all(10 <= len(line) <= 260 for line in lines), one
        assert one.words.replace("\n", "").isprintable(), one
        assert not [inner for inner in INTERNALS if inner in one.words], one


def test_the_table_holds_todays_words(told):
    assert TABLE.read_text(encoding="utf-8") == written(told), "run python -m tests.faults"
