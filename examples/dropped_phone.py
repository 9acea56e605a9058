"""A phone falls flat on two corners: which one strikes first decides how it moves on.

Rigid bodies leave it open. All outcomes lie between two that tip it left or right and the one that
leaves it at rest (Halm & Posa 2019). With the name of a picture the cloud is drawn.

python examples/dropped_phone.py [PICTURE]
"""

import sys

import impulsekit as ik

# 1 m wide, 2 m high, 1 kg, in the plane of x and y.
PHONE = """<robot name="phone"><link name="phone">
<inertial><mass value="1"/>
<inertia ixx="0.333" iyy="0.0833" izz="0.4166666666666667" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><box size="1 2 0.1"/></geometry></visual></link></robot>"""


def dropped(height: float = 0.01) -> ik.Impact:
    """The impact after a fall."""
    phone = ik.Robot.from_urdf(PHONE, root="planar")
    corners = [
        ik.Contact(
            "phone", at=[x, -1, 0], origin=[0, -1, 0], normal=[0, 1, 0], friction=1, name=name
        )
        for x, name in ((-0.5, "left"), (0.5, "right"))
    ]
    fall = [0, -((2 * 9.81 * height) ** 0.5), 0]
    return ik.solve(ik.Scene(phone, contacts=corners), phone.neutral(), fall)


if __name__ == "__main__":
    outcomes = dropped().outcomes()
    print(ik.report(outcomes))
    right = outcomes.extreme([1, 0, 0]) / outcomes.impact.v_before[1]
    print(f"furthest to the right: v_y- times {right.round(4) + 0.0}")
    if len(sys.argv) > 1:
        ax = ik.plots.outcome_cloud(outcomes, 0, 1)
        ax.figure.savefig(sys.argv[1])
