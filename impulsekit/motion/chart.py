"""A chart of the configuration space around a point of it: q = q_ref ⊕ x, ẋ = J⁻¹(x) v.

Joints whose coordinates are plain numbers are charted by themselves: there x is q, and
ẋ is v. Only joints that turn in the plane or in space need more.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

__all__ = ["Chart"]

# Bound once: these run at every stage of every step.
_integrate, _d_difference, _AFTER = pin.integrate, pin.dDifference, pin.ArgumentPosition.ARG1


class Chart:
    """Tangent coordinates x (nv,) of configurations q (nq,) near a reference.

    Attributes:
        reference: (nq,) where x is zero for joints that turn; zero for the others.
        is_flat: whether x is q for every joint, so that there is nothing to re-centre.
    """

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        self.is_flat = model.nq == model.nv
        self.reference = np.zeros(model.nq)
        self._curved = _indices(model, lambda joint: joint.nq != joint.nv)
        # One continuous angle commutes with itself: its rate is the speed.
        turning = _indices(model, lambda joint: joint.nq != joint.nv and joint.nv > 1)
        self._turning_q, self._turning_v = turning
        self._turning = _alone(model)
        self._reference_turning = self.reference[self._turning_q]

    def centred(self, q: np.ndarray) -> np.ndarray:
        """(nv,) move the reference to q where joints turn; gives the x of q."""
        if self.is_flat:
            return q.copy()
        curved_q, curved_v = self._curved
        self.reference = np.zeros(self._model.nq)
        self.reference[curved_q] = q[curved_q]
        self._reference_turning = self.reference[self._turning_q]
        x = pin.difference(self._model, self.reference, q)
        x[curved_v] = 0.0
        return x

    def configuration(self, x: np.ndarray) -> np.ndarray:
        """(nq,) q = q_ref ⊕ x."""
        return x if self.is_flat else _integrate(self._model, self.reference, x)

    def rate(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) ẋ at q = q_ref ⊕ x with velocity v; x has to be within half a turn."""
        if self._turning is None:
            return v
        rate = v.copy()
        turn = _d_difference(self._turning, self._reference_turning, q[self._turning_q], _AFTER)
        rate[self._turning_v] = turn.dot(v[self._turning_v])
        return rate

    def turning_speed(self, v: np.ndarray) -> float:
        """The largest rate of a joint that turns in the plane or in space [1/s]."""
        # Translations count as well: in these groups they are turned along.
        return float(np.abs(v[self._curved[1]]).max(initial=0.0))


def _indices(model: pin.Model, wanted: object) -> tuple[slice | np.ndarray, slice | np.ndarray]:
    """Where the wanted joints' entries stand in q and v, as slices where they can be."""
    found = []
    for start, count in (("idx_q", "nq"), ("idx_v", "nv")):
        entries: list[int] = []
        for joint in list(model.joints)[1:]:
            if wanted(joint):  # type: ignore[operator]
                first = getattr(joint, start)
                entries.extend(range(first, first + getattr(joint, count)))
        whole = entries == list(range(entries[0], entries[0] + len(entries))) if entries else True
        where: slice | np.ndarray = np.array(entries, dtype=int)
        if whole:
            where = slice(entries[0], entries[0] + len(entries)) if entries else slice(0, 0)
        found.append(where)
    return found[0], found[1]


def _alone(model: pin.Model) -> pin.Model | None:
    """The joints that turn with more than one degree of freedom, as a model; None without any."""
    alone = pin.Model()
    for joint, name in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):
        if joint.nq != joint.nv and joint.nv > 1:
            alone.addJoint(0, joint, pin.SE3.Identity(), name)
    return alone if alone.nv else None
