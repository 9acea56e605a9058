"""Directions in which a circle is tangent to a point, a line, a circle or the side of a cone.

Two convex shapes are apart by the largest separation along any direction n,

    s(n) = −h_a(−n) − h_b(n),

h their support functions. Where s is largest the points that reach furthest differ by a
multiple of n. Of a circle (c, r, axis a) and a line along e, n is across e; seen along e the
circle is an ellipse with the half axes r and r |a·e|, and n that of its tangent nearest to
the line's point. With ψ the angle of n from the longer axis,

    x cos ψ + y sin ψ − √(A² cos² ψ + B² sin² ψ)

is concave where the point is outside, and its only zero of the slope in the point's quadrant
is found by Newton's method, bisected where that leaves the quadrant. Of two circles n is free;
that of their middles is followed while they grow from points to their size: as long as they are
apart there is one such n only, and Newton's method on the sphere finds it from the last.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..tolerances import NONZERO

__all__ = ["along_circles", "cone_sides", "of_circle_and_points", "of_circles_and_lines"]

# A search ends at steps below ARRIVED, relative; least length of a vector and least thickness that
# something is divided by.
ARRIVED, SHORT, THIN = 1e-15, 1e-15, 1e-12
# Newton's steps, and curvatures, below this count as zero.
FLAT_CURVE = 1e-9
# Steps at most: nearly all take less than ten, and halving alone some fifty.
STEPS = 64
# Two circles grow to this part of their radii, with so many steps at most for each.
GROWING = ((0.5, 4), (0.8, 3), (0.93, 3), (0.98, 3), (0.995, 3), (0.999, 3), (0.9998, 3), (1.0, 40))
# While they grow they are this thick, as a part of what their radii lack.
THICK = 0.25
# Sines below which a direction across is not told by a product.
TINY = 1e-9


def of_circle_and_points(
    centre: np.ndarray, axis: np.ndarray, r: float, points: np.ndarray
) -> np.ndarray:
    """(k, 3) from the nearest point of a circle to each point; not of unit length."""
    away = points - centre
    out = away - np.outer(away.dot(axis), axis)
    size = np.linalg.norm(out, axis=1)
    return away - r * out / np.where(size > 0.0, size, 1.0)[:, None]


def of_circles_and_lines(
    centre: np.ndarray,
    axis: np.ndarray,
    r: float | np.ndarray,
    starts: np.ndarray,
    ways: np.ndarray,
) -> np.ndarray:
    """(k, 3) unit vectors across each line, along the tangent of the circle seen along it.

    Args:
        centre, axis, r: of the circle.
        starts, ways: (k, 3) a point [m] and the unit direction of each line.
    """
    u = np.cross(axis, ways)
    sine = np.linalg.norm(u, axis=1)
    cosine = np.abs(ways.dot(axis))
    away = starts - centre
    away = away - np.einsum("ij,ij->i", away, ways)[:, None] * ways
    along = sine <= TINY
    # Seen along its axis the circle is one; any direction will do.
    u = np.where(along[:, None], away, u)
    u /= np.maximum(np.linalg.norm(u, axis=1), NONZERO)[:, None]
    w = np.cross(ways, u)
    x, y = np.einsum("ij,ij->i", away, u), np.einsum("ij,ij->i", away, w)
    b = np.where(along, 1.0, cosine) * r
    psi = _nearest_tangent(np.abs(x), np.abs(y), r, b)
    cos, sin = np.copysign(np.cos(psi), x), np.copysign(np.sin(psi), y)
    return cos[:, None] * u + sin[:, None] * w


def _nearest_tangent(
    x: np.ndarray, y: np.ndarray, a: float | np.ndarray, b: np.ndarray
) -> np.ndarray:
    """(k,) the angle of the normal at the point of an ellipse nearest to (x, y) ≥ 0."""
    low, high = np.zeros(len(x)), np.full(len(x), 0.5 * np.pi)
    psi = np.arctan2(y, x)
    more = (a - b) * (a + b)
    for _ in range(STEPS):
        sin, cos = np.sin(psi), np.cos(psi)
        square = a * a * cos * cos + b * b * sin * sin
        h = np.sqrt(np.maximum(square, NONZERO))
        slope = -x * sin + y * cos + more * sin * cos / h
        bend = (
            -x * cos
            - y * sin
            + more * ((cos - sin) * (cos + sin) + more * (sin * cos / h) ** 2) / h
        )
        rising = slope > 0.0
        low, high = np.where(rising, psi, low), np.where(rising, high, psi)
        with np.errstate(all="ignore"):
            step = slope / bend
        newton = psi - step
        # A step of Newton's that is rounding stays on the bound that it has just moved.
        there = (bend < 0.0) & (np.abs(step) <= ARRIVED * psi)
        good = (bend < 0.0) & (newton > low) & (newton < high)
        following = np.where(there, psi, np.where(good, newton, 0.5 * (low + high)))
        still = bool((np.abs(following - psi) <= ARRIVED * psi).all())
        psi = following
        if still:
            break
    return psi


def along_circles(
    between: np.ndarray, radii: np.ndarray, a1: np.ndarray, a2: np.ndarray
) -> np.ndarray:
    """(k, 3) unit vectors along which two circles are furthest apart, by pair of circles.

    Args:
        between, radii: by pair of circles (k, 3) from the middle of the second to that of the
            first, and (k, 2) their radii [m].
        a1, a2: (3,) the axes of all first and of all second ones.
    """
    size = np.sqrt(np.einsum("ij,ij->i", between, between))[:, None]
    n = np.where(size > 0.0, between / np.maximum(size, NONZERO), a1)
    for part, steps in GROWING:
        n = _climbed(n, between, part * radii, (a1, a2), THICK * (1.0 - part), steps)
    return n


def _climbed(
    n: np.ndarray,
    between: np.ndarray,
    radii: np.ndarray,
    axes: tuple[np.ndarray, np.ndarray],
    thick: float,
    steps: int,
) -> np.ndarray:
    """(k, 3) by Newton's method from near where s is largest."""
    value = _apart(n, between, radii, axes, thick)
    for _ in range(steps):
        step = _uphill(n, between, radii, axes, thick)
        size = float(np.abs(step).max())
        for scale in (1.0, 0.25, 0.05):
            tried = n + scale * step
            tried /= np.sqrt(np.einsum("ij,ij->i", tried, tried))[:, None]
            new = _apart(tried, between, radii, axes, thick)
            better = new >= value - ARRIVED
            n, value = np.where(better[:, None], tried, n), np.where(better, new, value)
            if better.all():
                break
            step = np.where(better[:, None], 0.0, step)
        # Newton's next step would be shorter than rounding.
        if size < FLAT_CURVE:
            break
    return n


def _apart(
    n: np.ndarray,
    between: np.ndarray,
    radii: np.ndarray,
    axes: tuple[np.ndarray, np.ndarray],
    thick: float,
) -> np.ndarray:
    """(k,) s = n·(c₁ − c₂) − r₁ |n × a₁| − r₂ |n × a₂|, the circles a little thick."""
    value = np.einsum("ij,ij->i", n, between)
    for i in (0, 1):
        out = n - np.outer(n.dot(axes[i]), axes[i])
        square = np.einsum("ij,ij->i", out, out)
        value = value - radii[:, i] * np.sqrt(square + thick * thick)
    return value


def _uphill(
    n: np.ndarray,
    between: np.ndarray,
    radii: np.ndarray,
    axes: tuple[np.ndarray, np.ndarray],
    thick: float,
) -> np.ndarray:
    """(k, 3) Newton's step to where s is largest on the sphere, uphill wherever it starts."""
    slope = between
    bend = np.zeros((len(n), 3, 3))
    for i in (0, 1):
        r, flat = radii[:, i : i + 1], np.eye(3) - np.outer(axes[i], axes[i])
        out = n.dot(flat)
        size = np.sqrt(np.einsum("ij,ij->i", out, out) + max(thick, THIN) ** 2)[:, None]
        unit = out / size
        slope = slope - r * unit
        bend = bend - (r / size)[:, :, None] * (flat - unit[:, :, None] * unit[:, None, :])
    pull = np.einsum("ij,ij->i", n, slope)
    across = np.eye(3) - n[:, :, None] * n[:, None, :]
    bend = across @ bend @ across - pull[:, None, None] * across
    slope = slope - pull[:, None] * n
    values, vectors = np.linalg.eigh(bend)
    own = np.einsum("kij,ki->kj", vectors, slope) / np.maximum(np.abs(values), FLAT_CURVE)
    step = np.einsum("kij,kj->ki", vectors, own)
    length = np.sqrt(np.einsum("ij,ij->i", step, step))[:, None]
    return step * np.minimum(1.0, 0.5 / np.maximum(length, NONZERO))


def cone_sides(apex: np.ndarray, axis: np.ndarray, slant: float, other: Any) -> np.ndarray:
    """(k, 3) normals of a cone's side, outwards, that may be where another shape is nearest."""
    flat = float(np.sqrt(1.0 - slant * slant))
    found = []
    spots = np.concatenate((other.points, other.centres))
    out = spots - apex
    out = out - np.outer(out.dot(axis), axis)
    found.append(_unit(out))
    if len(other.ways):
        across = other.ways - np.outer(other.ways.dot(axis), axis)
        size = np.linalg.norm(across, axis=1)
        keep = size > TINY
        lie = across[keep] / size[keep, None]
        share = -slant * other.ways[keep].dot(axis) / (flat * size[keep])
        lie, share = lie[np.abs(share) <= 1.0], share[np.abs(share) <= 1.0]
        side = np.cross(axis, lie) * np.sqrt(1.0 - share * share)[:, None]
        found += [share[:, None] * lie + side, share[:, None] * lie - side]
    e = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    e /= np.linalg.norm(e)
    f = np.cross(axis, e)
    for centre, r in zip(other.centres, other.radii, strict=True):
        found.append(_around(axis, slant, flat, (e, f), apex - centre, other.axis, r))
    if other.slant is not None:
        found.append(_both_slants(axis, slant, other.axis, other.slant))
    u = np.concatenate(found)
    return slant * axis + flat * u


def _unit(vectors: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(vectors, axis=1)
    return vectors[size > 0.0] / size[size > 0.0, None]


def _both_slants(
    axis: np.ndarray, slant: float, other_axis: np.ndarray, other_slant: float
) -> np.ndarray:
    """(k, 3) across the first axis: where n = d on one cone's side and −d on the other's."""
    cosine = float(axis.dot(other_axis))
    square = 1.0 - cosine * cosine
    if square < TINY:
        return np.empty((0, 3))
    # d·a = slant, d·b = −other_slant.
    p = (slant + other_slant * cosine) / square
    q = (-other_slant - slant * cosine) / square
    base = p * axis + q * other_axis
    rest = 1.0 - float(base.dot(base))
    if rest < 0.0:
        return np.empty((0, 3))
    turn = np.cross(axis, other_axis) / np.sqrt(square) * np.sqrt(rest)
    d = np.array((base + turn, base - turn))
    return _unit(d - np.outer(d.dot(axis), axis))


def _around(
    axis: np.ndarray,
    slant: float,
    flat: float,
    across: tuple[np.ndarray, np.ndarray],
    between: np.ndarray,
    other_axis: np.ndarray,
    r: float,
) -> np.ndarray:
    """(k, 3) across the axis: the best normals of a cone's side against a circle.

    d goes from the cone to the circle: the separation is −d·(apex − c) − r |d × b|.
    """
    e, f = across
    angle = np.arange(96) * (2.0 * np.pi / 96)

    def slope(psi: np.ndarray) -> np.ndarray:
        u = np.outer(np.cos(psi), e) + np.outer(np.sin(psi), f)
        turned = flat * (np.outer(np.cos(psi), f) - np.outer(np.sin(psi), e))
        d = slant * axis + flat * u
        out = d - np.outer(d.dot(other_axis), other_axis)
        size = np.maximum(np.linalg.norm(out, axis=1), SHORT)
        return -turned.dot(between) - r * np.einsum("ki,ki->k", out, turned) / size

    here = slope(angle)
    after = np.roll(here, -1)
    falls = (here >= 0.0) & (after < 0.0)
    low, high = angle[falls], angle[falls] + 2.0 * np.pi / 96
    for _ in range(50):
        half = 0.5 * (low + high)
        rises = slope(half) >= 0.0
        low, high = np.where(rises, half, low), np.where(rises, high, half)
    return np.outer(np.cos(low), e) + np.outer(np.sin(low), f)
