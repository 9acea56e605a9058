"""How an answer changes with the state, the blows, the coefficients and the points.

The core makes an impact linear in its modes; here are the face of that for one impact, and words.
"""

from .derive import derivatives
from .result import Derivatives
from .status import DerivativeStatus

__all__ = ["DerivativeStatus", "Derivatives", "derivatives"]
