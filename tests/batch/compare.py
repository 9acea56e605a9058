"""A batch held against ``ik.solve``, row by row."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import impulsekit as ik
from impulsekit.batch.result import OUTPUTS as EVERY_OUTPUT
from impulsekit.batch.solve import solve_batch
from impulsekit.laws.status import Status

# Reactions and bodies follow from these, and know no points of collisions.
SOLVED_FOR = tuple(name for name in EVERY_OUTPUT if name not in ("reactions", "bodies"))


def random_states(robot, count, seed=0, spread=1.5):
    rng = np.random.default_rng(seed)
    steps = rng.uniform(-spread, spread, (count, robot.nv))
    q = np.array([pin.integrate(robot.model, robot.neutral(), step) for step in steps])
    return q, rng.normal(size=(count, robot.nv))


def worst_difference(scene, q, v, rows=None, **varying):
    """The largest relative difference of any output over the valid rows, and the batch."""
    batch = solve_batch(scene, q, v, outputs=SOLVED_FOR, **varying)
    worst = 0.0
    for i in range(len(q)) if rows is None else rows:
        try:
            impact = ik.solve(scene, q[i], v[i])
        except ik.errors.SingularMassError:
            assert batch.status[i] == Status.SINGULAR_MASS
            continue
        if impact.status is ik.Status.INACCURATE:
            continue
        assert impact.status == batch.status[i], (i, impact.status.name, int(batch.status[i]))
        if not impact.status.valid:
            continue
        pairs = [
            (batch.v_after[i], impact.v_after),
            (batch.dv[i], impact.dv),
            (batch.generalized_impulse[i], impact.generalized_impulse),
        ]
        speed = np.abs(impact.v_before).max() + np.abs(impact.dv).max()
        sizes = [speed, speed, np.abs(impact.generalized_impulse).max()]
        pairs.append((batch.energy_change[i], impact.energy.change))
        sizes.append(impact.energy.before + impact.energy.after)
        load = max((np.abs(c.impulse).max() for c in impact.contacts), default=0.0)
        for k, contact in enumerate(impact.contacts):
            if contact.unique:
                own = batch.contact_impulses[i, k, : len(contact.impulse)]
                pairs.append((own, contact.impulse))
                sizes.append(load)
                # What pushes, along its normal; the velocities of what does not are not told.
                if len(contact.points) == 1 and impact.contacts[k].impulse.any():
                    touch = contact.points[0]
                    if touch.normal is not None:
                        told = [touch.normal @ x for x in (touch.velocity_before,
                                touch.velocity_after, touch.impulse)]  # fmt: skip
                        pairs.append((batch.normal_components[i, k, :2], np.array(told[:2])))
                        pairs.append((batch.normal_components[i, k, 2], told[2]))
                        sizes += [speed * (1.0 + np.abs(contact.impulse).max() / load), load]
        if impact.constraints:
            borne = np.concatenate([c.impulse for c in impact.constraints])
            pairs.append((batch.constraint_impulses[i], borne))
            sizes.append(np.abs(borne).max())
        for (ours, theirs), size in zip(pairs, sizes, strict=True):
            worst = max(worst, float(np.abs(ours - theirs).max()) / max(size, 1e-300))
    return worst, batch
