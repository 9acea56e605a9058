"""Chains and trees of up to a million links, solved in time proportional to their length."""

from .batch.long import LongTree, long_chain, long_tree
from .batch.long_impact import LongImpact

__all__ = ["LongImpact", "LongTree", "long_chain", "long_tree"]
