"""Laws of contact as functions on floats and arrays: numba compiles them, Python runs them."""
