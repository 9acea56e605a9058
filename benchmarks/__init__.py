"""Run time, measured: every figure is a ratio of ways that were timed in turn in one run."""
