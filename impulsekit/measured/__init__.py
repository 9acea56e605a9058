"""Recorded motions and impacts: read, calibrate, find the impacts, fit coefficients, compare laws.

recording ─► calibration ─► impacts ─┬► fit_impacts   from single impacts
                                     ├► fit_motion    from whole motions
                                     └► compare_laws  which law predicts best
identify                             the whole chain in one call
"""

import lazy_loader as _lazy

# A recording is replayed without what a fit needs. The stub beside this file is for type checkers.
__getattr__, __dir__, __all__ = _lazy.attach(
    "impulsekit",
    submod_attrs={
        "design.fit": ["Fit", "Measurement", "fit_impacts"],
        "measured.measurement_files": ["load_measurements"],
        "measured.calibration": ["Calibration", "calibrate"],
        "measured.columns": ["RecordingFormat"],
        "measured.comparison": ["LawCandidate", "LawComparison", "compare_laws"],
        "measured.impact_detection": ["find_impacts"],
        "measured.found_impacts": ["FoundImpact", "FoundImpacts"],
        "measured.identification": ["Identification", "identify"],
        "measured.mirrored_axes": ["MirroredAxes", "find_mirrored"],
        "measured.motions": ["MotionFit", "fit_motion"],
        "measured.reading": ["load_recordings"],
        "measured.recording": ["Recording"],
    },
)
