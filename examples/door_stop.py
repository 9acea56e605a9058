"""Where to put a door's stop: what the hinges carry.

A stop at two thirds of the width, the centre of percussion, takes the whole blow, and the
hinges feel next to nothing (the leaf is 4 cm thick). Nearer to the hinges a stop wrenches the
leaf off them the way it pushes, farther out the other way.

python examples/door_stop.py
"""

from pathlib import Path

import impulsekit as ik

MODELS = Path(__file__).parents[1] / "models"
WIDTH, HEIGHT = 0.9, 1.0  # m: of the door, and where the stop is

door = ik.Robot.from_urdf(MODELS / "door.urdf")
v = door.velocity(hinge=-2.0)  # swings towards -y

print("stop at [m]   of the stop [N s]   of the hinges [N s]")
for share in (1 / 3, 1 / 2, 2 / 3, 5 / 6, 1):
    at = [share * WIDTH, -0.02, HEIGHT]  # the door is shut, so this is in the world, too
    stop = ik.Contact("leaf", at=at, origin=at, normal=[0, 1, 0], restitution=0.3)
    impact = ik.solve(ik.Scene(door, contacts=[stop]), door.neutral(), v)
    on_stop = impact.contacts[0].impulse[1]
    # The reaction is what the jamb gives the leaf; x is along the leaf, y across.
    on_hinges = impact.reactions["hinge"][1]
    print(f"{share * WIDTH:11.2f}   {on_stop:17.3f}   {on_hinges:19.3f}")
