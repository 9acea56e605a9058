"""Code that pages show as text runs where its libraries are installed: loops, a wrapper."""

import re
from pathlib import Path

import pytest

HOWTO = Path(__file__).parents[2] / "docs/howto"
TEXT = (HOWTO / "any_simulator.md").read_text(encoding="utf-8")
CELL = re.search(r"```\{code-cell\} python3\n(.*?)```", TEXT, re.DOTALL).group(1)
LOOPS = dict(re.findall(r"\n## (.*?)\n.*?```\{code-block\} python\n(.*?)```", TEXT, re.DOTALL))
NEEDS = {
    "MuJoCo Warp": "mujoco_warp",
    "MJX": "mujoco.mjx",
    "Newton": "newton",
    "Drake": "pydrake",
    "PyBullet": "pybullet",
}


def test_all_loops_are_known():
    assert LOOPS.keys() == NEEDS.keys()


@pytest.mark.parametrize("name", NEEDS)
def test_the_ball_flies_on_as_the_law_says(name):
    pytest.importorskip(NEEDS[name])
    names = {}
    exec(CELL + LOOPS[name], names)
    # Falling 0.4 m from 3 m/s, up by 0.6 of that, and slower again by what is left of 0.2 s.
    approach = (9 + 2 * 9.81 * 0.4) ** 0.5
    passed = (approach - 3) / 9.81
    up = 0.6 * approach - 9.81 * (0.2 - passed)
    velocity = names["velocity"]
    # The ball sticks: v_x is 5/7 of 2 m/s; the instant errs by a step.
    assert velocity[[0, 2]] == pytest.approx([10 / 7, up], abs=0.035)
    assert velocity[4] == pytest.approx(100 / 7, abs=0.2)


def test_the_wrapper_takes_a_penalty():
    for name in ("gymnasium", "imageio", "torch"):  # gymnasium[mujoco]
        pytest.importorskip(name)
    page = (HOWTO / "learning.md").read_text(encoding="utf-8")
    names = {}
    exec(
        re.search(r"## Gymnasium\n\n```\{code-block\} python\n(.*?)```", page, re.DOTALL).group(1),
        names,
    )
    assert len(names["energies"]) == 20
    assert 0.0 <= min(names["energies"]) < max(names["energies"]) < 100.0
