"""A gun fires: the charge is an impulse inside the joint between barrel and shell.

The barrel slides back on its cradle against a spring and a damper. Without friction the jump
is that of two masses and one impulse, and the stroke that of a damped oscillator.

python examples/gun_recoil.py
"""

import math

import impulsekit as ik

BARREL, SHELL, CHARGE = 400.0, 10.0, 5000.0  # kg, kg, N s
STIFFNESS, DAMPING = 30e3, 4e3  # N/m, N s/m

GUN = f"""<robot name="gun">
  <link name="cradle"/>
  <link name="barrel"><inertial><mass value="{BARREL}"/>
    <inertia ixx="10" iyy="400" izz="400" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="shell"><inertial><mass value="{SHELL}"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="slide" type="prismatic"><parent link="cradle"/><child link="barrel"/>
    <axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="bore" type="prismatic"><parent link="barrel"/><child link="shell"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="1e4" effort="1" velocity="1"/></joint>
</robot>"""

gun = ik.Robot.from_urdf(GUN)
scene = ik.Scene(
    gun,
    impulses=[ik.JointImpulse("bore", CHARGE, name="charge")],
    forces=[ik.JointSpring("slide", STIFFNESS, DAMPING)],
    contacts=[ik.JointStop("slide", lower=-2.0, upper=0.0)],
)
motion = ik.simulate(scene, gun.neutral(), gun.velocity(), duration=3.0, samples=3001)

shot = motion.impacts[0][1]
print(f"muzzle speed {shot.v_after.sum():.1f} m/s, recoil {shot.v_after[0]:.2f} m/s")

decay = DAMPING / (2 * BARREL)
rate = math.sqrt(STIFFNESS / BARREL - decay**2)
turn = math.atan2(rate, decay) / rate
stroke = CHARGE / BARREL / rate * math.exp(-decay * turn) * math.sin(rate * turn)
print(f"stroke {-motion.q[:, 0].min():.4f} m, of a damped oscillator {stroke:.4f} m")
print(
    f"back in battery after {motion.impacts[1][0]:.3f} s, at rest: {motion.rests[-1].start:.3f} s"
)
