"""Chains and trees of up to a million links, solved in time proportional to their length."""

from .batch.long import LongImpact, LongTree, long_chain, long_tree

__all__ = ["LongImpact", "LongTree", "long_chain", "long_tree"]
