"""Zeros in time of smooth functions: the first within a step, and none passed over."""
