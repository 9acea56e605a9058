"""Where to hold a tennis racket for the ball that you hit, and where it stings.

For every place of the hand on the grip there is a point of the strings at which a ball
leaves the hand alone: the centre of percussion about the hand. The further up one holds
the racket, the further out it is.
"""

from __future__ import annotations

import impulsekit as ik

# [m] from the butt, [kg], [kg m²] about the mass centre for the swing; values in the range
# of R. Cross, American Journal of Physics 72, 622 (2004).
MASS, CENTRE, SWING = 0.30, 0.34, 0.0153
MIDDLE = 0.53  # of the strings


def held_at(grip: float) -> ik.Robot:
    """The racket on a hinge, ``grip`` [m] from the butt."""
    return ik.Robot.from_urdf(
        '<robot name="racket"><link name="hand"/><link name="racket"><inertial>'
        f'<origin xyz="{CENTRE - grip} 0 0"/><mass value="{MASS}"/>'
        f'<inertia ixx="0.0015" iyy="{SWING}" izz="0.0168" ixy="0" ixz="0" iyz="0"/></inertial>'
        '</link><joint name="wrist" type="continuous"><parent link="hand"/>'
        '<child link="racket"/><axis xyz="0 1 0"/></joint></robot>'
    )


def sweet_spot(grip: float) -> float:
    """[m] from the butt, where a ball spares the hand."""
    robot = held_at(grip)
    found = ik.design.centre_of_percussion(robot, robot.neutral(), "wrist", "racket")
    return grip + float(found.at[0])


if __name__ == "__main__":
    print("hand [m]   sweet spot [m]   hand's share of a ball in mid-strings")
    for step in range(0, 21, 2):
        grip = 0.01 * step
        robot = held_at(grip)
        at = [MIDDLE - grip, 0, 0]
        table = ik.design.reaction_map(robot, robot.neutral(), "wrist", "racket", at)
        print(f"{grip:8.2f}   {sweet_spot(grip):14.4f}   {abs(table[2, 2]):8.4f}")
    # I = m (middle − centre)(centre − grip) makes the middle of the strings the sweet spot.
    ideal = CENTRE - SWING / (MASS * (MIDDLE - CENTRE))
    print(f"held at {ideal:.4f} m, a ball in the middle of the strings does not sting")
