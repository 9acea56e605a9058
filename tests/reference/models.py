"""Small systems as URDF text, the robots of example-robot-data, and Pinocchio beside them."""

from __future__ import annotations

from decimal import Decimal
from importlib import metadata
from pathlib import Path

import numpy as np
import pinocchio as pin

ROBOTS = {
    str(file).split("example-robot-data/robots/", 1)[1]: Path(str(file.locate())).resolve()
    for file in metadata.files("example-robot-data") or []
    if str(file).endswith(".urdf")
}

LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


def link(name, mass="1", at="0 0 0", rpy="0 0 0", inertia="1 0 0 1 0 1"):
    """A link; ``inertia`` is ixx ixy ixz iyy iyz izz."""
    ixx, ixy, ixz, iyy, iyz, izz = inertia.split()
    return (
        f'<link name="{name}"><inertial><origin xyz="{at}" rpy="{rpy}"/><mass value="{mass}"/>'
        f'<inertia ixx="{ixx}" ixy="{ixy}" ixz="{ixz}" iyy="{iyy}" iyz="{iyz}" izz="{izz}"/>'
        "</inertial></link>"
    )


def joint(name, parent, child, kind="revolute", axis="0 0 1", at="0 0 0", rpy="0 0 0", more=""):
    """A joint."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}" rpy="{rpy}"/><axis xyz="{axis}"/>{LIMIT}{more}</joint>'
    )


def robot(*elements):
    """A whole URDF."""
    return '<robot name="robot">' + "".join(elements) + "</robot>"


def rods(count, mass, length, inertia, hang=False):
    """Rods along x, end to end, pinned about z; the first hangs on the world if asked for.

    All numbers are decimals in text, so that they are exact in any precision.
    """
    half = f"{Decimal(length) / 2} 0 0"
    elements = ['<link name="pin"/>', joint("pin_1", "pin", "rod_1")] if hang else []
    for k in range(1, count + 1):
        elements.append(
            link(f"rod_{k}", mass, half, inertia=f"{inertia} 0 0 {inertia} 0 {inertia}")
        )
        if k > 1:
            elements.append(joint(f"pin_{k}", f"rod_{k - 1}", f"rod_{k}", at=f"{length} 0 0"))
    return robot(*elements)


EVERY_KIND = robot(
    link("base", "3", ".1 .2 .3", ".3 -.2 .5", "1 .1 .05 1.2 .02 1.4"),
    link("slider", ".7", ".05 0 .1", inertia=".1 0 .01 .2 0 .15"),
    link("plate", "1.1", "-.1 .2 0", ".1 0 0", ".3 .02 0 .2 0 .4"),
    link("wheel", ".4", "0 .1 .02", "0 .4 0", ".05 0 .004 .06 0 .07"),
    link("drone", "1.7", ".1 0 -.2", "0 0 .6", ".2 .03 0 .3 .01 .35"),
    link("tool", ".2", ".02 .03 .3", ".2 .1 0", ".01 0 0 .02 0 .015"),
    link("arm", ".9", "0 .3 .1", "1 .5 .2", ".1 .01 0 .12 .01 .09"),
    '<link name="bare"/>',
    joint("zeta", "base", "slider", "prismatic", "1 -2 .5", ".1 .2 -.3", ".3 .2 .1"),
    joint("Beta", "base", "plate", "planar", "1 0 0", "-.2 .1 .4", "-.3 .9 .1"),
    joint("alpha", "plate", "wheel", "continuous", "0 -1 0", ".3 .1 0", "0 1.2 .1"),
    joint("_fly", "slider", "drone", "floating", "1 0 0", ".1 .3 .1", ".5 0 -.4"),
    joint("weld", "wheel", "tool", "fixed", "1 0 0", ".2 0 .1", ".4 .3 .2"),
    joint("elbow", "tool", "arm", "revolute", "1 1 1", "0 .2 .1", "1 .3 -.2"),
    joint("cap", "arm", "bare", "fixed"),
)
"""A tree with a joint of every kind of URDF, skew axes, links behind fixed joints."""

FOUR_BAR = robot(
    link("crank", "1.2", ".2 .01 .02", inertia=".01 0 0 .05 .002 .06"),
    link("coupler", "2.1", ".4 0 .03", inertia=".02 .001 0 .2 0 .21"),
    link("rocker", "1.5", ".25 .02 0", inertia=".01 0 .003 .08 0 .09"),
    '<link name="ground"/>',
    joint("crank_pin", "ground", "crank", "continuous"),
    joint("coupler_pin", "crank", "coupler", at=".4 0 0"),
    joint("rocker_pin", "ground", "rocker", "continuous", at="1 0 0"),
)
"""Crank 0.4, coupler 0.8, rocker 0.5 and ground 1 long; coupler to rocker is left open."""

ROOT_JOINTS = {
    "fixed": None,
    "planar": pin.JointModelPlanar,
    "freeflyer": pin.JointModelFreeFlyer,
}


def pinocchio_model(urdf, root="fixed", mimic=False):
    """The same URDF, a path or XML, read by Pinocchio."""
    read = pin.buildModelFromXML if str(urdf).startswith("<") else pin.buildModelFromUrdf
    if root == "fixed":
        return read(str(urdf), mimic=mimic)
    return read(str(urdf), ROOT_JOINTS[root](), mimic=mimic)


def random_state(model, seed):
    """A configuration on its manifold and a velocity, both of order one."""
    rng = np.random.default_rng(seed)
    q = pin.integrate(model, pin.neutral(model), rng.uniform(-1.5, 1.5, model.nv))
    return q, rng.normal(size=model.nv)


def mass_matrix(model, q):
    """Pinocchio's M."""
    upper = np.triu(pin.crba(model, model.createData(), q))
    return upper + np.triu(upper, 1).T


def spatial_impulse(model, data, name, linear, angular, at):
    """A blow on a link (world axes, point in link axes) as Pinocchio's force on its joint."""
    frame = model.getFrameId(name, pin.FrameType.BODY)
    placement, owner = data.oMf[frame], model.frames[frame].parentJoint
    point = pin.SE3(np.eye(3), placement.translation + placement.rotation @ at)
    return owner, data.oMi[owner].actInv(point.act(pin.Force(np.array(linear), np.array(angular))))


def relative(found, wanted):
    """Largest difference over the largest entry wanted; 0 where both are empty or zero."""
    found, wanted = np.asarray(found), np.asarray(wanted)
    difference = np.abs(found - wanted).max(initial=0)
    return difference and difference / np.abs(wanted).max(initial=0)


def four_bar_pose(crank):
    """Coordinates of the closed four-bar; its crank reaches some 2.29 rad."""
    pin_at = 0.4 * np.array([np.cos(crank), np.sin(crank)])
    reach = np.array([1.0, 0.0]) - pin_at
    span = np.linalg.norm(reach)
    corner = np.arccos((0.8**2 + span**2 - 0.5**2) / (2 * 0.8 * span))
    coupler = np.arctan2(reach[1], reach[0]) + corner
    tip = pin_at + 0.8 * np.array([np.cos(coupler), np.sin(coupler)])
    rocker = np.arctan2(tip[1], tip[0] - 1)
    return np.array([np.cos(crank), np.sin(crank), coupler - crank, np.cos(rocker), np.sin(rocker)])
