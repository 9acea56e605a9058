"""The same scene at many states: compiled kernels, studies, and trees of any length."""
