"""Imported before processes are forked: the kernels of a ball that collides are in memory then."""

import impulsekit as ik
from impulsekit.batch.meanwhile import by_kernels_only

_BODY = """<robot name="b"><link name="b"><inertial><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
<collision><geometry>{}</geometry></collision></link></robot>"""
_ball = ik.Robot.from_urdf(_BODY.format('<sphere radius="0.1"/>'), root="freeflyer")
_floor = ik.Robot.from_urdf(_BODY.format('<box size="1 1 1"/>'))
_pair = ik.combine(a=_ball, f=_floor)
_scene = ik.Scene(_pair, contacts=[ik.Collision("a/b", "f/b", friction=0.3)])

with by_kernels_only():
    ik.solve_batch(_scene, [_pair.neutral()], threads=1)
