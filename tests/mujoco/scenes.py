"""Random scenes of MuJoCo: bodies and chains of all kinds of joints and geoms above a floor."""

import re
from dataclasses import dataclass

import mujoco
import numpy as np

INTEGRATORS = ("RK4", "Euler", "implicit", "implicitfast")


@dataclass(frozen=True)
class RandomScene:
    """A model, its state at the start, and what its contacts have in common."""

    model: mujoco.MjModel
    data: mujoco.MjData
    condim: int
    friction: tuple[float, float, float]
    restitution: dict[str, float]


def geom(random, name):
    """A geom of random kind and size about the origin of its body."""
    kind = random.choice(["sphere", "box", "capsule", "ellipsoid"])
    size = " ".join(f"{x:.4f}" for x in random.uniform(0.03, 0.1, size=3))
    turn = " ".join(f"{x:.4f}" for x in random.normal(size=4))
    at = " ".join(f"{x:.4f}" for x in random.uniform(-0.02, 0.02, size=3))
    return (
        f'<geom name="{name}" type="{kind}" size="{size}" quat="{turn}" pos="{at}" '
        f'mass="{random.uniform(0.3, 2.0):.4f}"/>'
    )


def chain(random, name, at):
    """A body on a free joint, with up to two more on hinges, slides or ball joints below it."""
    text, closing = (
        f'<body name="{name}0" pos="{at}"><freejoint/>{geom(random, f"{name}0")}',
        "</body>",
    )
    for i in range(1, random.integers(1, 4)):
        axis = " ".join(f"{x:.4f}" for x in random.normal(size=3))
        kind = random.choice(["hinge", "slide", "ball"])
        armature = f'armature="{random.uniform(0, 0.02):.4f}"' if kind != "ball" else ""
        joint = f'<joint type="{kind}" axis="{axis}" {armature}/>'
        text += f'<body name="{name}{i}" pos="0 0 -.22">{joint}{geom(random, f"{name}{i}")}'
        closing += "</body>"
    return text + closing


def random_scene(seed, condim=None, bodies=None):
    """Return a scene that is the same for the same seed."""
    random = np.random.default_rng(seed)
    condim = int(random.choice([1, 3, 4, 6])) if condim is None else condim
    cone = random.choice(["pyramidal", "elliptic"])
    friction = random.uniform(0.1, 0.9), random.uniform(0.001, 0.02), random.uniform(1e-4, 5e-3)
    count = int(random.integers(1, 4)) if bodies is None else bodies
    trees = "".join(
        chain(random, name, f"{0.4 * i} 0 {random.uniform(0.7, 1.0):.4f}")
        for i, name in enumerate("abc"[:count])
    )
    text = f"""<mujoco><option integrator="{random.choice(INTEGRATORS)}" cone="{cone}"
    timestep="{random.choice([0.0005, 0.002, 0.005])}"/>
    <default><geom condim="{condim}" friction="{" ".join(f"{x:.5f}" for x in friction)}"/></default>
    <worldbody><geom name="floor" type="plane" size="9 9 .1"/>{trees}</worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[:] = random.normal(size=model.nv)
    names = [model.geom(i).name for i in range(model.ngeom)]
    e = {name: float(random.uniform(0.1, 1.0)) for name in names}
    own = tuple(float(x) for x in model.geom_friction[0])
    return RandomScene(model, data, condim, own, e)


def urdf_scene(path):
    """Return the scene of a URDF's robot that falls on balls at the tips of its tree.

    None where MuJoCo refuses its inertias, or it is all one body.
    """
    text = re.sub(r"<(visual|collision)\b.*?</\1>", "", path.read_text("utf-8"), flags=re.DOTALL)
    setting = '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
    spec = mujoco.MjSpec.from_string(text.replace("</robot>", setting))
    friction = [0.6, 0.005, 0.0001]
    floor = {"size": [9, 9, 0.1], "friction": friction, "contype": 0, "conaffinity": 1}
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, **floor)
    base = spec.worldbody.first_body()
    if base is None:
        return None
    base.add_freejoint()
    for body in spec.bodies[1:]:
        if body.first_body() is None:
            size = {"size": [0.01, 0, 0], "mass": 0, "friction": friction, "conaffinity": 0}
            body.add_geom(name=f"{body.name} tip", **size)
    try:
        model = spec.compile()
    except ValueError:
        return None
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    random, data = np.random.default_rng(5), mujoco.MjData(model)
    data.qvel[:] = random.normal(size=model.nv)
    mujoco.mj_kinematics(model, data)
    data.qpos[2] += 0.05 - data.geom_xpos[1:, 2].min()
    e = {model.geom(i).name: float(random.uniform(0.1, 1.0)) for i in range(model.ngeom)}
    return RandomScene(model, data, 3, tuple(friction), e)
