"""Plots with matplotlib: each takes an ``ax`` or makes one, and returns it.

matplotlib is loaded when the first plot is drawn. It comes with
``pip install ".[plot]"``.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
