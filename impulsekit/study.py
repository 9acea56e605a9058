"""Studies: one scene at many random states, written to a store that can be resumed."""

from .batch.study.load import load_study
from .batch.study.run import run_study
from .batch.study.store import open_study
from .batch.study.study import Study, Variation
from .batch.study.summary import StudySummary, summarize

__all__ = [
    "Study",
    "StudySummary",
    "Variation",
    "load_study",
    "open_study",
    "run_study",
    "summarize",
]
