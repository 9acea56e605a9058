"""Which contacts closed at an impact: the fewest that are near and explain the jump."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pinocchio as pin

from ..motion.dynamics import Dynamics
from ..rows.contacts import ContactRows, Touch
from ..rows.reach import reached_model
from ..scene import Collision, Scene

__all__ = ["ClosingContacts"]

# Contacts within this of the nearest may have closed with it [m]; a box that meets a floor with
# an edge a degree off has its corners 2 mm apart for each 0.1 m.
TOGETHER = 0.01
# Probability below which the jump is not explained by a set of contacts, and a larger is tried.
UNEXPLAINED = 0.01
# Larger sets explain almost any jump.
MOST = 4
# Singular values of the contacts' rows below this share of the largest are of dependent rows.
DEPENDENT = 1e-9
# Variances below this share of the largest count as that share.
SINGULAR = 1e-12
# Bodies that collide are looked at up to this gap [m], the largest that a scene can say.
FAR = 1.0


class ClosingContacts:
    """Gaps, rows and the momentum balance of a scene's contacts.

    Args:
        scene: contacts and constraints count.
    """

    def __init__(self, scene: Scene) -> None:
        scene = replace(scene, impulses=())
        self._dynamics = Dynamics(scene)
        # Not the robot's own model: that has no frames for the points of constraints.
        self._model = self._dynamics.model
        self._data = self._model.createData()
        self._names = scene.entry_names("contacts")
        own = scene.robot.model
        reached = reached_model(own, range(1, own.njoints), keep_places=True)
        self._margins = {
            k: entry.margin
            for k, entry in enumerate(scene.contacts)
            if isinstance(entry, Collision)
        }
        contacts = [
            replace(entry, margin=FAR) if isinstance(entry, Collision) else entry
            for entry in scene.contacts
        ]
        self._rows = ContactRows(replace(scene, contacts=contacts), reached)
        self._reached = reached.model
        self._reached_data = reached.model.createData()

    def gaps(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(contacts,) the gap of each [m, rad]; infinite for a stop without limits."""
        found = np.full(len(self._names), np.inf)
        gaps = self._dynamics.gaps
        if gaps is not None:
            distances, _ = gaps.everything(q, v)
            np.minimum.at(found, gaps.entries, distances)
        return found

    def nearest(
        self, q: np.ndarray, v: np.ndarray, covariance: np.ndarray
    ) -> tuple[float, float] | None:
        """The least gap and its standard deviation, for a ``covariance`` (nv, nv) of q.

        None without a contact whose gap changes with q.
        """
        gaps = self.gaps(q, v)
        if not np.isfinite(gaps).any():
            return None
        rows, _ = self._jacobian(q, (int(np.argmin(gaps)),))
        if not len(rows):
            return None
        normal = rows[2] if len(rows) >= 3 else rows[0]
        return float(gaps.min()), float(np.sqrt(normal @ covariance @ normal))

    def of_jump(
        self,
        q: np.ndarray,
        jump: np.ndarray,
        covariance: np.ndarray,
        speed: np.ndarray,
        near: float,
    ) -> tuple[tuple[str, ...], np.ndarray, np.ndarray, float]:
        """Names, gaps, impulses (k, 3) in the world, and the probability of the balance.

        Args:
            q: (nq,). jump: (nv,) v⁺ − v⁻. covariance: (nv, nv) of the jump.
            speed: (nv,) v⁻, for the rates of gaps.
            near: contacts farther than this took no part [m].
        """
        from scipy import stats

        gaps = self.gaps(q, speed)
        order = [int(k) for k in np.argsort(gaps) if gaps[k] <= near]
        order = [k for k in order if gaps[k] <= gaps[order[0]] + TOGETHER][: 2 * MOST]
        mass = self._dynamics.mass_matrix(q)
        momentum = mass @ jump
        weight = _inverse_root(mass @ covariance @ mass.T)
        best: tuple[float, tuple[int, ...], np.ndarray] = (0.0, (), np.zeros((0, 3)))
        for size in range(1, min(len(order), MOST) + 1):
            for chosen in combinations(order, size):
                rows, axes = self._jacobian(q, chosen)
                held = self._held(q)
                basis = weight @ np.vstack([rows, held]).T
                shares, _, rank, _ = np.linalg.lstsq(basis, weight @ momentum, rcond=DEPENDENT)
                left = weight @ momentum - basis @ shares
                freedom = len(momentum) - int(rank)
                fits = float(stats.chi2.sf(float(left @ left), freedom)) if freedom else 1.0
                local = shares[: len(rows)].reshape(-1, 3)
                if (local[:, 2] < 0.0).any():
                    # No contact pulls.
                    fits *= 1e-3
                if fits > best[0] or not best[1]:
                    world = np.einsum("kij,kj->ki", axes, local)
                    best = fits, chosen, world
            if best[0] >= UNEXPLAINED:
                break
        probability, chosen, impulses = best
        names = tuple(self._names[k] for k in chosen)
        return names, gaps[list(chosen)], impulses, probability

    def mass_and_rows(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M (nv, nv), the rows of all contacts and constraints, and the contacts' normal rows."""
        mass = np.array(self._dynamics.mass_matrix(q))
        rows, _ = self._jacobian(q, tuple(range(len(self._names))))
        normals = rows[2::3] if len(rows) == 3 * len(self._names) else rows
        return mass, np.vstack([rows, self._held(q)]), normals

    def _jacobian(self, q: np.ndarray, chosen: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
        """(3 k, nv) rows and (k, 3, 3) axes of contacts; of a stop, its row as the normal."""
        touches = self._nearest_points(self._rows.touching(self._reached_data, q, chosen))
        if not touches:
            return np.zeros((0, self._model.nv)), np.zeros((0, 3, 3))
        rows = np.vstack([touch.jacobian for touch in touches])
        axes = np.array([np.eye(3) if t.axes is None else t.axes for t in touches])
        return rows, axes

    def _nearest_points(self, touches: list[Touch]) -> list[Touch]:
        """Of bodies that collide, the points that are nearest, however far: noise parts them."""
        least: dict[int, float] = {}
        for touch in touches:
            if touch.entry in self._margins and touch.gap is not None:
                least[touch.entry] = min(least.get(touch.entry, np.inf), touch.gap)
        return [
            touch
            for touch in touches
            if touch.entry not in least
            or touch.gap is None
            or touch.gap <= max(least[touch.entry], 0.0) + self._margins[touch.entry]
        ]

    def _held(self, q: np.ndarray) -> np.ndarray:
        """(m, nv) rows of the constraints."""
        held = self._dynamics.held
        if held is None:
            return np.zeros((0, self._model.nv))
        pin.computeJointJacobians(self._model, self._data, q)
        return held.matrix(self._data, q)


def _inverse_root(covariance: np.ndarray) -> np.ndarray:
    """W with WᵀW the inverse of a covariance."""
    values, axes = np.linalg.eigh(covariance)
    return axes.T / np.sqrt(np.maximum(values, SINGULAR * values.max()))[:, None]
