"""``Derivatives``: how v⁺ and every impulse change with what an impact starts from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...display import Displayed, OneLine
from ...robot.arrays import read_only
from .status import DerivativeStatus

if TYPE_CHECKING:
    from ..result import Impact

__all__ = ["Derivatives", "ImpulseDerivatives"]


@dataclass(frozen=True, eq=False, repr=False)
class ImpulseDerivatives(OneLine):
    """Derivatives of the impulse p (k,) of one constraint or contact; arrays are read-only.

    Rows and axes are those of the result: a constraint's own rows, a contact's world axes.
    NaN where the impulse shares its load with redundant ones and is not determined.

    Attributes:
        dq, dv: (k, nv) by the configuration (on its tangent) and by v⁻.
        dimpulse: by impulse of the scene, (k, 6), or (k, n) for one in a joint.
        drestitution, dfriction: by contact, (k,).
    """

    dq: np.ndarray
    dv: np.ndarray
    dimpulse: Mapping[str, np.ndarray]
    drestitution: Mapping[str, np.ndarray]
    dfriction: Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False, repr=False)
class Derivatives(Displayed):
    """Derivatives of v⁺ and of all impulses of an impact; arrays are read-only.

    A change of the configuration is δ (nv,) on its tangent, q ⊕ δ as Pinocchio's
    ``integrate`` has it, along the same directions as v.

    Attributes:
        impact: the answer that they belong to.
        status: whether they exist; look at ``status.exists`` first.
        edges: what is on the edge of its mode, a sentence each.
        dv_after_dq, dv_after_dv: (nv, nv).
        dv_after_dimpulse: by impulse of the scene, (nv, 6) linear before angular in the
            axes of the impulse, or (nv, n) for one in a joint with n degrees of freedom.
        dv_after_drestitution, dv_after_dfriction: by contact that touches, (nv,); a
            restitution that changes with speed is shifted as a whole. NaN for one of
            several redundant contacts, whose coefficients can change only together.
        constraints, contacts: by entry, the same for its impulse; contacts that touch.
    """

    impact: Impact = field(repr=False)
    status: DerivativeStatus
    edges: tuple[str, ...]
    dv_after_dq: np.ndarray
    dv_after_dv: np.ndarray
    dv_after_dimpulse: Mapping[str, np.ndarray]
    dv_after_drestitution: Mapping[str, np.ndarray]
    dv_after_dfriction: Mapping[str, np.ndarray]
    constraints: Mapping[str, ImpulseDerivatives]
    contacts: Mapping[str, ImpulseDerivatives]
    _by_inertia: Callable[[int], np.ndarray] = field(repr=False)

    def dv_after_dinertia(self, joint: str) -> np.ndarray:
        """(nv, 10) by the inertia of the body behind a joint.

        Its parameters are those of ``pinocchio.Inertia.toDynamicParameters``: m, m c (3),
        then I_xx, I_xy, I_yy, I_xz, I_yz, I_zz about the joint's origin, in its frame.

        Raises:
            UnknownNameError: there is no such joint.
        """
        found = self._by_inertia(self.impact.scene.robot.joint_id(joint))
        return read_only(found)
