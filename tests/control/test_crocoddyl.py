"""The action of Crocoddyl, in an environment of its own where there is one."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import impulsekit.crocoddyl
from impulsekit.errors import MissingExtraError

ROOT = Path(__file__).parents[2]
VARIABLE = "IMPULSEKIT_CROCODDYL"


@pytest.mark.slow
@pytest.mark.skipif(
    VARIABLE not in os.environ,
    reason=f"{VARIABLE} names no interpreter with Crocoddyl, which needs Pinocchio 4.0; make one "
    "with python -m benchmarks.crocoddyl_action --set-up FOLDER",
)
def test_its_derivatives_are_crocoddyls_numerical_ones():
    done = subprocess.run(
        [os.environ[VARIABLE], "-m", "benchmarks.crocoddyl_action"],
        cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    found = [float(each) for each in re.findall(r"differences (\S+)", done.stdout)]
    # Forward differences have half of the digits.
    assert len(found) == 2 and max(found) < 1e-5, done.stdout


def test_without_crocoddyl_it_says_what_to_do(monkeypatch):
    monkeypatch.setitem(sys.modules, "crocoddyl", None)
    with pytest.raises(MissingExtraError, match=r"needs crocoddyl; python -m benchmarks"):
        impulsekit.crocoddyl.ImpactAction  # noqa: B018
    with pytest.raises(AttributeError, match="it has ImpactAction"):
        impulsekit.crocoddyl.ImpactActoin  # noqa: B018
