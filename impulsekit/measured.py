"""Measured impacts: read them, fit coefficients and inertias to them, replay a recording."""

import lazy_loader as _lazy

# A recording is replayed without what a fit needs.
__getattr__, __dir__, __all__ = _lazy.attach(
    "impulsekit",
    submod_attrs={
        "design.fit": ["Fit", "Measurement", "fit_impacts"],
        "design.measured": ["load_measurements"],
        "view.recording": ["Recording"],
    },
)
