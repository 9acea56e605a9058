"""Examples inside MuJoCo say the same as impulsekit alone."""

import importlib.util
import os
import subprocess
import sys

import pytest

from . import EXAMPLES, printed

pytest.importorskip("mujoco")
# Frames of a fall: how many, how far the first is from one grey, how far the last is from it.
FRAMES = """
import runpy, sys
import mujoco, numpy as np
names = runpy.run_path(sys.argv[1])
for name, _, given in names["robots"]:
    frames = []
    with mujoco.Renderer(given[0], 120, 160) as renderer:
        def show(data):
            if not len(frames) or data.time > 0.3 * len(frames):
                renderer.update_scene(data)
                frames.append(renderer.render().astype(float))
        names["fall"](*given, 0.2, show)
    print("frames", name, len(frames), frames[0].std(), np.abs(frames[-1] - frames[0]).max())
"""


@pytest.mark.parametrize("name", ["ball_on_arm", "box_in_mujoco"])
def test_velocities_are_those_of_a_scene(name):
    assert float(printed(name)[-1][-1]) < 1e-10


def test_the_paddle_keeps_the_ball_at_its_height():
    rows = printed("juggling_paddle")[1:-1]
    assert len(rows) == 8
    assert all(float(row[4]) == pytest.approx(1.0, abs=0.01) for row in rows)


def test_robots_lose_less_where_they_rebound():
    _, *rows, alone = printed("landing_in_mujoco")
    lost = {(row[0], row[1]): float(row[4]) for row in rows}
    assert lost["Solo12", "0.0"] > lost["Solo12", "0.2"] == float(alone[-2])
    has_humanoid = importlib.util.find_spec("gymnasium") is not None
    assert has_humanoid == (("humanoid", "0.0") in lost)
    if has_humanoid:
        assert lost["humanoid", "0.0"] > lost["humanoid", "0.2"] > 100.0


@pytest.mark.parametrize("library", ["egl", "osmesa"])
def test_landings_can_be_drawn_without_a_display(library):
    script = str(EXAMPLES / "landing_in_mujoco.py")
    done = subprocess.run(
        [sys.executable, "-c", FRAMES, script],
        capture_output=True, text=True, env={**os.environ, "MUJOCO_GL": library},
    )  # fmt: skip
    if done.returncode and "OpenGL" in done.stderr:
        pytest.skip(f"{library}: {done.stderr.splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines() if line.startswith("frames")]
    assert rows
    for _, _, count, spread, change in rows:
        assert int(count) >= 3
        assert float(spread) > 1.0
        assert float(change) > 20.0
