"""A batch held against ``ik.solve``, row by row."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

import impulsekit as ik

OUTPUTS = (
    "v_after", "dv", "generalized_impulse", "energy_change", "contact_impulses",
    "constraint_impulses", "normal_components", "reactions", "bodies",
)  # fmt: skip


def random_states(robot, count, seed=0, spread=1.5):
    rng = np.random.default_rng(seed)
    steps = rng.uniform(-spread, spread, (count, robot.nv))
    q = np.array([pin.integrate(robot.model, robot.neutral(), step) for step in steps])
    return q, rng.normal(size=(count, robot.nv))


def scene_of_row(scene, i, impulses=None, restitution=None, friction=None, points=None):
    """The scene with the numbers of one row."""
    blows, contacts = [], []
    for name, blow in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
        own = (impulses or {}).get(name)
        if own is not None:
            own = own[i]
            change = {"linear": own[:3], "angular": own[3:] if len(own) > 3 else (0, 0, 0)}
            blow = replace(blow, **({"impulse": own} if hasattr(blow, "joint") else change))
        blows.append(blow)
    for k, (name, contact) in enumerate(
        zip(scene.entry_names("contacts"), scene.contacts, strict=True)
    ):
        changes = {}
        if restitution is not None:
            changes["restitution"] = float(restitution[i][k])
        if friction is not None:
            changes["friction"] = float(friction[i][k])
        if points is not None and name in points:
            changes["at"] = points[name][i]
        contacts.append(replace(contact, **changes))
    return replace(scene, impulses=blows, contacts=contacts)


def normal_components(contact):
    """Mean u_n⁻ and u_n⁺ of the points that carry an impulse, and the sum of their P_n."""
    found = [np.zeros(3)]
    for point in contact.points:
        if point.impulse.any():
            way = np.sign(point.impulse) if point.normal is None else point.normal
            found.append([way @ point.velocity_before, way @ point.velocity_after,
                          way @ point.impulse])  # fmt: skip
    return np.sum(found, axis=0) / ([max(len(found) - 1, 1)] * 2 + [1])


def worst_difference(scene, q, v, outputs=OUTPUTS, **varying):
    """The largest relative difference of any output over the valid rows, and the batch."""
    batch, robot = ik.solve_batch(scene, q, v, outputs=outputs, **varying), scene.robot
    worst = 0.0
    for i in range(len(batch)):
        try:
            row = scene_of_row(scene, i, **varying)
            impact = ik.solve(row, np.atleast_2d(q)[i % len(np.atleast_2d(q))], v[i])
        except (ik.errors.SingularMassError, ik.errors.ContradictionError):
            assert not batch.valid[i]
            continue
        assert impact.is_valid() == batch.valid[i], (i, impact.describe_status())
        if not impact.is_valid():
            continue
        speed = np.abs(impact.v_before).max() + np.abs(impact.dv).max()
        load = np.abs(impact.generalized_impulse).max()
        wanted = {
            "v_after": (impact.v_after, speed),
            "dv": (impact.dv, speed),
            "generalized_impulse": (impact.generalized_impulse, load),
            "energy_change": (impact.energy.change, impact.energy.before + impact.energy.after),
        }
        shared = not all(contact.unique for contact in impact.contacts)
        held = np.concatenate([np.zeros(0), *(c.impulse for c in impact.constraints)])
        if not shared:
            impulses = np.zeros((len(impact.contacts), 3))
            for k, contact in enumerate(impact.contacts):
                impulses[k, : len(contact.impulse)] = contact.impulse
            size = max(load, np.abs(impulses).max(initial=0.0), np.abs(held).max(initial=0.0))
            wanted["contact_impulses"] = impulses, size
            along = np.array([normal_components(contact) for contact in impact.contacts])
            wanted["normal_components"] = along.reshape(-1, 3), max(size, speed)
            # Redundant rows share as they like.
            told = np.array([row for c in impact.constraints for row in c.unique_rows], dtype=bool)
            own = batch.arrays.get("constraint_impulses", held[None])[i]
            wanted["constraint_impulses"] = np.where(told, held, own), size
            reactions = np.array([impact.reactions[name] for name in robot.joint_names])
            wanted["reactions"] = reactions, max(np.abs(reactions).max(), size)
        jumps = [impact.bodies[link.name] for link in robot.links]
        moved = np.array([[*jump.dv_com, *jump.domega] for jump in jumps])
        wanted["bodies"] = moved, max(np.abs(moved).max(), speed)
        for name in outputs:
            if name in wanted:
                own, size = wanted[name]
                off = np.abs(batch.arrays[name][i] - own).max(initial=0.0)
                worst = max(worst, float(off) / max(size, 1e-300))
    return worst, batch
