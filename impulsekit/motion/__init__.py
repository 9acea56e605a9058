"""Motion after an impact: forces, flight, events, rest, and their ``Trajectory``.

Names load when first used.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
