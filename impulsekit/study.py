"""Studies: one scene at many random states, written to a store that can be resumed."""

from .batch.study import (
    Study,
    StudySummary,
    Variation,
    load_study,
    open_study,
    run_study,
    summarize,
)

__all__ = [
    "Study",
    "StudySummary",
    "Variation",
    "load_study",
    "open_study",
    "run_study",
    "summarize",
]
