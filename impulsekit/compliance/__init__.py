"""From impulse to force: what an impact that takes no time means where bodies give way.

curves ──► history      force over time of a contact, from its impulse
limits ──► transient    a robot that strikes a person, beside the limits of ISO 10218-2:2025
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
