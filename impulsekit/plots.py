"""Plots, as ``impulsekit.view.plots`` has them: ``import impulsekit.plots`` gives that module."""

import sys

from .view import plots

sys.modules[__name__] = plots
