"""Scene files: TOML to ``Scene`` and back.

A file names a robot, the state it is in, and what happens to it::

    gravity = [0, 0, -9.81]          # [m/s²]; keys of the whole file stand before the first table
    controlled = ["elbow"]           # joints under stiff control keep their speed in an impact
    gap_bound = 1e-3                 # [m]; contacts and anchors open by more are warned of

    [robot]                          # or [robots.arm], [robots.ball]: several in one world
    urdf = "../models/whittaker_chain_10.urdf"    # relative to this file; or example = "talos"
    root = "planar"                  # fixed (default) | planar | sagittal | freeflyer

    [state.q]                        # by joint name, neutral elsewhere; or q = [...] whole
    joint_2 = 0.3

    [state.v]
    joint_2 = -1.0

    [[impulses]]                     # an AppliedImpulse: its fields are the keys
    frame = "link_10"
    linear = [0, 5, 0]
    at = [1, 0, 0]

    [[impulses]]                     # a JointImpulse
    joint = "joint_3"
    impulse = 0.4

    [[constraints]]                  # PointAnchor and others, by their kind
    kind = "point_anchor"            # point_anchor | frame_anchor | joint_lock | joint_coupling
    frame = "link_1"

    [[forces]]                       # in the motion after the impact
    kind = "joint_spring"            # joint_spring | joint_friction | spring | actuator
                                     # | applied_force
    joint = "joint_2"
    stiffness = 5

    [motion]                         # MotionSettings: its fields are the keys
    duration = 2.0                   # [s]
    samples = 201
    accuracy = "high"

    [[design.points]]                # DesignPoint: what ``impulsekit design`` reports
    frame = "link_10"
    direction = [0, 1, 0]
    joint = "joint_9"

    [[report.points]]                # points whose velocity a report prints
    frame = "link_10"
    at = [1, 0, 0]
    label = "struck end"

A robot also takes ``mimic = true`` and ``package_dirs = [...]``; one of several takes
``placement = {xyz = [0, 1, 0], rpy = [0, 0, 1.57]}`` or ``placement = {matrix = [[...], ...]}``.

What is read is the file, the URDF that it names, wherever that is, and, where geometry is
wanted, meshes below the URDF's own folder, ``package_dirs`` and ROS_PACKAGE_PATH. Nothing that
stands in a file is run.
"""

from .read import SceneFile, load_scene
from .write import dump_scene, save_scene

__all__ = ["SceneFile", "dump_scene", "load_scene", "save_scene"]
