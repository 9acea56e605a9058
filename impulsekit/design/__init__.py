"""The response of a robot to a blow, before any blow falls: where best to strike.

response ─┬► ellipsoid     effective mass of a point, by direction
          ├► least_blow    the least impulse that does what is wanted
          └► sparing       what a joint bears: centre of percussion, sweet spot, worst case
fit       coefficients and inertias from measured velocity jumps
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
