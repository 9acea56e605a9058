"""A hammer falls on an anvil, turning about the butt of its handle, rebounds and comes to rest.

python examples/hammer_blow.py
"""

from pathlib import Path

import numpy as np

import impulsekit as ik

MODELS = Path(__file__).parents[1] / "models"
FACE = [0.05, 0, 0.3125]  # of the hammer, in the frame of its handle [m]

hammer = ik.Robot.from_urdf(MODELS / "hammer.urdf", root="freeflyer")
scene = ik.Scene(
    hammer,
    # The hand holds the butt and lets it turn about the y axis.
    constraints=[
        ik.FrameAnchor("handle", other_at=[0, 0, 0], directions=("x", "y", "z", "rx", "rz"))
    ],
    # The anvil's face meets the hammer's when the handle is level.
    contacts=[
        ik.Contact("handle", at=FACE, origin=[0, 0, -FACE[0]], restitution=0.5, name="anvil")
    ],
)
raised = np.radians(20.0)  # the handle starts so far from upright and swings down by its weight
q = hammer.configuration(root_joint=[0, 0, 0, 0, np.sin(raised / 2), 0, np.cos(raised / 2)])
motion = ik.simulate(scene, q, hammer.velocity(), duration=4.0)

time, blow = motion.impacts[0]
print(f"blow after {time:.3f} s at {-blow.contacts[0].velocity_before[2]:.2f} m/s")
hand = np.linalg.norm(blow.constraints[0].impulse[:3])
print(f"the anvil takes {blow.contacts[0].impulse[2]:.3f} N s, the hand {hand:.3f} N s")
print(f"{len(motion.impacts)} blows in all, at rest after {motion.rests[-1].start:.3f} s")
