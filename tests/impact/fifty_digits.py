"""Impacts in 50 digits by Kane's equations, in modes that are given, near a state.

The configuration is changed on its tangent, in every kind of joint a URDF knows.
"""

from __future__ import annotations

import numpy as np

import impulsekit as ik
from impulsekit.checking.demands import constraint_rows, known_impulses
from impulsekit.checking.system import reference_robot
from impulsekit.reference import Arithmetic, rotation
from impulsekit.reference.rows import point_velocity_rows, speed_rows
from impulsekit.reference.tree import WORLD

STEP = "1e-15"


class PreciseImpact:
    """The impact of a scene near a solved one.

    ``at`` gives v⁺ (nv,), λ (m,) and the impulses of contacts (3,) in world axes, each as
    one long vector of mpmath's numbers.
    """

    def __init__(self, impact, digits=50):
        self.impact, self.scene = impact, impact.scene
        self.reference = reference_robot(self.scene.robot, Arithmetic.precise(digits))
        self.tree = self.reference.system
        self.numbers = self.tree.arithmetic
        self.nv = self.scene.robot.nv
        self._masses = {}
        self.v = self.numbers.array(impact.v_before)
        self.q = self.numbers.array(impact.q)
        base = self.reference.system.kinematics(self.q)
        self.touching = []
        outcome = impact.outcome
        if outcome is not None and outcome.contacts is not None:
            triples = outcome.contacts.impulse.reshape(-1, 3)
            for touch, impulse in zip(outcome.touches, triples, strict=True):
                own = touch.axes
                if own is not None and not isinstance(
                    self.scene.contacts[touch.entry], ik.Collision
                ):
                    entry = self.scene.contacts[touch.entry]
                    body = self.tree.body_of_link(self.reference.link(entry.against))
                    own = self.numbers.array(own)
                    if body != WORLD:
                        own = base.rotations[body].T @ own
                self.touching.append((touch, own, impulse))

    # -- the state nearby ---------------------------------------------------------

    def retracted(self, j, step):
        """q moved by ``step`` along the j-th direction of v."""
        q, numbers = self.q.copy(), self.numbers
        cosine, sine = numbers.cos(step), numbers.sin(step)
        for body in self.tree.bodies:
            joint = body.joint
            if joint.mimics or not joint.first_speed <= j < joint.speeds.stop:
                continue
            c, k = joint.first_coordinate, j - joint.first_speed
            if joint.kind in ("revolute", "prismatic"):
                q[c] += step
            elif joint.kind == "continuous":
                q[c : c + 2] = _turned(q[c], q[c + 1], cosine, sine)
            elif joint.kind == "planar":
                if k == 2:
                    q[c + 2 : c + 4] = _turned(q[c + 2], q[c + 3], cosine, sine)
                else:
                    along = (q[c + 2], q[c + 3]) if k == 0 else (-q[c + 3], q[c + 2])
                    q[c] += step * along[0]
                    q[c + 1] += step * along[1]
            elif k < 3:
                q[c : c + 3] += step * rotation.of_quaternion(q[c + 3 : c + 7], numbers)[:, k]
            else:
                half = numbers.zeros(4)
                half[k - 3], half[3] = numbers.sin(step / 2), numbers.cos(step / 2)
                q[c + 3 : c + 7] = _product(q[c + 3 : c + 7], half)
        return q

    # -- the impact there -----------------------------------------------------------

    def at(self, q=None, dv=None, blow=None, de=None, dmu=None):
        """v⁺, λ and P at a state nearby.

        Args:
            q: (nq,) configuration. dv: (nv,) added to v⁻.
            blow: (name, (k,)) added to one impulse of the scene.
            de, dmu: (index, change) of one contact's coefficient.
        """
        numbers, system = self.numbers, self.reference.system
        moved = q is not None
        q = self.q if q is None else q
        v = self.v if dv is None else self.v + dv
        known = known_impulses(self.reference, self._impulses(blow))
        key = None if moved else "here"
        if key in self._masses:
            at, masses = self._masses[key]
        else:
            at = system.kinematics(q)
            masses = system.generalized_masses(q)
            self._masses[key] = (at, masses)
            if moved:
                del self._masses[key]
        demands = constraint_rows(self.reference, at, v, self.scene.constraints)
        if not self.touching:
            found = system.impact(q, v, known.loads, known.in_joints, demands)
            return np.concatenate([found.y_after, found.row_impulses])
        impulse = system.generalized_impulse(q, known.loads, known.in_joints)
        bilateral = demands.matrix(numbers, at.linear, at.angular) + demands.speeds
        rows, axes = [bilateral], []
        for touch, own, _ in self.touching:
            matrix, turned = self._contact_rows(at, touch, own)
            rows.append(matrix)
            axes.append(turned)
        rows = np.concatenate(rows)
        e, mu, e_t = self._coefficients(rows, v, len(bilateral), de, dmu)
        law = self.scene.law
        if law.order == "sequential":
            start = (masses, bilateral, impulse, v, demands.target)
            p, after = self._sequence(*start, rows[len(bilateral) :], e, mu, e_t)
        elif law.restitution == "newton":
            shift = self.shift(rows, v, len(bilateral), e, e_t)
            p, after = self._stage(masses, rows, impulse, v, demands.target, shift, mu, None)
        else:
            none = numbers.zeros(len(rows) - len(bilateral))
            first, v_c = self._stage(masses, rows, impulse, v, demands.target, none, mu, "c")
            floor = e * first[len(bilateral) + 2 :: 3]
            kept = bilateral @ v_c
            second, after = self._stage(masses, rows, impulse * 0, v_c, kept, none, mu, floor)
            p = first + second
        out = [after, p[: len(bilateral)]]
        for i, turned in enumerate(axes):
            own = p[len(bilateral) + 3 * i : len(bilateral) + 3 * i + 3]
            sign = self.touching[i][0].jacobian[2].sum()
            out.append(own[2:] * float(sign) if turned is None else turned @ own)
        return np.concatenate(out)

    def _impulses(self, blow):
        if blow is None:
            return self.scene.impulses
        name, change = blow
        changed = []
        for own, entry in zip(self.scene.entry_names("impulses"), self.scene.impulses, strict=True):
            if own == name:
                entry = _Changed(entry, self.numbers, change)
            changed.append(entry)
        return changed

    def _contact_rows(self, at, touch, own):
        tree, numbers = self.tree, self.numbers
        entry = self.scene.contacts[touch.entry]
        if own is None:
            matrix = numbers.zeros(3, self.nv)
            sign = touch.jacobian[2].sum()
            matrix[2, tree.joint(self.reference.joint(entry.joint)).first_speed] = sign
            return speed_rows(tree, matrix).speeds, None
        if isinstance(entry, ik.Collision):
            return self._meeting_rows(at, entry)
        link, other = self.reference.link(entry.frame), self.reference.link(entry.against)
        first, second = tree.body_of_link(link), tree.body_of_link(other)
        place = numbers.array(entry.at)
        if first != WORLD:
            place = at.origins[first] + at.rotations[first] @ place
        axes, there = own, place
        if second != WORLD:
            axes = at.rotations[second] @ own
            there = at.rotations[second].T @ (place - at.origins[second])
        rows = point_velocity_rows(tree, at, link, other, entry.at, there, axes.T)
        return rows.matrix(numbers, at.linear, at.angular), axes

    def _meeting_rows(self, at, entry):
        """Rows of a ball against a ball, or against the face of a box it lies over."""
        tree, numbers = self.tree, self.numbers
        links = [self.reference.link(name) for name in (entry.first, entry.other)]
        bodies = [tree.body_of_link(link) for link in links]
        pieces = [self._piece(at, *both) for both in zip(links, bodies, strict=True)]
        (c, ra, Ra, half_a), (d, rb, Rb, half_b) = pieces
        if half_a is None and half_b is None:
            n = c - d
            n = n / numbers.sqrt(n @ n)
            place = (c - ra * n + d + rb * n) / 2
        else:
            sign, ball, r, box, R, half = (
                (1, c, ra, d, Rb, half_b) if half_a is None else (-1, d, rb, c, Ra, half_a)
            )
            own = R.T @ (ball - box)
            k = int(np.argmax(np.abs(own.astype(float)) - half.astype(float)))
            up = R[:, k] * int(np.sign(float(own[k])))
            height = abs(own[k]) - half[k]
            place = ball - up * (r + height) / 2
            n = up * sign
        k = int(np.argmin(np.abs(n.astype(float))))
        first = -n * n[k]
        first[k] += 1
        first = first / numbers.sqrt(first @ first)
        axes = np.array([first, np.cross(n, first), n]).T
        there = [
            place if body == WORLD else at.rotations[body].T @ (place - at.origins[body])
            for body in bodies
        ]
        rows = point_velocity_rows(tree, at, *links, *there, axes.T)
        return rows.matrix(numbers, at.linear, at.angular), axes

    def _piece(self, at, link, body):
        """Centre, radius, axes and half sides of a link's only geometry."""
        numbers = self.numbers
        item = next(
            item
            for item in self.scene.robot.collision_model.geometryObjects
            if self.tree.body_of_link(
                self.reference.link(self.scene.robot.model.frames[item.parentFrame].name)
            )
            == body
        )
        place = numbers.array(item.placement.translation)
        turn = numbers.array(item.placement.rotation)
        if body != WORLD:
            place = at.origins[body] + at.rotations[body] @ place
            turn = at.rotations[body] @ turn
        box = hasattr(item.geometry, "halfSide")
        half = numbers.array(np.array(item.geometry.halfSide).reshape(3)) if box else None
        return place, 0 if box else numbers.number(item.geometry.radius), turn, half

    def _restitution_at(self, value, speed):
        """e at an approach speed, which is negative for what parts."""
        numbers = self.numbers
        if not isinstance(value, ik.RestitutionTable):
            return numbers.number(value)
        if speed <= value.speeds[0]:
            return numbers.number(value.values[0])
        if speed >= value.speeds[-1]:
            return numbers.number(value.values[-1])
        k = np.searchsorted(value.speeds, float(speed)) - 1
        slope = numbers.number(value.values[k + 1] - value.values[k])
        slope = slope / numbers.number(value.speeds[k + 1] - value.speeds[k])
        return value.values[k] + slope * (speed - value.speeds[k])

    def _coefficients(self, rows, v, count, de, dmu):
        numbers = self.numbers
        before = rows @ v
        e, mu, e_t = (numbers.zeros(len(self.touching)) for _ in range(3))
        for i, (touch, _, _) in enumerate(self.touching):
            entry = self.scene.contacts[touch.entry]
            speed = -before[count + 3 * i + 2]
            value = entry.restitution
            e[i] = self._restitution_at(value, speed)
            mu[i] = numbers.number(getattr(entry, "friction", 0.0))
            e_t[i] = numbers.number(getattr(entry, "tangential_restitution", 0.0))
            if de is not None and de[0] == touch.entry:
                e[i] += de[1]
            if dmu is not None and dmu[0] == touch.entry:
                mu[i] += dmu[1]
        return e, mu, e_t

    def shift(self, rows, v, count, e, e_t):
        """(3n,) what Newton's law adds to u⁺."""
        before = (rows @ v)[count:]
        shift = self.numbers.zeros(len(before))
        shift[0::3], shift[1::3] = e_t * before[0::3], e_t * before[1::3]
        shift[2::3] = e * np.minimum(before[2::3], 0)
        return shift

    def _sequence(self, masses, bilateral, impulse, v, target, rows, e, mu, e_t):
        """p (r,) and v after of single hits, the largest |u_n|/√W_nn first."""
        numbers, count = self.numbers, len(bilateral)
        p = numbers.zeros(count + len(rows))
        still = numbers.zeros(0)
        share, v = self._stage(
            masses, bilateral, impulse, v, target, still, still, None, (np.zeros(count), [])
        )
        p[:count] += share
        scale = float(max(abs(x) for x in rows @ v))
        both = np.concatenate([bilateral, rows[2::3]])
        W = (both @ numbers.solve_symmetric(masses, both.T.copy(), _fail)).astype(float)
        A, B = W[:count, :count], W[:count, count:]
        weights = np.diag(W[count:, count:] - (B.T @ np.linalg.solve(A, B) if count else 0.0))
        for _ in range(1000):
            normals = (rows[2::3] @ v).astype(float)
            if normals.min() > -1e-10 * scale:
                return p, v
            i = int((normals / np.sqrt(weights)).argmin())
            own = rows[3 * i : 3 * i + 3]
            both = np.concatenate([bilateral, own])
            for part, change in self._single(masses, both, own, v, count, e[i], mu[i], e_t[i]):
                p[:count] += part[:count]
                p[count + 3 * i : count + 3 * i + 3] += part[count:]
                v = v + change
        raise ArithmeticError("no end")

    def _single(self, masses, both, own, v, count, e, mu, e_t):
        """(p, Δv) of one contact, for Poisson's law of compression and of expansion."""
        from impulsekit.laws.coulomb import coulomb, released

        numbers, impulse = self.numbers, self.numbers.zeros(self.nv)
        newton = self.scene.law.restitution == "newton"
        moved = numbers.solve_symmetric(masses, both.T.copy(), _fail)
        W = (both @ moved).astype(float)
        A, B = W[:count, :count], W[:count, count:]
        W = W[count:, count:] - (B.T @ np.linalg.solve(A, B) if count else 0.0)
        block = (W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2])
        friction, floor = float(mu), None
        for phase in range(1 if newton else 2):
            before = own @ v
            shift = numbers.zeros(3)
            if newton:
                shift[0], shift[1] = e_t * before[0], e_t * before[1]
                shift[2] = e * before[2]
            u = (before + shift).astype(float)
            size = float(np.abs(u).max())
            if phase == 0:
                P, _ = coulomb(block, *u, friction, size)
            else:
                P, _ = released(block, tuple(u), friction, float(floor[0]), size)
            P = np.array(P)
            λ = -np.linalg.solve(A, B @ P) if count else np.zeros(0)
            ξ = u + W @ P
            x, modes = self._begin(
                λ, [P], ξ[None], [friction], [0.0 if floor is None else floor[0]]
            )
            keep = both[:count] @ v
            part, after = self._stage(
                masses, both, impulse, v, keep, shift, [mu], floor, (x, modes)
            )
            yield part, after - v
            v, floor = after, [e * part[count + 2]]

    def _stage(self, masses, rows, impulse, v, target, shift, mu, floor, begin=None):
        """p (r,) and v after, by Newton's iteration on the modes of the double answer."""
        numbers = self.numbers
        count = len(target)
        start, modes = self._start(rows, shift, floor, count) if begin is None else begin
        x = numbers.array(start)
        columns = np.concatenate([rows.T, impulse[:, None]], axis=1)
        moved = numbers.solve_symmetric(masses, columns, _fail)
        delassus = rows @ moved[:, :-1]
        free = rows @ (v + moved[:, -1])
        for _ in range(7):
            p, way = self._spread(x, modes, mu, floor, count)
            u = free + delassus @ p
            u[count:] += shift
            residual, slope = [u[i] - target[i] for i in range(count)], []
            by_x = delassus @ way
            slope = [by_x[i] for i in range(count)]
            at = count
            for i, mode in enumerate(modes):
                a = count + 3 * i
                if mode == "parted":
                    continue
                if mode == "sticking":
                    for k in range(3):
                        residual.append(u[a + k])
                        slope.append(by_x[a + k])
                    at += 3
                    continue
                if mode == "held sticking":
                    for k in range(2):
                        residual.append(u[a + k])
                        slope.append(by_x[a + k])
                    at += 2
                    continue
                if mode in ("smooth", "sliding"):
                    residual.append(u[a + 2])
                    slope.append(by_x[a + 2])
                    at += 1
                if mode in ("sliding", "held sliding"):
                    c, s = numbers.cos(x[at]), numbers.sin(x[at])
                    residual.append(s * u[a] - c * u[a + 1])
                    row = s * by_x[a] - c * by_x[a + 1]
                    row[at] += c * u[a] + s * u[a + 1]
                    slope.append(row)
                    at += 1
            if not len(x):
                break
            x = x - numbers.solve_general(np.array(slope), np.array(residual), _fail)
        p, _ = self._spread(x, modes, mu, floor, count)
        return p, v + moved[:, -1] + moved[:, :-1] @ p

    def _start(self, rows, shift, floor, count):
        """Unknowns of the double answer, and modes by its numbers."""
        impact = self.impact
        outcome = impact.outcome
        λ, triples = outcome.constraint_impulses, [t[2] for t in self.touching]
        after = impact.v_after
        if floor is not None:
            pressed = self._plastic().solve(impact.q, impact.v_before)
            c_λ = pressed.outcome.constraint_impulses
            c_triples = pressed.outcome.contacts.impulse.reshape(-1, 3)
            if isinstance(floor, str):
                λ, triples, after = c_λ, list(c_triples), pressed.v_after
            else:
                λ = λ - c_λ if len(λ) else λ
                triples = [a - b for a, b in zip(triples, c_triples, strict=True)]
        u = rows.astype(float) @ after
        u[count:] += shift.astype(float)
        friction = [
            getattr(self.scene.contacts[t[0].entry], "friction", 0.0) for t in self.touching
        ]
        least = [0.0] * len(triples) if floor is None or isinstance(floor, str) else floor
        return self._begin(λ, triples, u[count:].reshape(-1, 3), friction, least)

    def _begin(self, λ, triples, velocities, friction, least):
        """Unknowns and modes of impulses and velocities in doubles."""
        x, modes = list(λ), []
        for P, ξ, mu, floor in zip(triples, velocities, friction, least, strict=True):
            held = float(floor) > 0.0 and ξ[2] > 1e-9
            if P[2] <= 0.0 and not held:
                modes.append("parted")
                continue
            word = "held " if held else ""
            angle = float(np.arctan2(ξ[1], ξ[0]))
            if mu == 0.0:
                modes.append("held" if held else "smooth")
                x += [] if held else [P[2]]
            elif np.hypot(*ξ[:2]) < 1e-8:
                modes.append(word + "sticking")
                x += list(P[:2]) if held else list(P)
            else:
                modes.append(word + "sliding")
                x += [angle] if held else [P[2], angle]
        return np.array(x, dtype=float), modes

    def _spread(self, x, modes, mu, floor, count):
        """p (r,) of the unknowns, and ∂p/∂x."""
        numbers = self.numbers
        p = numbers.zeros(count + 3 * len(modes))
        way = numbers.zeros(len(p), len(x))
        p[:count] = x[:count]
        way[:count, :count] = numbers.eye(count)
        at = count
        for i, mode in enumerate(modes):
            a = count + 3 * i
            n = a + 2
            if mode == "parted":
                continue
            if mode.startswith("held"):
                p[n] = floor[i]
            if mode == "sticking":
                p[a : a + 3] = x[at : at + 3]
                way[a : a + 3, at : at + 3] = numbers.eye(3)
                at += 3
            elif mode == "held sticking":
                p[a : a + 2] = x[at : at + 2]
                way[a : a + 2, at : at + 2] = numbers.eye(2)
                at += 2
            elif mode in ("smooth", "sliding"):
                p[n], way[n, at] = x[at], numbers.number(1)
                at += 1
            if mode in ("sliding", "held sliding"):
                c, s = numbers.cos(x[at]), numbers.sin(x[at])
                p[a], p[a + 1] = -mu[i] * p[n] * c, -mu[i] * p[n] * s
                way[a, at], way[a + 1, at] = mu[i] * p[n] * s, -mu[i] * p[n] * c
                if mode == "sliding":
                    way[a, at - 1], way[a + 1, at - 1] = -mu[i] * c, -mu[i] * s
                at += 1
        return p, way

    def _plastic(self):
        from impulsekit.impact.derivatives.workspace import workspace_of

        return workspace_of(self.scene).compression

    # -- central differences ----------------------------------------------------------

    def by_q(self):
        """(·, nv) derivatives of ``at`` by the configuration."""
        h = self.numbers.number(STEP)
        return self._differences(lambda j, step: self.at(q=self.retracted(j, step)), self.nv, h)

    def by_v(self):
        """(·, nv) derivatives by v⁻."""
        h = self.numbers.number(STEP)
        return self._differences(lambda j, step: self.at(dv=self._unit(j, step)), self.nv, h)

    def by_blow(self, name, size):
        """(·, size) derivatives by an impulse of the scene."""
        h = self.numbers.number(STEP)

        def value(j, step):
            return self.at(blow=(name, self._unit(j, step, size)))

        return self._differences(value, size, h)

    def by_coefficient(self, which, index):
        """(·,) derivatives by "de" or "dmu" of a contact."""
        h = self.numbers.number(STEP)
        both = [self.at(**{which: (index, step)}) for step in (h, -h)]
        return ((both[0] - both[1]) / (2 * h)).astype(float)

    def _unit(self, j, step, size=None):
        unit = self.numbers.zeros(self.nv if size is None else size)
        unit[j] = step
        return unit

    def _differences(self, value, count, h):
        columns = [(value(j, h) - value(j, -h)) / (2 * h) for j in range(count)]
        return np.array(columns).T.astype(float)


class _Changed:
    """An impulse of the scene with a small change, in long numbers."""

    def __new__(cls, entry, numbers, change):
        made = object.__new__(type(entry))
        for name, value in vars(entry).items():
            object.__setattr__(made, name, value)
        if isinstance(entry, ik.AppliedImpulse):
            object.__setattr__(made, "linear", numbers.array(entry.linear) + change[:3])
            object.__setattr__(made, "angular", numbers.array(entry.angular) + change[3:])
        else:
            own = np.atleast_1d(np.asarray(entry.impulse))
            object.__setattr__(made, "impulse", numbers.array(own) + change)
        return made


def _turned(cosine, sine, c, s):
    return np.array([cosine * c - sine * s, sine * c + cosine * s], dtype=object)


def _product(a, b):
    """The product of quaternions xyzw."""
    v = np.cross(a[:3], b[:3]) + a[3] * b[:3] + b[3] * a[:3]
    return np.array([*v, a[3] * b[3] - a[:3] @ b[:3]], dtype=object)


def _fail(index):
    return ArithmeticError(f"singular at {index}")
