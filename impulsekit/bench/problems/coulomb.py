"""Newton's and Coulomb's laws at several contacts in 50 digits, found and then proved.

The modes of the contacts (parted, sticking, sliding) are guessed from the answer in doubles;
Newton's iteration in long numbers solves for them; and the law's own inequalities are then
checked in long numbers, so that nothing of the guess has to be believed. ξ = u⁺ + e∘min(u⁻, 0)
obeys 0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n and P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0 (Moreau 1988).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...checking.demands import known_impulses
from ...checking.system import ReferenceRobot
from ...impact import solve
from ...reference.arithmetic import Arithmetic
from ...reference.rows import point_velocity_rows
from ...reference.tree import WORLD
from ...scene import Contact, Law, Scene

__all__ = ["velocity_after_contacts"]

# Against redundant contacts: moves only what no velocity notices, and less at every step.
RIDGE = "1e-20"
MOST_STEPS = 12
# What is left of the law, relative to the velocities.
PROVED = "1e-40"
# Of the answer in doubles: slips slower than this are none.
AT_REST = 1e-8


def velocity_after_contacts(
    reference: ReferenceRobot, scene: Scene, q: np.ndarray, v: np.ndarray
) -> Any:
    """(nv,) v⁺ in long numbers.

    Raises:
        ArithmeticError: the iteration does not converge, or the law does not hold.
    """
    if scene.constraints or scene.law != Law():
        raise ArithmeticError("contacts in long numbers: Newton's law alone, without constraints")
    system, numbers = reference.system, reference.system.arithmetic
    before = numbers.array(v)
    known = known_impulses(reference, scene.impulses)
    at = system.kinematics(q)
    rows = np.concatenate([_rows(reference, at, entry) for entry in scene.contacts])
    impulse = system.generalized_impulse(q, known.loads, known.in_joints)
    columns = np.concatenate([rows.T, impulse[:, None]], axis=1)
    moved = numbers.solve_symmetric(system.generalized_masses(q), columns, _singular)
    free = before + moved[:, -1]
    approach = rows @ before
    shifted = rows @ free
    for i, entry in enumerate(scene.contacts):
        shifted[3 * i + 2] += numbers.number(entry.restitution) * min(approach[3 * i + 2], 0)
    friction = [getattr(entry, "friction", 0.0) for entry in scene.contacts]
    law = _Law(numbers, rows @ moved[:, :-1], shifted, friction)
    found = solve(scene, q, v)
    if found.outcome is None or found.outcome.contacts is None:
        raise ArithmeticError("no contact touches")
    return free + moved[:, :-1] @ law.solved(found.outcome.contacts.impulse)


def _rows(reference: ReferenceRobot, at: Any, entry: Any) -> Any:
    """(3, nv) velocity of the contact's point along t₁, t₂, n of its plane in the world."""
    if not isinstance(entry, Contact) or entry.against != "world":
        raise ArithmeticError("contacts in long numbers: points on planes of the world alone")
    tree = reference.system.tree
    numbers = tree.arithmetic
    link = reference.link(entry.frame)
    body = tree.body_of_link(link)
    place = numbers.array(entry.at)
    if body != WORLD:
        place = at.origins[body] + at.rotations[body] @ place
    normal = numbers.array(entry.normal)
    normal = normal / numbers.norm(normal)
    first = numbers.zeros(3)
    first[int(np.argmin(np.abs(np.array(entry.normal))))] = numbers.number(1)
    first = first - normal * (normal @ first)
    first = first / numbers.norm(first)
    axes = np.array([first, np.cross(normal, first), normal])
    rows = point_velocity_rows(tree, at, link, "world", entry.at, place, axes)
    return rows.matrix(numbers, at.linear, at.angular)


class _Law:
    """W P + b under Coulomb's law, in long numbers."""

    def __init__(self, numbers: Arithmetic, delassus: Any, shifted: Any, friction: Any) -> None:
        self.numbers, self.delassus, self.shifted = numbers, delassus, shifted
        self.friction = [numbers.number(mu) for mu in friction]
        self.scale = max(abs(u) for u in shifted)

    def solved(self, guess: np.ndarray) -> Any:
        """(3n,) P near an impulse in doubles.

        Raises:
            ArithmeticError: not converged, or not proved.
        """
        slip = self.delassus.astype(float) @ guess + self.shifted.astype(float)
        modes, start = self._modes(guess.reshape(-1, 3), slip.reshape(-1, 3))
        numbers = self.numbers
        x = numbers.array(start)
        for _ in range(MOST_STEPS):
            impulse, way = self._spread(x, modes)
            residual, slope = self._equations(x, modes, impulse, way)
            if not len(x):
                break
            normal = slope.T @ slope
            size = max(normal[i, i] for i in range(len(x)))
            for i in range(len(x)):
                normal[i, i] += numbers.number(RIDGE) * size
            step = numbers.solve_symmetric(normal, slope.T @ residual, _singular)
            x = x - step
            if max(abs(r) for r in residual) <= numbers.number("1e-48") * self.scale:
                break
        impulse, _ = self._spread(x, modes)
        self._prove(impulse)
        return impulse

    def _modes(self, impulse: np.ndarray, slip: np.ndarray) -> tuple[list[str], list[float]]:
        modes: list[str] = []
        start: list[float] = []
        scale = float(self.scale)
        for p, u, mu in zip(impulse, slip, self.friction, strict=True):
            if p[2] <= 0.0:
                modes.append("parted")
            elif mu == 0:
                modes.append("smooth")
                start.append(p[2])
            elif np.hypot(u[0], u[1]) < AT_REST * scale:
                modes.append("sticking")
                start.extend(p)
            else:
                modes.append("sliding")
                start.extend([p[2], np.arctan2(u[1], u[0])])
        return modes, start

    def _spread(self, x: Any, modes: list[str]) -> tuple[Any, Any]:
        """P (3n,) of the unknowns, and ∂P/∂x."""
        numbers = self.numbers
        impulse = numbers.zeros(3 * len(modes))
        way = numbers.zeros(3 * len(modes), len(x))
        k = 0
        for i, mode in enumerate(modes):
            t1, t2, n, mu = 3 * i, 3 * i + 1, 3 * i + 2, self.friction[i]
            if mode == "sticking":
                impulse[t1 : n + 1] = x[k : k + 3]
                way[t1 : n + 1, k : k + 3] = numbers.eye(3)
                k += 3
            elif mode == "smooth":
                impulse[n], way[n, k] = x[k], numbers.number(1)
                k += 1
            elif mode == "sliding":
                c, s = numbers.cos(x[k + 1]), numbers.sin(x[k + 1])
                impulse[n], way[n, k] = x[k], numbers.number(1)
                impulse[t1], impulse[t2] = -mu * x[k] * c, -mu * x[k] * s
                way[t1, k], way[t2, k] = -mu * c, -mu * s
                way[t1, k + 1], way[t2, k + 1] = mu * x[k] * s, -mu * x[k] * c
                k += 2
        return impulse, way

    def _equations(self, x: Any, modes: list[str], impulse: Any, way: Any) -> tuple[Any, Any]:
        """What each mode demands of ξ, and its slope."""
        u = self.delassus @ impulse + self.shifted
        by_x = self.delassus @ way
        residual: list[Any] = []
        slope: list[Any] = []
        k = 0
        for i, mode in enumerate(modes):
            t1, t2, n = 3 * i, 3 * i + 1, 3 * i + 2
            if mode == "sticking":
                residual += [u[t1], u[t2], u[n]]
                slope += [by_x[t1], by_x[t2], by_x[n]]
                k += 3
            elif mode == "smooth":
                residual.append(u[n])
                slope.append(by_x[n])
                k += 1
            elif mode == "sliding":
                c, s = self.numbers.cos(x[k + 1]), self.numbers.sin(x[k + 1])
                across = s * by_x[t1] - c * by_x[t2]
                across[k + 1] += c * u[t1] + s * u[t2]
                residual += [u[n], s * u[t1] - c * u[t2]]
                slope += [by_x[n], across]
                k += 2
        return np.array(residual, dtype=object), np.array(slope, dtype=object)

    def _prove(self, impulse: Any) -> None:
        numbers = self.numbers
        u = self.delassus @ impulse + self.shifted
        tiny = numbers.number(PROVED)
        small_u, small_p = tiny * self.scale, tiny * max(abs(p) for p in impulse)
        for i, mu in enumerate(self.friction):
            p, xi = impulse[3 * i : 3 * i + 3], u[3 * i : 3 * i + 3]
            push, along = numbers.norm(p[:2]), numbers.norm(xi[:2])
            holds = p[2] >= 0 and xi[2] >= -small_u and push <= mu * p[2] + small_p
            if p[2] > 0:
                holds = holds and abs(xi[2]) <= small_u
            if mu > 0 and p[2] > 0 and along > small_u:
                against = p[:2] + mu * p[2] * xi[:2] / along
                holds = holds and numbers.norm(against) <= small_p
            if not holds:
                raise ArithmeticError(f"contact {i}: the law does not hold in long numbers")


def _singular(index: int) -> Exception:
    return ArithmeticError(f"singular at {index}")
