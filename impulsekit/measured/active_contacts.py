"""Contacts that closed at an impact: the fewest that are near and explain the jump."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pinocchio as pin

from .._core import ForcesOfMotion
from ..design.fit_result import whitening
from ..impact.flat.scene import flat_scene
from ..impact.outcome import Touch, touches_of
from ..motion.flat import flat_motion
from ..rows.bodies import bodies_of
from ..scene import Collision, Scene

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
# So likely it is, beside one that pushes, that a contact pulls: noise may turn a small impulse.
PULLING = 1e-3
# The key of the constraints' rows among those of contacts.
HELD = -1

Block = tuple[np.ndarray, np.ndarray]


class ClosingContacts:
    """Gaps, rows and the momentum balance of a scene's contacts.

    Args:
        scene: contacts and constraints count.
    """

    def __init__(self, scene: Scene) -> None:
        scene = replace(scene, impulses=())
        self._core = ForcesOfMotion(flat_motion(scene).core, 0.0)
        self._model, self.nv = scene.robot.model, scene.robot.nv
        self._names = scene.entry_names("contacts")
        self._margins = {
            k: bodies_of(scene.robot, entry).margin
            for k, entry in enumerate(scene.contacts)
            if isinstance(entry, Collision)
        }
        contacts = [
            replace(entry, margin=FAR) if isinstance(entry, Collision) else entry
            for entry in scene.contacts
        ]
        self._far = replace(scene, contacts=contacts, controlled=())
        self._flat = flat_scene(self._far)

    def gaps(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the (contacts,) gap of each [m, rad]; infinite for a stop without limits."""
        found = np.full(len(self._names), np.inf)
        for at in self._core.gaps(q, v):
            found[at.entry] = min(found[at.entry], at.value)
        return found

    def nearest(
        self, q: np.ndarray, v: np.ndarray, covariance: np.ndarray
    ) -> tuple[float, float] | None:
        """Return the least gap and its standard deviation, for a ``covariance`` (nv, nv) of q.

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
        """Return names, gaps, impulses (k, 3) in the world, and the probability of the balance.

        What is left of M Δv − JᵀP is weighed by its covariance: that of Δv, and that of q, on
        which M and the rows depend (a normal between two balls turns by δq over their distance).

        Args:
            q: (nq,). jump: (nv,) v⁺ − v⁻. covariance: (2 nv, 2 nv) of (δq, jump).
            speed: (nv,) v⁻, for the rates of gaps.
            near: contacts farther than this took no part [m].
        """
        from scipy import stats

        gaps = self.gaps(q, speed)
        order = [int(k) for k in np.argsort(gaps) if gaps[k] <= near]
        order = [k for k in order if gaps[k] <= gaps[order[0]] + TOGETHER][: 2 * MOST]
        mass = self.mass_of(q)
        momentum = mass @ jump
        here = self._blocks(q, order)
        spread = _Spread(self, q, jump, covariance, here)
        best: tuple[float, tuple[int, ...], np.ndarray] = (0.0, (), np.zeros((0, 3)))
        for size in range(1, min(len(order), MOST) + 1):
            for chosen in combinations(order, size):
                rows, axes = _stacked([here[k] for k in chosen], len(momentum))
                basis = np.vstack([rows, here[HELD][0]]).T
                # Rows as if q were exact say the impulse, which says what q does to the balance.
                shares = np.zeros(basis.shape[1])
                for _ in range(2):
                    weight = whitening(spread.of(chosen, shares))
                    shares, _, rank, _ = np.linalg.lstsq(
                        weight @ basis, weight @ momentum, rcond=DEPENDENT
                    )
                left = weight @ (momentum - basis @ shares)
                freedom = len(momentum) - int(rank)
                fits = float(stats.chi2.sf(float(left @ left), freedom)) if freedom else 1.0
                local = shares[: len(rows)].reshape(-1, 3)
                if (local[:, 2] < 0.0).any():
                    # No contact pulls.
                    fits *= PULLING
                if fits > best[0] or not best[1]:
                    world = np.einsum("kij,kj->ki", axes, local)
                    best = fits, chosen, world
            if best[0] >= UNEXPLAINED:
                break
        probability, chosen, impulses = best
        names = tuple(self._names[k] for k in chosen)
        return names, gaps[list(chosen)], impulses, probability

    def mass_of(self, q: np.ndarray) -> np.ndarray:
        """Return (nv, nv) M at q."""
        return self._flat.model.core.mass_matrix(q).reshape(self.nv, self.nv)

    def _blocks(self, q: np.ndarray, order: list[int]) -> dict[int, Block]:
        """Return rows and axes of each contact, and under ``HELD`` the rows of the constraints."""
        found = {k: self._jacobian(q, (k,)) for k in order}
        found[HELD] = self._held(q), np.zeros((0, 3, 3))
        return found

    def mass_and_rows(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return M, the rows of all contacts and constraints, and the contacts' normal rows."""
        mass = self.mass_of(q)
        rows, _ = self._jacobian(q, tuple(range(len(self._names))))
        normals = rows[2::3] if len(rows) == 3 * len(self._names) else rows
        return mass, np.vstack([rows, self._held(q)]), normals

    def _jacobian(self, q: np.ndarray, chosen: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Return (3 k, nv) rows and (k, 3, 3) axes of contacts; a stop's row as the normal."""
        only = [k in chosen for k in range(len(self._names))]
        found = self._flat.rows(q, np.zeros(self._model.nv), only=only)
        touches = self._nearest_points(touches_of(found, self._flat, self._far))
        if not touches:
            return np.zeros((0, self._model.nv)), np.zeros((0, 3, 3))
        rows = np.vstack([touch.jacobian for touch in touches])
        axes = np.array([np.eye(3) if t.axes is None else t.axes for t in touches])
        return rows, axes

    def _nearest_points(self, touches: Iterable[Touch]) -> list[Touch]:
        """Return the nearest points of bodies that collide, however far apart: noise parts them."""
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
        """Return (m, nv) rows of the constraints."""
        return self._flat.rows(q, np.zeros(self._model.nv)).A.reshape(-1, self._model.nv)


class _Spread:
    """The covariance of M Δv − JᵀP, for one set of contacts after another.

    The change with q is half the difference between one deviation ahead and one behind along each
    axis of q's covariance: where the nearest point jumps it is no larger than what noise does.
    """

    def __init__(
        self,
        closing: ClosingContacts,
        q: np.ndarray,
        jump: np.ndarray,
        covariance: np.ndarray,
        here: dict[int, Block],
    ) -> None:
        order = [k for k in here if k != HELD]
        model, nv = closing._model, len(jump)
        values, axes = np.linalg.eigh(covariance[:nv, :nv])
        kept = values > SINGULAR * max(float(values.max()), 0.0)
        steps = axes[:, kept] * np.sqrt(values[kept])
        # From what changes along each step, in units of it, to what changes with δq.
        back = (axes[:, kept] / np.sqrt(values[kept])).T
        mass = np.zeros((nv, len(back)))
        rows = {k: np.zeros((*block[0].shape, len(back))) for k, block in here.items()}
        for k, step in enumerate(steps.T):
            ahead, behind = pin.integrate(model, q, step), pin.integrate(model, q, -step)
            mass[:, k] = 0.5 * (closing.mass_of(ahead) - closing.mass_of(behind)) @ jump
            first, last = (closing._blocks(place, order) for place in (ahead, behind))
            for each, change in rows.items():
                # A face that tips over gains or loses points: no derivative.
                if len(first[each][0]) == len(last[each][0]) == len(change):
                    change[:, :, k] = 0.5 * (first[each][0] - last[each][0])
        self._of_mass = mass @ back
        self._of_rows = {each: change @ back for each, change in rows.items()}
        self._mass, self._covariance = closing.mass_of(q), covariance

    def of(self, chosen: tuple[int, ...], shares: np.ndarray) -> np.ndarray:
        """Return (nv, nv), for impulses ``shares`` of the contacts' rows and the constraints'."""
        changes = np.concatenate([self._of_rows[each] for each in (*chosen, HELD)])
        change = self._of_mass - np.tensordot(shares, changes, axes=1)
        both = np.hstack([change, self._mass])
        return np.asarray(both @ self._covariance @ both.T)


def _stacked(blocks: list[Block], nv: int) -> Block:
    """Return rows (n, nv) and axes of several contacts under each other."""
    if not blocks:
        return np.zeros((0, nv)), np.zeros((0, 3, 3))
    return np.vstack([rows for rows, _ in blocks]), np.concatenate([axes for _, axes in blocks])
