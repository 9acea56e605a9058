"""Coefficients of the Runge-Kutta method of order 8 of Dormand and Prince, as scipy has them.

Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, II.5 (1993).
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import DOP853

__all__ = ["ERROR_3", "ERROR_5", "FROM", "NODES", "STAGES", "WEIGHTS"]

# Stages of one step.
STAGES = 12
# Row i: the shares of stages 0 to i − 1 in the state of stage i.
FROM = np.array(DOP853.A[:STAGES, :STAGES])
# Where in the step the stages are, as a share of it.
NODES = np.array(DOP853.C[:STAGES])
# Of the stages in the step.
WEIGHTS = np.array(DOP853.B)
# Of the stages in the two estimates of its error.
ERROR_3, ERROR_5 = np.array(DOP853.E3[:STAGES]), np.array(DOP853.E5[:STAGES])
