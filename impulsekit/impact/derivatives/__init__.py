"""Derivatives of an impact by the state, the impulses, the coefficients and the points.

The core makes an impact linear in its modes; here are the face of that for one impact, and words.
"""

from .derive import derivatives
from .result import Derivatives
from .status import DerivativeStatus

__all__ = ["DerivativeStatus", "Derivatives", "derivatives"]
