"""From a scene and a state to the velocity jump and all that follows from it."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
