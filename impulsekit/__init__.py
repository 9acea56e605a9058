"""impulsekit: what happens when a multibody system is hit.

The public names resolve on first use, so importing the package loads nothing heavy.
The list of them is the stub ``__init__.pyi`` beside this file: what a first program needs,
and the modules ``design``, ``measured``, ``study``, ``long`` and ``models`` with the rest.
"""

import importlib as _importlib
from typing import Any as _Any

import lazy_loader as _lazy

__version__ = "0.1.0"

_of_stub, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)

# Names found one module further down: not listed here, yet a program that uses them runs.
_ELSEWHERE = {
    "checking": ("Check",),
    "compliance": (
        "BodyRegion",
        "ForceHistory",
        "Hertz",
        "HuntCrossley",
        "ISO_TS_15066",
        "MeasuredCurve",
        "TransientContact",
    ),
    "design": (
        "ImpactEllipsoid",
        "LeastBlow",
        "SparedJoint",
        "WorstBlow",
        "centre_of_percussion",
        "effective_mass",
        "impact_ellipsoid",
        "least_blow",
        "plot_effective_mass",
        "plot_sparing",
        "reaction_map",
        "spare_joint",
        "worst_blow",
    ),
    "impact": ("ImpactSolver",),
    "impact.derivatives": ("DerivativeStatus", "Derivatives", "ImpulseDerivatives"),
    "impact.freed": ("FreedJoint", "freed_joint"),
    "impact.saltation": ("Saltation", "saltation_matrix"),
    "long": ("LongImpact", "LongTree", "long_chain", "long_tree"),
    "measured": ("Fit", "Measurement", "Recording", "fit_impacts"),
    "models": ("chain_urdf", "example_names", "pendulum_urdf"),
    "motion": ("Sensitivity",),
    "scene": ("DesignPoint", "MotionSettings", "ReportPoint"),
    "scenefile": ("SceneFile", "dump_scene"),
    "study": ("Study", "Variation", "load_study", "open_study", "run_study", "summarize"),
    "view": ("Replay",),
}


def __getattr__(name: str) -> _Any:
    for module, names in _ELSEWHERE.items():
        if name in names:
            return getattr(_importlib.import_module(f"{__name__}.{module}"), name)
    return _of_stub(name)
