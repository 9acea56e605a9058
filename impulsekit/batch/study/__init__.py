"""Studies: a scene at random states, streamed to a store, resumed, summed up."""

from .load import load_study
from .run import run_study
from .store import open_study
from .study import Study
from .summary import StudySummary, summarize
from .variation import Variation

__all__ = [
    "Study",
    "StudySummary",
    "Variation",
    "load_study",
    "open_study",
    "run_study",
    "summarize",
]
