"""Warnings about scenes and states that can be solved but are likely mistakes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..robot import Robot
from ..robot.placing import Posture
from ..robot.state import likely_wxyz, outside_limits
from ..scene import AppliedImpulse, Collision, Contact, GapContact, JointImpulse, Rope, Scene
from .singular import shares_of_inertia

if TYPE_CHECKING:
    from ..scene.entries import ContactEntry
    from .answer import Answer
    from .gaps import ContactGap

__all__ = ["doubts_of", "doubts_of_state"]

# Velocities that change by less than this part are unchanged but for rounding.
UNCHANGED = 1e-12
# Beside this share of inertia, rounding (2e-16) in the model's numbers moves velocities by more
# than the 1e-9 that a valid answer keeps.
FAINT_INERTIA = 2e-7
# Rolling and torsion above this [m] are likely a mistake: 1e-5 to 5e-2 m in practice.
LONG_LEVER = 0.2
# A plane whose normal is this near the way up (cosine) is a floor.
UPWARDS = 0.7


def doubts_of(impact: Answer) -> tuple[str, ...]:
    """Return the warnings, one sentence each; see ``Impact.doubts``."""
    scene = impact.scene
    found = outside_limits(scene.robot, impact.q) + likely_wxyz(scene.robot, impact.q)
    found += _nothing_to_hit(scene, moves=True)
    touching: set[int] = set()
    off: set[int] = set()
    if scene.contacts:
        rows = impact.rows
        touching.update(rows.entries)
        gaps = zip(rows.entries, rows.gaps.tolist(), strict=True)
        off.update(i for i, gap in gaps if abs(gap) > scene.gap_bound)
    grounds = any(part.changes.grounds for part in scene.robot.parts)
    collides = any(isinstance(entry, Collision) for entry in scene.contacts)
    if off or collides or scene.constraints or grounds:
        found += _of_places(scene, Posture(scene.robot, impact.q, impact.v_before), off)
    found += _long_levers(scene)
    found += _nothing_strikes(impact, touches=bool(touching))
    found += _next_to_no_inertia(impact)
    return tuple(found)


def _of_places(scene: Scene, posture: Posture[Robot], off: set[int]) -> Iterator[str]:
    """Contacts ``off`` by too much, bodies close by, open anchors, links under a ground."""
    from .gaps import anchor_openings, bodies_close_by, contact_gaps

    close = sorted(off.union(bodies_close_by(scene, posture)))
    gaps = contact_gaps(scene, posture, close)
    yield from _of_contacts([scene.contacts[i] for i in close], scene, gaps)
    for opening in anchor_openings(scene, posture):
        if opening.gap > scene.gap_bound:
            yield f"{opening.name} is open by {opening.gap:.3g} m"
    if scene.gap_bound < np.inf:
        yield from _under_grounds(scene, posture)


def doubts_of_state(scene: Scene, q: np.ndarray, *, moves: bool = False) -> tuple[str, ...]:
    """Return the warnings about a scene and a configuration that need no solution.

    Args:
        q: (nq,) configuration.
        moves: whether the scene is simulated: then gravity and forces act as well.
    """
    robot = scene.robot
    found = outside_limits(robot, q) + likely_wxyz(robot, q)
    return (*found, *_nothing_to_hit(scene, moves=moves))


def _nothing_to_hit(scene: Scene, *, moves: bool) -> list[str]:
    """Why nothing can be hit, where the robot has a ground or a file with contacts."""
    if scene.contacts:
        return []
    robot = scene.robot
    grounds = [f'"{part.name_of(one)}"' for part in robot.parts for one in part.changes.grounds]
    if grounds:
        return [
            f"nothing can be hit: the robot has the ground {grounds[0]}, and the scene no "
            'contacts; Scene(..., collisions="all") lets everything collide'
        ]
    if robot.touching_pairs:
        return [
            "nothing can be hit: the robot's file has contacts, and the scene none; "
            "Scene.of_robot(robot) takes the file's"
        ]
    if moves or scene.impulses or scene.constraints:
        return []
    return ["nothing strikes: the scene has no impulses, constraints or contacts"]


def _long_levers(scene: Scene) -> Iterator[str]:
    """Rolling and torsional friction that is likely a number without unit, or in millimetres."""
    names = scene.entry_names("contacts")
    for name, entry in zip(names, scene.contacts, strict=True):
        for word in ("rolling", "torsion"):
            length = getattr(entry, word, 0.0)
            if length > LONG_LEVER:
                yield (
                    f"{name}: {word} is {length:.3g} m; it is a length, about the size of the area "
                    "of contact"
                )


def _of_contacts(
    close: Sequence[ContactEntry], scene: Scene, gaps: tuple[ContactGap, ...]
) -> Iterator[str]:
    for entry, item in zip(close, gaps, strict=True):
        if item.left_out and scene.gap_bound < np.inf:
            more = "more " if item.touching else ""
            lie = "point lies" if item.left_out == 1 else "points lie"
            # Rounded up, so that they are included by what is said.
            within = float(f"{item.reach * 1.05:.1e}")
            yield (
                f"{item.name}: {item.left_out} {more}{lie} within {1e3 * within:.2g} mm, outside "
                f"margin {1e3 * item.margin:.2g} mm; margin={within:.2g} includes them"
            )
        if not item.touching or abs(item.gap) <= scene.gap_bound:
            continue
        size = f"{abs(item.gap):.3g} {'rad' if item.angular else 'm'}"
        if isinstance(entry, Contact):
            ends = f'"{entry.frame}" is {size}'
            if item.gap > 0.0:
                yield f'{item.name}: {ends} away from the plane of "{entry.against}"'
            elif _is_floor(scene, entry):
                yield f"{item.name}: {ends} under its floor"
            else:
                fixed = scene.robot.frame(entry.frame).joint_id == 0
                swapped = " (are frame and against swapped?)" if fixed else ""
                yield f'{item.name}: {ends} inside the plane of "{entry.against}"{swapped}'
        elif isinstance(entry, Collision):
            yield f'{item.name}: "{entry.first}" and "{entry.other}" overlap by {size}'
        elif isinstance(entry, Rope):
            longer = f"its length of {entry.length:g} m"
            yield f'{item.name}: "{entry.frame}" and "{entry.other}" are {size} beyond {longer}'
        elif isinstance(entry, GapContact):
            yield f"{item.name}: its gap is {item.gap:.3g}"
        else:
            yield f'{item.name}: joint "{entry.joint}" is {size} past its limit'


def _up(scene: Scene) -> np.ndarray:
    """(3,) against gravity; along z where nothing falls."""
    gravity = np.array(scene.gravity)
    size = float(np.linalg.norm(gravity))
    return -gravity / size if size else np.array([0.0, 0.0, 1.0])


def _is_floor(scene: Scene, entry: Contact) -> bool:
    """Return True if a contact's plane is fixed in the world and faces upwards."""
    frame = scene.robot.frame(entry.against)
    normal = frame.rotation @ np.array(entry.normal)
    return frame.joint_id == 0 and float(normal @ _up(scene)) > UPWARDS


def _under_grounds(scene: Scene, posture: Posture[Robot]) -> Iterator[str]:
    """Links whose mass centres are below a ground of the robot: the lowest of each ground."""
    robot = scene.robot
    if not any(part.changes.grounds for part in robot.parts):
        return
    moving = [link for link in robot.links if link.joint_id > 0 and link.mass > 0.0]
    if not moving:
        return
    centres = np.array([posture.joint(link.joint_id).act(link.com_in_joint) for link in moving])
    for part in robot.parts:
        at = np.eye(4) if part.placement is None else np.array(part.placement)
        for ground in part.changes.grounds:
            # The plane is kept in the coordinates of the part.
            normal = at[:3, :3] @ np.array(ground.normal)
            heights = (centres - at[:3, 3]) @ normal - ground.height
            lowest = int(np.argmin(heights))
            if heights[lowest] < -scene.gap_bound:
                yield (
                    f'the robot is under its floor "{part.name_of(ground)}": the mass centre '
                    f'of "{moving[lowest].name}" by {-heights[lowest]:.3g} m'
                )


def _next_to_no_inertia(impact: Answer) -> Iterator[str]:
    """Joints that move, though almost no inertia resists them at this configuration."""
    model = impact.scene.robot.model
    if impact.scene.robot.is_always_regular or not np.isfinite(impact.dv).all():
        return
    shares = shares_of_inertia(impact.mechanics.mass_matrix, impact.mechanics.constraint_matrix)
    moved = np.abs(impact.dv) > UNCHANGED * np.abs(impact.dv).max(initial=0.0)
    faint = np.flatnonzero((shares < FAINT_INERTIA) & moved).tolist()
    if faint:
        ids = np.searchsorted(model.idx_vs[1:], faint, side="right")
        named = ", ".join(f'"{name}"' for name in dict.fromkeys(model.names[int(i)] for i in ids))
        yield (
            f"almost no inertia resists {'joints' if ',' in named else 'joint'} {named} here "
            f"({shares[faint].min():.2g} of the inertia that they carry): their velocities, such "
            f"as {impact.dv[faint[0]]:.3g}, depend on rounding in the model's numbers; lock one of "
            "these joints or correct the <inertial> of their links"
        )


def _nothing_strikes(impact: Answer, touches: bool) -> list[str]:
    """Why no velocity changes, where none does."""
    scene = impact.scene
    size = float(np.abs(impact.v_before).max(initial=0.0))
    # What is not finite is no small change, either.
    if not np.abs(impact.dv).max(initial=0.0) <= UNCHANGED * size:
        return []
    if not (scene.impulses or scene.constraints or scene.contacts):
        return ["nothing strikes: the scene has no impulses, constraints or contacts"]
    if any(map(_acts, scene.impulses)):
        return []
    if size == 0.0:
        return ["nothing strikes: no impulse acts and the robot is at rest"]
    if scene.contacts and not touches:
        from .gaps import nearest_contacts

        (nearest,) = nearest_contacts(scene, Posture(scene.robot, impact.q, impact.v_before))
        unit = "rad" if nearest.angular else "m"
        return [
            f"nothing strikes: no contact touches; the nearest, {nearest.name}, is "
            f"{nearest.gap:.3g} {unit} away"
        ]
    if touches and not scene.constraints:
        return ["nothing strikes: no contact that touches is approached"]
    return ["nothing strikes: no velocity changes"]


def _acts(entry: AppliedImpulse | JointImpulse) -> bool:
    if isinstance(entry, AppliedImpulse):
        return any(entry.linear) or any(entry.angular)
    return bool(np.any(entry.impulse))
