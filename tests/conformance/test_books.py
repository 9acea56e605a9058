"""What follows from v⁺ and the impulses: energy, works, modes, reactions, how links move."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from .mechanics import WORLD_AXES
from .scenes import SCENES

LAWS = {"newton": ik.Law(), "stronge-sequence": ik.Law("stronge", "path", "sequential")}
BAR = 1e-11

PAIRS = [pytest.param(law, scene, id=f"{law}-{scene}") for law in LAWS for scene in SCENES]


def solved(law, scene):
    case = SCENES[scene]()
    return ik.solve(case.under(LAWS[law]), case.q, case.v)


def bodies(robot, q, dv):
    """Of each moving joint, what it carries: (momenta about the world's origin (6,), placement)."""
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, q)
    found = {}
    for i in range(1, model.njoints):
        J = pin.getJointJacobian(model, data, i, WORLD_AXES)
        place, inertia = data.oMi[i], model.inertias[i]
        lever = place.rotation @ inertia.lever
        v, w = J[:3] @ dv, J[3:] @ dv
        linear = inertia.mass * (v + np.cross(w, lever))
        about = place.rotation @ inertia.inertia @ place.rotation.T @ w
        found[i] = (
            np.array([*linear, *(about + np.cross(place.translation + lever, linear))]),
            place,
        )
    return found


def given_from_outside(impact):
    """By joint, (6,) the impulses on its body about the world's origin."""
    scene, robot = impact.scene, impact.scene.robot
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, impact.q)
    total = {i: np.zeros(6) for i in range(model.njoints)}

    def add(frame, at, linear, angular, sign=1.0):
        if frame == "world":
            return
        joint = model.frames[robot.frame_id(frame)].parentJoint
        total[joint] += sign * np.array([*linear, *(np.cross(at, linear) + angular)])

    place = {f: data.oMf[robot.frame_id(f)] for f in robot.frame_names}
    for blow in scene.impulses:
        at = place[blow.frame].act(np.array(blow.at))
        add(blow.frame, at, np.array(blow.linear), np.array(blow.angular))
    for contact, found in zip(scene.contacts, impact.contacts, strict=True):
        at = place[contact.frame].act(np.array(contact.at))
        add(contact.frame, at, found.impulse, 0.0)
        add(contact.against, at, found.impulse, 0.0, -1.0)
    for entry, found in zip(scene.constraints, impact.constraints, strict=True):
        if isinstance(entry, ik.PointAnchor):
            add(entry.frame, place[entry.frame].act(np.array(entry.at)), found.impulse, 0.0)
    return total


@pytest.mark.parametrize(("law", "scene"), PAIRS)
def test_energy_and_works(law, scene):
    impact = solved(law, scene)
    model = impact.scene.robot.model
    kinetic = [
        pin.computeKineticEnergy(model, model.createData(), impact.q, v)
        for v in (impact.v_before, impact.v_after)
    ]
    energy, size = impact.energy, max(kinetic)
    np.testing.assert_allclose((energy.before, energy.after), kinetic, rtol=0, atol=BAR * size)
    assert abs(energy.change - kinetic[1] + kinetic[0]) < BAR * size
    works = [*(c.work for c in impact.contacts), *(c.work for c in impact.constraints)]
    for blow in impact.scene.impulses:
        point = impact.velocity_at(blow.frame, blow.at)
        works.append(np.dot(blow.linear, 0.5 * (point.before + point.after)))
    assert abs(sum(works) - energy.change) < BAR * size
    assert abs(sum(energy.work.values()) - energy.change) < BAR * size
    if LAWS[law].restitution == "stronge":
        assert energy.change < BAR * size + sum(works[len(works) - len(impact.scene.impulses) :])


@pytest.mark.parametrize(("law", "scene"), PAIRS)
def test_contacts_tell_what_they_did(law, scene):
    impact = solved(law, scene)
    for contact, found in zip(impact.scene.contacts, impact.contacts, strict=True):
        assert found.touching and abs(found.gap) < 1e-12
        first = impact.velocity_at(contact.frame, contact.at)
        (point,) = found.points
        relative = [first.before, first.after]
        if contact.against != "world":
            robot = impact.scene.robot
            at = robot.placement(impact.q, contact.against)
            other = impact.velocity_at(
                contact.against, at.rotation.T @ (point.position - at.position)
            )
            relative = [first.before - other.before, first.after - other.after]
        speed = np.abs(relative).max()
        assert np.abs(found.velocity_before - relative[0]).max() < BAR * speed
        assert np.abs(found.velocity_after - relative[1]).max() < BAR * speed
        normal = found.impulse @ point.normal
        across = np.linalg.norm(found.impulse - normal * point.normal)
        if normal == 0.0:
            assert found.mode == "separated"
        elif LAWS[law].slip == "end":
            slip = relative[1] - (relative[1] @ point.normal) * point.normal
            assert (found.mode == "sticking") == (np.linalg.norm(slip) < 1e-9 * speed)
        assert across <= contact.friction * normal * (1.0 + BAR) + 1e-15


@pytest.mark.parametrize(("law", "scene"), PAIRS)
def test_reactions_by_newton_and_euler(law, scene):
    """What a joint gives its child is what all behind it gain, less what they get elsewhere."""
    impact = solved(law, scene)
    model = impact.scene.robot.model
    gained, given = bodies(impact.scene.robot, impact.q, impact.dv), given_from_outside(impact)
    size = max(np.abs(momentum).max() for momentum, _ in gained.values())
    for i, (_, place) in gained.items():
        behind = list(model.subtrees[i])
        about_world = sum(gained[k][0] - given[k] for k in behind)
        linear = about_world[:3]
        angular = about_world[3:] - np.cross(place.translation, linear)
        wanted = np.concatenate([linear, angular])
        found = impact.reactions[model.names[i]]
        assert np.abs(found - wanted).max() < BAR * 10.0 * size
        axis = place.rotation.T
        load = impact.joint_loads[model.names[i]]
        np.testing.assert_allclose(load.force, axis @ linear, rtol=0, atol=BAR * 10.0 * size)
        np.testing.assert_allclose(load.moment, axis @ angular, rtol=0, atol=BAR * 10.0 * size)


@pytest.mark.parametrize(("law", "scene"), PAIRS)
def test_batches_give_the_same_books(law, scene):
    case, names = SCENES[scene](), ("dv", "generalized_impulse", "reactions", "bodies")
    impact = solved(law, scene)
    batch = ik.solve_batch(
        impact.scene, case.q[None], case.v, outputs=(*names, "normal_components")
    )
    robot = impact.scene.robot
    jumps = [impact.bodies[link.name] for link in robot.links]
    wanted = {
        "dv": impact.dv,
        "generalized_impulse": impact.generalized_impulse,
        "reactions": np.array([impact.reactions[name] for name in robot.joint_names]),
        "bodies": np.array([[*jump.dv_com, *jump.domega] for jump in jumps]),
    }
    for name in names if case.shares else names[:2]:
        found = batch.arrays[name][0]
        # A free body's root joint carries nothing.
        size = max(np.abs(wanted[name]).max(), np.abs(impact.generalized_impulse).max())
        assert np.abs(found - wanted[name]).max() < 1e-9 * size
    for found, contact in zip(batch.normal_components[0], impact.contacts, strict=True):
        (point,) = contact.points
        before, after = contact.velocity_before, contact.velocity_after
        if case.shares and contact.impulse.any():
            wanted_normals = [vector @ point.normal for vector in (before, after, contact.impulse)]
            size = np.abs([before, after, contact.impulse]).max()
            np.testing.assert_allclose(found, wanted_normals, rtol=0, atol=1e-9 * size)


def test_links_move_as_pinocchio_has_it():
    impact = solved("newton", "four")
    model, data = impact.scene.robot.model, impact.scene.robot.model.createData()
    total = np.zeros(3)
    for link in impact.scene.robot.links:
        total += link.mass * impact.bodies[link.name].dv_com
    pin.computeCentroidalMomentum(model, data, impact.q, impact.dv)
    np.testing.assert_allclose(total, data.hg.linear, atol=1e-12)
