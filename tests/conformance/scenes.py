"""The scenes of the matrix: robots, states and contacts, each with coefficients of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin

import impulsekit as ik


@dataclass(frozen=True, eq=False)
class Case:
    """A scene under ``Law()`` and a state.

    Attributes:
        islands: whether no contact acts on another.
        shares: whether all impulses are determined, or only resultants.
    """

    scene: ik.Scene
    q: np.ndarray
    v: np.ndarray
    islands: bool = False
    shares: bool = True

    def under(self, law: ik.Law, *, smooth: bool = False) -> ik.Scene:
        """The scene under a law, with friction or without."""
        contacts = [replace(c, friction=0.0) for c in self.scene.contacts]
        return replace(self.scene, law=law, contacts=contacts if smooth else self.scene.contacts)


def _touching(robot, q, places, e, mu, against="world", normals=None) -> list[ik.Contact]:
    """Contacts of points with planes through them, so that all gaps are zero."""
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, q)
    contacts = []
    for i, (frame, at) in enumerate(places):
        place = data.oMf[robot.frame_id(frame)].act(np.array(at, dtype=float))
        if against != "world":
            place = data.oMf[robot.frame_id(against)].actInv(place)
        normal = (0, 0, 1) if normals is None else normals[i]
        contacts.append(
            ik.Contact(
                frame, at=at, normal=normal, origin=place, against=against, restitution=e[i],
                friction=mu[i], stiffness=1e5 * (1.0, 0.7, 1.9, 1.3)[i], name=f"c{i}",
            )
        )  # fmt: skip
    return contacts


@cache
def _box() -> ik.Robot:
    return ik.Robot.from_urdf("models/box.urdf", root="freeflyer")


@cache
def _solo() -> ik.Robot:
    return ik.Robot.from_example("solo12", root="freeflyer")


FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")
CORNERS = [(x, y, -0.05) for x in (-0.15, 0.15) for y in (-0.1, 0.1)]


def _case(robot, q, v, contacts, **more) -> Case:
    own = {key: more.pop(key) for key in ("islands", "shares") if key in more}
    return Case(ik.Scene(robot, contacts=contacts, gravity=(0, 0, 0), **more), q, v, **own)


def _corners(state, v, count, e, mu, **more) -> Case:
    box = _box()
    q = box.configuration(root_joint=state)
    contacts = _touching(box, q, [("box", at) for at in CORNERS[:count]], e, mu)
    return _case(box, q, box.velocity(root_joint=v), contacts, **more)


TURNED = [0.1, 0.2, 0.3, *(np.array([0.2, -0.3, 0.1, 1.0]) / np.sqrt(1.14))]
FLAT = [0, 0, 0.05, 0, 0, 0, 1]


def one() -> Case:
    """A tumbling box on one corner: its slip turns."""
    return _corners(TURNED, [0.9, 0.5, -1.2, 0.7, -0.4, 1.5], 1, [0.5], [0.4], islands=True)


def two() -> Case:
    """A box on two corners with coefficients of their own."""
    return _corners(TURNED, [0.8, 0.3, -1.5, 0.5, -0.3, 0.9], 2, [0.6, 0.3], [0.25, 0.5])


def apart() -> Case:
    """Two boxes that have nothing to do with each other."""
    robot = ik.combine(a=_box(), b=_box())
    half = np.array([0.3, 0.1, -0.2, 1.0]) / np.sqrt(1.14)
    q = robot.configuration(**{"a/root_joint": TURNED, "b/root_joint": [2.0, 0, 0.4, *half]})
    v = np.array([0.9, 0.5, -1.2, 0.7, -0.4, 1.5, -0.6, 0.9, -0.8, 0.2, 1.1, -0.7])
    places = [("a/box", CORNERS[0]), ("b/box", CORNERS[2])]
    contacts = _touching(robot, q, places, [0.5, 0.8], [0.4, 0.2])
    return _case(robot, q, v, contacts, islands=True)


def _solo_state() -> tuple[np.ndarray, np.ndarray]:
    solo = _solo()
    bends = {f"{leg}_{joint}": angle for leg, sign in (("FL", 1), ("FR", 1), ("HL", -1), ("HR", -1))
             for joint, angle in (("HFE", 0.7 * sign), ("KFE", -1.4 * sign))}  # fmt: skip
    q = solo.configuration(root_joint=[0, 0, 0.25, 0, 0, 0, 1], **bends)
    v = 0.4 * np.random.default_rng(5).normal(size=solo.nv)
    v[:6] = [0.4, -0.3, -1.6, 0.2, 0.1, 0.3]
    return q, v


def four() -> Case:
    """Solo12 lands on four feet."""
    q, v = _solo_state()
    places = [(foot, (0, 0, 0)) for foot in FEET]
    e, mu = [0.5, 0.2, 0.35, 0.1], [0.6, 0.4, 0.3, 0.7]
    return _case(_solo(), q, v, _touching(_solo(), q, places, e, mu))


def held() -> Case:
    """Solo12 with one foot pinned to the world and a knee locked lands on two others."""
    solo, (q, v) = _solo(), _solo_state()
    places = [(foot, (0, 0, 0)) for foot in FEET[2:]]
    held = [ik.PointAnchor("FL_FOOT", name="pin"), ik.JointLock("FR_KFE", name="knee")]
    contacts = _touching(solo, q, places, [0.4, 0.7], [0.5, 0.3])
    return _case(solo, q, v, contacts, constraints=held)


def flat() -> Case:
    """A box falls flat on four corners and sticks: their shares are not determined."""
    return _corners(FLAT, [0.1, 0, -1, 0, 0, 0], 4, [0.4] * 4, [0.5] * 4, shares=False)


def sliding() -> Case:
    """A box lands flat and slides on along x."""
    return _corners(FLAT, [3, 0, -1, 0, 0, 0], 4, [0.3] * 4, [0.25] * 4, shares=False)


def turning() -> Case:
    """A box lands flat and turns: each corner slips its own way."""
    return _corners(FLAT, [0.3, 0.1, -0.5, 0, 0, 1.0], 4, [0.3] * 4, [0.4] * 4, shares=False)


def struck() -> Case:
    """A box at rest on two corners is struck on its side, downwards."""
    blow = ik.AppliedImpulse("box", linear=[0.8, 0.3, -2.0], at=[0.1, 0.05, 0.05], name="blow")
    return _corners(FLAT, [0] * 6, 2, [0.6, 0.3], [0.25, 0.5], impulses=[blow])


def heavy() -> Case:
    """A box on the floor is hit by another of a millionth of its mass."""
    text = Path("models/box.urdf").read_text(encoding="utf-8")
    for name in ("3.0", "0.0125", "0.025", "0.0325"):
        text = text.replace(f'="{name}"', f'="{float(name) * 1e-6!r}"')
    light = ik.Robot.from_urdf(text, root="freeflyer")
    robot = ik.combine(box=_box(), chip=light)
    q = robot.configuration(**{"box/root_joint": FLAT, "chip/root_joint": [0, 0, 0.3, *TURNED[3:]]})
    v = np.array([0.2, 0.1, -1.0, 0.3, 0.5, 0.2, 0.5, 0.2, -3.0, 1.0, 0.5, -0.3])
    below = _touching(robot, q, [("box/box", CORNERS[0])], [0.4], [0.3])
    on_top = _touching(robot, q, [("chip/box", CORNERS[0])], [0.7], [0.2], against="box/box")
    return _case(robot, q, v, [*below, replace(on_top[0], name="c1", stiffness=7e4)])


SCENES: dict[str, Callable[[], Case]] = {
    scene.__name__: cache(scene)
    for scene in (one, two, apart, four, held, flat, sliding, turning, struck, heavy)
}
