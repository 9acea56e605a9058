"""Where a circle and a line are furthest apart."""

from __future__ import annotations

import numpy as np

from impulsekit.geometry import tangents
from impulsekit.geometry.tangents import of_circles_and_lines


def lines_about_a_circle(rng: np.random.Generator, n: int):
    starts = rng.normal(size=(n, 3))
    ways = rng.normal(size=(n, 3))
    return starts, ways / np.linalg.norm(ways, axis=1)[:, None]


def apart(way: np.ndarray, start: np.ndarray, axis: np.ndarray, r: float) -> float:
    """Along a unit vector across the line, from the circle about the origin to the line."""
    return way @ start - r * np.sqrt(max(1.0 - (way @ axis) ** 2, 0.0))


def test_no_direction_across_a_line_is_better():
    rng = np.random.default_rng(3)
    axis, r = np.array((0.0, 0.0, 1.0)), 0.7
    starts, ways = lines_about_a_circle(rng, 200)
    found = of_circles_and_lines(np.zeros(3), axis, r, starts, ways)
    for start, way, n in zip(starts, ways, found, strict=True):
        assert abs(n @ way) < 1e-14 and abs(n @ n - 1.0) < 1e-14
        across = np.cross(way, n)
        best = apart(n, start, axis, r)
        for angle in (1e-3, -1e-3, 1e-2, -1e-2):
            other = np.cos(angle) * n + np.sin(angle) * across
            assert apart(other, start, axis, r) <= best + 1e-15


def test_a_search_ends_where_its_step_is_rounding(monkeypatch):
    """Halving on from there took fifty steps, for all lines that were asked for together."""
    rng = np.random.default_rng(4)
    axis = np.array((0.0, 0.0, 1.0))
    starts, ways = lines_about_a_circle(rng, 500)
    long = of_circles_and_lines(np.zeros(3), axis, 0.3, starts, ways)
    monkeypatch.setattr(tangents, "STEPS", 12)
    short = of_circles_and_lines(np.zeros(3), axis, 0.3, starts, ways)
    assert np.abs(short - long).max() < 1e-14
