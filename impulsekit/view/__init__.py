"""Replay, plots and reports. Nothing heavy is loaded from here; import the file you need."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
