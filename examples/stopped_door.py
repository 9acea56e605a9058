"""A Panda stops a door that swings at 1 rad/s: with its joints free, and with its brakes on.

With brakes the door stops dead, and each brake takes a couple impulse; without, arm and door
move on together. The scene is that of stopped_door.toml.

python examples/stopped_door.py
"""

from dataclasses import replace
from pathlib import Path

import impulsekit as ik

file = ik.load_scene(Path(__file__).with_name("stopped_door.toml"))
arm = [name for name in file.scene.robot.joint_names if "arm/panda_joint" in name]
brakes = [ik.JointLock(joint, name=joint) for joint in arm]

for title, extra in (("joints free", []), ("brakes on", brakes)):
    scene = replace(file.scene, constraints=[*file.scene.constraints, *extra])
    impact = ik.solve(scene, file.q, file.v)
    print(f"{title}: the door goes on at {impact.v_after[-1]:z.3f} rad/s,")
    print(f"  the fingertips carry {abs(impact.constraints[0].impulse[0]):.2f} N s,")
    print(f"  {-impact.energy.change:.2f} of {impact.energy.before:.2f} J are lost")
    for brake in impact.constraints[1:]:
        print(f"  brake of {brake.name} {brake.impulse[0]:z8.3f} N m s")
