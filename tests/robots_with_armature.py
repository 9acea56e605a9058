"""Random robots of every kind of joint, with armature, and their dense equations of impact."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import impulsekit as ik


def _axis(rng):
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def _composite(rng):
    joint = pin.JointModelComposite()
    joint.addJoint(pin.JointModelRevoluteUnaligned(_axis(rng)))
    joint.addJoint(pin.JointModelPY(), _placement(rng))
    joint.addJoint(pin.JointModelRX(), _placement(rng))
    return joint


def _universal(rng):
    first = _axis(rng)
    second = np.cross(first, _axis(rng))
    return pin.JointModelUniversal(first, second / np.linalg.norm(second))


# What the kernels of batches know, and what is left to single states.
IN_KERNELS = {
    "revolute": lambda rng: pin.JointModelRY(),
    "revolute about any axis": lambda rng: pin.JointModelRevoluteUnaligned(_axis(rng)),
    "continuous": lambda rng: pin.JointModelRUBZ(),
    "prismatic": lambda rng: pin.JointModelPX(),
    "prismatic along any axis": lambda rng: pin.JointModelPrismaticUnaligned(_axis(rng)),
    "spherical": lambda rng: pin.JointModelSpherical(),
    "translation": lambda rng: pin.JointModelTranslation(),
    "planar": lambda rng: pin.JointModelPlanar(),
    "free": lambda rng: pin.JointModelFreeFlyer(),
}
LEFT_TO_SOLVE = {
    "helical": lambda rng: pin.JointModelHX(0.3),
    "helical about any axis": lambda rng: pin.JointModelHelicalUnaligned(_axis(rng), 0.2),
    "universal": _universal,
    "ball joint by angles": lambda rng: pin.JointModelSphericalZYX(),
    "ellipsoid": lambda rng: pin.JointModelEllipsoid(0.3, 0.4, 0.5),
    "composite": _composite,
}
KINDS = {**IN_KERNELS, **LEFT_TO_SOLVE}


def _placement(rng):
    return pin.SE3(pin.exp3(rng.normal(size=3)), 0.3 * rng.normal(size=3))


def random_robot(rng, kinds, *, armature=True):
    """A tree of one joint of each of these kinds; link k is called "link_k"."""
    model = pin.Model()
    way = [0]
    for k, kind in enumerate(kinds):
        # Depth first, as Pinocchio wants it: a joint hangs on the last one or on one before it.
        del way[max(len(way) - int(rng.integers(3)), 1) :]
        parent = way[-1]
        joint_id = model.addJoint(parent, KINDS[kind](rng), _placement(rng), f"joint_{k}")
        way.append(joint_id)
        mass, half = rng.uniform(0.5, 2.0), rng.uniform(0.05, 0.2, 3)
        box = pin.Inertia.FromBox(mass, *(2.0 * half))
        model.appendBodyToJoint(joint_id, box, _placement(rng))
        model.addBodyFrame(f"link_{k}", joint_id, _placement(rng), 0)
    if armature:
        # Some joints have none, as the free root of a legged robot.
        model.armature = rng.uniform(0.05, 1.0, model.nv) * (rng.random(model.nv) < 0.7)
    return ik.Robot.from_model(model)


def random_configuration(robot, rng):
    """On its manifold, away from where angles of a joint coincide."""
    return pin.integrate(robot.model, robot.neutral(), rng.uniform(-0.8, 0.8, robot.nv))


def dense_masses(robot, q):
    """(nv, nv) M: composite rigid bodies without armature, and the armature on the diagonal."""
    bare = pin.Model(robot.model)
    bare.armature = np.zeros(bare.nv)
    upper = np.triu(pin.crba(bare, bare.createData(), q))
    return upper + np.triu(upper, 1).T + np.diag(robot.model.armature)


def point_jacobian(robot, q, frame, at):
    """(3, nv) of a point of a frame in world axes."""
    model = robot.model
    data = model.createData()
    item = model.frames[robot.frame_id(frame)]
    place = item.placement * pin.SE3(np.eye(3), np.asarray(at, dtype=float))
    pin.computeJointJacobians(model, data, q)
    return pin.getFrameJacobian(model, data, item.parentJoint, place, pin.LOCAL_WORLD_ALIGNED)[:3]
