"""The same scene at many states: impacts, motions, studies, and trees of any length."""
