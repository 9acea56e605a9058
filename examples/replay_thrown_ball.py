"""A ball strikes the forearm of a Panda: an interactive replay, as one page for a browser.

python examples/replay_thrown_ball.py          # writes thrown_ball.html
"""

from pathlib import Path

import impulsekit as ik

scene_file = ik.load_scene(Path(__file__).with_name("thrown_ball.toml"))
impact = ik.solve(scene_file.scene, scene_file.q, scene_file.v)

shown = ik.replay(
    impact,
    "thrown_ball.html",
    points=scene_file.points,  # their velocities, before and after
    traces=scene_file.points[:1],  # the ball's path
    reactions=[f"arm/panda_joint{i}" for i in range(1, 8)],  # impulses in the joints
)
print(f"{len(shown.times)} frames, {shown.duration:g} s, in {shown.page}")
for name, paths in shown.arrows.items():
    print(f"{name}: {len(paths)} arrow{'s' if len(paths) > 1 else ''}")
