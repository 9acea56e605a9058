"""The reference shares nothing with what it checks."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import impulsekit.reference

from .models import FOUR_BAR, robot

MAXIMAL = Path(__file__).parents[2] / "benchmarks" / "truths" / "maximal.py"
FILES = [*sorted(Path(impulsekit.reference.__file__).parent.glob("*.py")), MAXIMAL]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_no_file_imports_pinocchio_or_another_room(file):
    imported = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "a relative import hides where it leads"
            imported.add(node.module or "")
        elif isinstance(node, ast.Call):
            called = getattr(node.func, "id", getattr(node.func, "attr", ""))
            assert called not in ("__import__", "import_module"), "a hidden import"
    for module in imported:
        first = module.split(".")[0]
        assert first not in ("pinocchio", "coal", "hppfcl", "eigenpy", "example_robot_data")
        if first == "impulsekit":
            assert module == "impulsekit.errors" or module.startswith("impulsekit.reference")


USE_IN_FULL = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("pinocchio", "coal", "hppfcl", "eigenpy"):
            raise ImportError(name + " is blocked")
        room = name.removeprefix("impulsekit.").split(".")[0]
        # The package's face tells the display how notebooks show results; no number is in there.
        if name.startswith("impulsekit.") and room not in ("errors", "reference", "formatting"):
            raise ImportError(name + " is blocked")

sys.meta_path.insert(0, Blocked())
try:
    import pinocchio
except ImportError:
    pass
else:
    raise SystemExit("the block does not hold")

from impulsekit.reference import *
from benchmarks.truths.maximal import impact_of_free_bodies

urdf, rod = sys.argv[1:]
for arithmetic in (Arithmetic.double(), Arithmetic.long_double(), Arithmetic.mpmath(60)):
    bars = KaneSystem.from_urdf(urdf, arithmetic=arithmetic)
    ball = KaneSystem.from_urdf(rod, root="freeflyer", arithmetic=arithmetic)
    both = KaneSystem.combine({"ball": ([0, 0, 1], arithmetic.eye(3))}, bars=bars, ball=ball)
    q, y = both.neutral(), [0.5] * both.n
    blow = Load("ball/rod", linear=(1, 2, 3), at=(0.1, 0, 0))
    rows = both.rows_at_point(q, "bars/coupler", "bars/rocker", at=(0.8, 0, 0),
                              other_at=(0.5, 0, 0), directions=[[1, 0, 0]])
    impact = both.impact(q, y, [blow], {"bars/crank_pin": 0.2}, rows)
    third = impact_of_free_bodies(both, q, y, [blow], {"bars/crank_pin": 0.2}, rows)
    error = max(abs(impact.dy - third.dy))
    assert error < 1e6 * float(arithmetic.epsilon), (arithmetic.name, error)
    reactions = impact.joint_reactions()
    error = max(max(abs(reactions[k] - third.joint_reactions[k])) for k in reactions)
    assert error < 1e6 * float(arithmetic.epsilon), (arithmetic.name, error)
    both.accelerations(q, y, gravity=(0, 0, -9.81), springs=[
        JointSpring("bars/crank_pin", 1, 2), PointSpring("bars/rocker", "ball/rod", stiffness=3)])
assert not [name for name in sys.modules if name.split(".")[0] == "pinocchio"]
print("in full")
"""


@pytest.mark.slow
def test_it_works_in_full_where_pinocchio_cannot_be_imported():
    rod = robot(
        '<link name="rod"><inertial><mass value="2"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial></link>'
    )
    done = subprocess.run(
        [sys.executable, "-c", USE_IN_FULL, FOUR_BAR, rod],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=MAXIMAL.parents[2],
    )
    assert done.stdout == "in full\n", done.stderr
