"""What a person looks at. Nothing heavy is loaded from here; name the file that is wanted."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
