"""The response of a robot to a blow, before any blow falls: where best to strike.

response ─┬► ImpactEllipsoid         effective mass of a point, by direction
          ├► least_blow              the least impulse for a desired velocity change
          ├► centre_of_percussion    what a joint carries, where a blow spares it
          ├► worst_case              the largest load over a box of coefficients and poses
          └► distribution            quantiles of anything over such a box, in any order
fit         coefficients and inertias from measured velocity jumps
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
