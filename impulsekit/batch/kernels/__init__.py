"""Kernels in numba: plain arrays in, plain arrays out, several states side by side."""
