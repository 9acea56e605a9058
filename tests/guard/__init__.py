"""Solves are guarded against getting slower: counts, which are exact, and ratios."""
