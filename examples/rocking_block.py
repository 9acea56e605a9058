"""A box rocks on its edge and lands: standing it rocks on, lying it stops.

Housner's block of width 2b and height 2h keeps (2 h² - b²)/(2 (h² + b²)) of its rate, if it
rebounds nowhere, does not slip, and lets go of the edge it rocked about. A wide block, b above
√2 h, would have to fall back: it stays on both edges and stops.

python examples/rocking_block.py
"""

from pathlib import Path

import impulsekit as ik

MODELS = Path(__file__).parents[1] / "models"

box = ik.Robot.from_urdf(MODELS / "box.urdf", root="planar")

print("pose      b [m]  h [m]  Housner  rate kept  old edge")
for pose, b, h, angle in (("standing", 0.10, 0.15, 90), ("lying", 0.15, 0.10, 0)):
    turned = angle == 90  # then the box's own x is up, and its y to the left
    edges = [[-h, b, 0], [-h, -b, 0]] if turned else [[-b, -h, 0], [b, -h, 0]]
    landing, old = (ik.Contact("box", at=edge, normal=[0, 1, 0], friction=2.0) for edge in edges)
    # The right edge is at rest, about which the box turns at 1 rad/s: v = (-h, -b).
    v = box.velocity(root_joint=[-b, h, 1] if turned else [-h, -b, 1])
    q = box.configuration(root_joint=[0, h, 1.5707963267948966 if turned else 0])
    impact = ik.solve(ik.Scene(box, contacts=[landing, old]), q, v)
    housner = (2 * h**2 - b**2) / (2 * (h**2 + b**2))
    rate, mode = impact.v_after[2], impact.contacts[1].mode
    print(f"{pose:8}  {b:5.2f}  {h:5.2f}  {housner:7.4f}  {rate:z9.4f}  {mode}")
