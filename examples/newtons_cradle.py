"""Newton's cradle of five balls: so many in, so many out.

Only contacts that act one after the other show it (order="sequential"). If all acted at once,
as Newton's law has it, the blow would be shared; energy and momentum are kept both times.

python examples/newtons_cradle.py
"""

from itertools import pairwise
from pathlib import Path

import impulsekit as ik

MODELS = Path(__file__).parents[1] / "models"
NAMES, DIAMETER, STRING = "abcde", 0.022, 0.15  # m

ball = ik.Robot.from_urdf(MODELS / "cradle_ball.urdf")
cradle = ik.combine(
    dict.fromkeys(NAMES, ball),
    placements={name: [i * DIAMETER, 0, 0] for i, name in enumerate(NAMES)},
)
contacts = [
    ik.Collision(f"{right}/ball", f"{left}/ball", restitution=1.0)
    for left, right in pairwise(NAMES)
]

print("in  order         speeds after [m/s]                 energy kept")
for count in (1, 2, 3):
    # A positive angle swings a ball to the left, so the balls come from the left at 1 m/s.
    v = cradle.velocity({f"{name}/swing": -1.0 / STRING for name in NAMES[:count]})
    for order in ("sequential", "simultaneous"):
        scene = ik.Scene(cradle, contacts=contacts, law=ik.Law(order=order))
        impact = ik.solve(scene, cradle.neutral(), v)
        speeds = "  ".join(f"{-STRING * rate:z5.2f}" for rate in impact.v_after)
        kept = impact.energy.after / impact.energy.before
        print(f"{count:2}  {order:12}  {speeds}  {kept:10.3f}")
