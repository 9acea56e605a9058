"""Kinks of one-sided springs: steps end where such a spring begins or ceases to act.

Forces are smooth while the same springs act. A spring is out of its zone (OUT), acts (ACTS), or is
in its zone but slack (SLACK), since its damper outweighs it. It changes where its strain, a smooth
gap with a rate (``zeros.closing``), or its force comes to zero.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..forces.laws import ACTS, BETWEEN, BEYOND, LIMITED, ON, OUT, SLACK, Loads, push_of
from ..tree.memory import Memory
from ..zeros.closing import Node
from ..zeros.roots import States, falling_root, first_zero
from ..zeros.windows import Turning
from .kink import PART, Kink, with_rate

__all__ = ["SpringKinks"]


class Push(NamedTuple):
    """State of a one-sided spring; see ``push_of``."""

    zone: float
    rate: float
    force: float


class _Spring(NamedTuple):
    """A one-sided spring.

    Attributes:
        kink: its number among the kinks. numbers: its row, with its state.
        is_damped: whether it has a damper.
        beyond: force below which it counts as zero [N, N m].
    """

    kink: int
    numbers: np.ndarray
    is_damped: bool
    beyond: float


class SpringKinks:
    """The one-sided springs of a motion: whether they act now, and when that changes."""

    def __init__(self, loads: Loads, model: pin.Model) -> None:
        self._loads, self._model = loads, model
        self._springs: list[_Spring] = []
        for k, (kind, row) in enumerate(loads.kinks.tolist()):
            if kind == LIMITED:
                continue
            numbers = loads.between[row] if kind == BETWEEN else loads.in_joints[row]
            stiffness, damping = numbers[6:8] if kind == BETWEEN else numbers[:2]
            beyond = float(BEYOND * (stiffness + damping))
            self._springs.append(_Spring(k, numbers, bool(damping > 0.0), beyond))
        if self._springs:
            self._memory, self._turning = Memory(model), Turning(model)

    def __bool__(self) -> bool:
        return bool(self._springs)

    def begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Set all springs for the state at which a motion begins."""
        if not self._springs:
            return
        for i, push in enumerate(self._pushes(q, v)):
            self._change(i, self._inside(i, push) if push.zone > 0.0 else OUT)

    def heed_jump(self, q: np.ndarray, v: np.ndarray) -> None:
        """After a jump of the velocity: dampers may begin or cease to outweigh springs."""
        if not any(spring.is_damped for spring in self._springs):
            return
        for i, push in enumerate(self._pushes(q, v)):
            if self._does[i] != OUT:
                self._change(i, self._inside(i, push))

    @property
    def _does(self) -> list[int]:
        return [int(spring.numbers[ON]) for spring in self._springs]

    def _change(self, spring: int, becomes: int) -> None:
        self._springs[spring].numbers[ON] = becomes

    def first(self, states: States, start: float, end: float) -> Kink | None:
        """The first kink within a step, if there is one.

        Args:
            states: (q, v) at a time within the step.
            start, end: of the step [s].
        """
        if not self._springs or not end > start:
            return None
        times = self._turning.nodes(states, start, end)
        seen = np.array([self._pushes(*states(t)) for t in times])
        signs = np.array([-1.0 if does == OUT else 1.0 for does in self._does])
        zones, rates = signs * seen[:, :, 0] + BEYOND, signs * seen[:, :, 1]

        def node(i: int, t: float) -> Node:
            return Node(t, *self._zone(i, float(signs[i]), t, states))

        t, i = first_zero(np.array(times), zones, rates, node, lambda i, size: BEYOND)
        found = None if i < 0 else self._by_zone(i, float(signs[i]), t, states)
        for k, (left, right) in enumerate(pairwise(times)):
            if found is not None and found.t <= left:
                break
            for i, does in enumerate(self._does):
                sign = 1.0 if does == ACTS else -1.0
                beyond = self._springs[i].beyond
                if does == OUT or not self._springs[i].is_damped:
                    continue
                if sign * seen[k + 1, i, 2] + beyond <= 0.0:
                    kink = self._by_force(i, sign, states, left, right)
                    found = kink if found is None or kink.t < found.t else found
        return found

    def _zone(self, i: int, sign: float, t: float, states: States) -> tuple[float, float]:
        """What falls to zero where a spring comes into its zone or out of it, and its rate."""
        push = self._pushes(*states(t))[i]
        return sign * push.zone + BEYOND, sign * push.rate

    def _by_zone(self, i: int, sign: float, t: float, states: States) -> Kink:
        """A spring comes into its zone, or out of it, at a time [s]."""
        enters = self._does[i] == OUT
        becomes = self._inside(i, self._pushes(*states(t))[i]) if enters else OUT
        return Kink(t, partial(self._change, i, becomes), partial(self._zone, i, sign))

    def _by_force(self, i: int, sign: float, states: States, start: float, end: float) -> Kink:
        """Where a damper begins or ceases to outweigh its spring."""
        beyond = self._springs[i].beyond

        def force(t: float, states: States = states) -> float:
            return sign * self._pushes(*states(t))[i].force + beyond

        t, becomes = falling_root(force, start, end), SLACK if sign > 0.0 else ACTS
        return Kink(t, partial(self._change, i, becomes), with_rate(force, PART * (end - start)))

    def _inside(self, i: int, push: Push) -> int:
        """SLACK or ACTS, for a spring in its zone."""
        return SLACK if self._springs[i].is_damped and push.force < 0.0 else ACTS

    def _pushes(self, q: np.ndarray, v: np.ndarray) -> list[Push]:
        memory = self._memory
        pin.forwardKinematics(self._model, memory.data, q, v)
        shown = memory.places, memory.speeds, q, v
        return [Push(*push_of(self._loads, spring.kink, *shown)) for spring in self._springs]
