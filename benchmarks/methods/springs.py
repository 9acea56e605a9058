"""Contacts as springs: what a penalty method puts in the place of an impulse.

Each point on its plane has a spring of stiffness k while it is pressed in and of k/e² while it
comes out (Walton & Braun 1986), so the work regained is e² of the work spent, which is Stronge's
restitution; a contact with e = 0 lets go at its deepest. Friction opposes the slip at every
instant, −µ F_n u_t/√(u_t² + ε²), rounded off below the creep speed ε (Coulomb and Routh as ε → 0).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .mechanism import Mechanism, Touch

__all__ = ["PressedContact", "Pressing", "Springs"]


class Pressing(enum.Enum):
    """What a contact is at."""

    FREE = 0
    COMPRESSION = 1
    RELEASE = 2


@dataclass
class PressedContact:
    """One contact and what it remembers.

    Attributes:
        touch: which.
        local_normal, local_origin: of the plane, in the axes of the body that carries it.
        print: the depth at which it starts to push [m].
        deepest: where its release began [m].
        at: its phase.
        depth, speed: of the state last asked for, inwards [m, m/s].
    """

    touch: Touch
    local_normal: np.ndarray
    local_origin: np.ndarray
    print: float = 0.0
    deepest: float = 0.0
    at: Pressing = Pressing.FREE
    depth: float = 0.0
    speed: float = 0.0


class Springs:
    """The contacts of a mechanism, pressed and released.

    Args:
        model: without gravity.
        mechanism: its touching points.
        stiffness: k [N/m].
        creep: ε [m/s].
        slack: how far a contact that lies at its print has to go in before it is pressed [m].
    """

    def __init__(
        self,
        model: pin.Model,
        mechanism: Mechanism,
        stiffness: float,
        creep: float,
        slack: float = 0.0,
    ) -> None:
        self.model, self.data = model, model.createData()
        self.stiffness, self.creep, self.slack = stiffness, creep, slack
        self.contacts = []
        for touch in mechanism.touches:
            world = touch.other < 0
            turn = np.eye(3) if world else mechanism.rotations[touch.other].T
            start = np.zeros(3) if world else mechanism.places[touch.other]
            self.contacts.append(
                PressedContact(touch, turn @ touch.normal, turn @ (touch.place - start))
            )
        self._rest = np.zeros(model.nv)
        self._forces = pin.StdVec_Force()
        for _ in range(model.njoints):
            self._forces.append(pin.Force.Zero())
        self._loaded = {c.touch.body + 1 for c in self.contacts}
        self._loaded |= {c.touch.other + 1 for c in self.contacts} - {0}

    def acceleration(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) [m/s², rad/s²]; depths and speeds of the contacts are left in them."""
        model, data, forces = self.model, self.data, self._forces
        pin.forwardKinematics(model, data, q, v)
        wrenches = {joint: np.zeros(6) for joint in self._loaded}
        for contact in self.contacts:
            touch = contact.touch
            pose = data.oMi[touch.body + 1]
            place = pose.act(touch.at)
            slip = _speed(pose, data.v[touch.body + 1], touch.at)
            normal, origin = contact.local_normal, contact.local_origin
            if touch.other >= 0:
                carrier = data.oMi[touch.other + 1]
                normal, origin = carrier.rotation @ normal, carrier.act(origin)
                slip = slip - _speed(carrier, data.v[touch.other + 1], carrier.actInv(place))
            contact.depth = float(normal.dot(origin - place))
            contact.speed = -float(normal.dot(slip))
            push = self.push(contact)
            if push == 0.0:
                continue
            force = push * normal
            if touch.friction:
                along = slip + contact.speed * normal
                force -= touch.friction * push / np.sqrt(along.dot(along) + self.creep**2) * along
            turning = _cross(place, force)
            for joint, sign in ((touch.body + 1, 1.0), (touch.other + 1, -1.0)):
                if joint:
                    wrenches[joint][:3] += sign * force
                    wrenches[joint][3:] += sign * turning
        for joint, wrench in wrenches.items():
            forces[joint] = data.oMi[joint].actInv(pin.Force(wrench))
        return pin.aba(model, data, q, v, self._rest, forces).copy()

    def push(self, contact: PressedContact) -> float:
        """The normal force [N]."""
        if contact.at is Pressing.COMPRESSION:
            return max(0.0, self.stiffness * (contact.depth - contact.print))
        if contact.at is Pressing.RELEASE:
            e = contact.touch.restitution
            return max(0.0, self.stiffness / e**2 * (contact.depth - self.let_go(contact)))
        return 0.0

    def let_go(self, contact: PressedContact) -> float:
        """The depth at which a release ends: the print it leaves [m]."""
        e = contact.touch.restitution
        return contact.deepest - e * e * (contact.deepest - contact.print)

    def press(self, contact: PressedContact) -> None:
        """It is pressed in, or goes on being so."""
        contact.at = Pressing.COMPRESSION

    def turn(self, contact: PressedContact) -> None:
        """It has reached its deepest point."""
        contact.deepest = contact.depth
        contact.at = Pressing.RELEASE
        if contact.touch.restitution == 0.0:
            self.free(contact)

    def free(self, contact: PressedContact) -> None:
        """It pushes no more; its print stays."""
        contact.print = contact.deepest = contact.depth
        contact.at = Pressing.FREE

    def next_phase(self, contact: PressedContact) -> None:
        """What follows where ``margin`` has run out."""
        if contact.at is Pressing.COMPRESSION:
            self.turn(contact)
        elif contact.at is Pressing.RELEASE:
            self.free(contact)
        else:
            self.press(contact)

    def margin(self, contact: PressedContact) -> float:
        """What is zero where the phase ends; a free contact's rises to it, others' fall."""
        if contact.at is Pressing.COMPRESSION:
            return contact.speed
        if contact.at is Pressing.RELEASE:
            return contact.depth - self.let_go(contact)
        return contact.depth - contact.print - self.slack

    def pass_on(self) -> None:
        """Take every contact whose phase has ended to its next."""
        for contact in self.contacts:
            margin = self.margin(contact)
            if contact.at is Pressing.FREE:
                ended = margin > 0.0 and contact.speed > 0.0
            else:
                ended = margin <= 0.0
            if ended:
                self.next_phase(contact)

    def is_over(self, slow: float) -> bool:
        """Whether nothing pushes, and nothing approaches faster than ``slow`` [m/s]."""
        return all(c.at is Pressing.FREE and c.speed <= slow for c in self.contacts)


def _speed(pose: pin.SE3, velocity: pin.Motion, at: np.ndarray) -> np.ndarray:
    """(3,) of a body's point, in the world."""
    return pose.rotation @ (velocity.linear + _cross(velocity.angular, at))


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    a0, a1, a2 = a.tolist()
    b0, b1, b2 = b.tolist()
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])
