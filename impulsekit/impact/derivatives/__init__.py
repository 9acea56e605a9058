"""How an answer changes with the state, the blows and the coefficients.

scene ─► workspace (tree, pairs) ─┐
impact ─► modes ──────────────────┴► stages ─► Derivatives
"""

from .derive import derivatives
from .result import Derivatives, ImpulseDerivatives
from .status import DerivativeStatus

__all__ = ["DerivativeStatus", "Derivatives", "ImpulseDerivatives", "derivatives"]
