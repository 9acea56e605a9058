"""Gradients that engines have published wrong."""

from __future__ import annotations

import pytest

from benchmarks.gradients import BOUND, cases


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.source)
def test_published_cases_are_those_of_closed_forms(case):
    assert case.error < BOUND, (case.ours, case.exact)
