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
    contacts, held = scene.entry_names("contacts"), scene.entry_names("held")
    parts = [name for name in (*contacts, *held) if name in found.results]
    of = ["v_after", *parts]
    model = scene.robot.model

    def column(by, d, name=None):
        tables = [found[one, by] if name is None else found[one, by][name] for one in of]
        return np.concatenate([table @ d if table.ndim == 2 else table * d for table in tables])

    for _ in range(2):
        d = rng.normal(size=len(v))
        yield "v", column("v", d), lambda h, d=d: (scene, q, v + h * d)
        yield "q", column("q", d), lambda h, d=d: (scene, pin.integrate(model, q, h * d), v)
    for group, at, by, field in (
        ("impulses", "impulses", "impulses", "values"),
        ("impulses", "impulses", "at", "at"),
        ("contacts", "contacts", "restitution", "restitution"),
        ("contacts", "contacts", "friction", "friction"),
        ("contacts", "contacts", "at", "at"),
        ("contacts", "contacts", "normal", "normal"),
    ):
        for i, (name, own) in enumerate(
            zip(scene.entry_names(group), getattr(scene, group), strict=True)
        ):
            value = getattr(own, field, 0.0)
            is_plain = field not in ("restitution", "friction") or (
                not callable(value) and 0.0 < value < 1.0 + (field == "friction") * 9.0
            )
            if not is_plain or name not in found["v_after", by]:
                continue
            shape = found["v_after", by][name].shape[1:]
            d = rng.normal(size=shape) if shape else 1.0

            def changed(h, i=i, own=own, field=field, value=value, d=d, at=at, shape=shape):
                more = np.array(value) + h * d
                if isinstance(own, ik.JointImpulse):
                    other = replace(own, impulse=more)
                elif field == "values":
                    other = replace(own, linear=more[:3], angular=more[3:])
                else:
                    other = replace(own, **{field: more if shape else float(more)})
                entries = [other if k == i else one for k, one in enumerate(getattr(scene, at))]
                return replace(scene, **{at: entries}), q, v

            yield f"{by} of {name}", column(by, d, name), changed


def assert_true(scene, q, v, bar=1e-6, step=1e-4, *, shares=None):
    """Every derivative that there is; the derivatives themselves are given back.

    ``shares``: whether all impulses are determined, so that none may be left out.
    """
    __tracebackhide__ = True
    impact = ik.solve(scene, q, v)
    found = ik.derivatives(impact)
    assert found.status.exists, found.edges
    missing = set(scene.entry_names("contacts")) - set(found.results)
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
