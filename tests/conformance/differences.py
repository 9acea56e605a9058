"""Derivatives of an impact held against differences of ``solve``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

import impulsekit as ik

__all__ = ["assert_true", "by_differences", "slopes"]


def by_differences(change, step=1e-4):
    """The slope at 0 of a function of a number, by Richardson's extrapolation."""
    coarse, fine = ((change(h) - change(-h)) / (2.0 * h) for h in (2.0 * step, step))
    return (4.0 * fine - coarse) / 3.0


def told(impact):
    """v⁺ and all impulses in one line."""
    entries = (*impact.contacts, *impact.constraints)
    return np.concatenate([impact.v_after, *(entry.impulse for entry in entries)])


def slopes(scene, q, v, found, rng):
    """Of each parameter its name, the slope of ``told`` along a direction, and that direction."""
    parts = (*found.contacts.values(), *found.constraints.values())
    model = scene.robot.model
    for _ in range(2):
        d = rng.normal(size=len(v))
        yield "v", np.concatenate([found.dv_after_dv @ d, *(p.dv @ d for p in parts)]), (
            lambda h, d=d: (scene, q, v + h * d)
        )  # fmt: skip
        yield "q", np.concatenate([found.dv_after_dq @ d, *(p.dq @ d for p in parts)]), (
            lambda h, d=d: (scene, pin.integrate(model, q, h * d), v)
        )  # fmt: skip
    for i, (name, blow) in enumerate(
        zip(scene.entry_names("impulses"), scene.impulses, strict=True)
    ):
        table = [found.dv_after_dimpulse[name], *(p.dimpulse[name] for p in parts)]
        d = rng.normal(size=table[0].shape[1])

        def struck(h, i=i, blow=blow, d=d):
            if isinstance(blow, ik.JointImpulse):
                other = replace(blow, impulse=np.array(blow.impulse) + h * d)
            else:
                numbers = np.array([*blow.linear, *blow.angular]) + h * d
                other = replace(blow, linear=numbers[:3], angular=numbers[3:])
            blows = [other if k == i else one for k, one in enumerate(scene.impulses)]
            return replace(scene, impulses=blows), q, v

        yield name, np.vstack(table) @ d, struck
    for field in ("restitution", "friction"):
        for i, (name, own) in enumerate(
            zip(scene.entry_names("contacts"), scene.contacts, strict=True)
        ):
            value = getattr(own, field, 0.0)
            if callable(value) or not 0.0 < value < 1.0 + (field == "friction") * 9.0:
                continue
            if name not in getattr(found, f"dv_after_d{field}"):
                continue
            table = [getattr(found, f"dv_after_d{field}")[name]]
            table += [getattr(p, f"d{field}")[name] for p in parts]

            def other(h, i=i, own=own, field=field, value=value):
                changed = replace(own, **{field: value + h})
                contacts = [changed if k == i else one for k, one in enumerate(scene.contacts)]
                return replace(scene, contacts=contacts), q, v

            yield f"{field} of {name}", np.concatenate(table), other


def assert_true(scene, q, v, bar=1e-6, step=1e-4, *, shares=None):
    """Every derivative that there is; the derivatives themselves are given back.

    ``shares``: whether all impulses are determined, so that none may be left out.
    """
    __tracebackhide__ = True
    impact = ik.solve(scene, q, v)
    found = ik.derivatives(impact)
    assert found.status.exists, found.edges
    missing = set(scene.entry_names("contacts")) - set(found.contacts)
    for name, ours, change in slopes(scene, q, v, found, np.random.default_rng(0)):
        truth = by_differences(lambda h, change=change: told(ik.solve(*change(h))), step)
        if missing:
            truth = truth[: len(v)]
            ours = ours[: len(v)]
        known = np.isfinite(ours)
        assert known.all() or not shares
        size = max(1.0, np.abs(truth).max())
        assert np.abs(ours - truth)[known].max(initial=0.0) <= bar * size, name
    return found
