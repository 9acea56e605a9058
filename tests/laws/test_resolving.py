"""Operators that are remembered from one function to the next compile to what they say."""

import numpy as np
import pytest

from impulsekit.laws import resolving
from impulsekit.laws.compiled import compiled, dispatcher, use_numba


def powers(x, n, a, flags):
    total = x**2 + x**-1 + 2.0 * x - 3 + n**2 + n // 2 + n % 3 + x / n
    total += a[1, 0] * a[-1, n - n] + a[0][1] - (x < n) + (not flags[0]) + (-x) ** 3
    a[0, 0] = n
    a[n - n, 1] -= 0.5 * x
    return total + a.sum() + (a + 1.0)[0, 0]


def integers(x, n, a, flags):
    total = n**2 * x + (n << 1) + (n & 1) + (n >= 2) + (a[0, 0] == n)
    for i in range(n, 0, -1):
        total += i * a[i % 2, i % 2] if flags[i % 2] else -i
    return total


@pytest.mark.parametrize("function", [powers, integers])
def test_compiled_operators_do_what_python_does(function):
    use_numba()
    from numba.core.compiler import Compiler

    quick = dispatcher(function, {"nogil": True, "error_model": "numpy"})
    plain = dispatcher(function, {"nogil": True, "error_model": "numpy"})
    plain._compiler.pipeline_class = Compiler
    plain._cache = quick._cache = type(quick._cache)(function, repr(function))
    rng = np.random.default_rng(0)
    for n in (1, 2, 5):
        x, a, flags = float(rng.normal()), rng.normal(size=(2, 2)), np.array([True, False])
        arrays = [a.copy() for _ in range(3)]
        found = [
            each(x, n, own, flags)
            for each, own in zip((quick, plain, function), arrays, strict=True)
        ]
        assert found[0] == found[1] == pytest.approx(found[2], rel=1e-14)
        assert np.array_equal(arrays[0], arrays[2]) and np.array_equal(arrays[1], arrays[2])


def test_other_releases_of_numba_compile_as_they_do(monkeypatch):
    use_numba()
    from numba.core.compiler import Compiler

    monkeypatch.setattr(resolving, "KNOWN", ("none",))
    assert resolving.quick_compiler.__wrapped__() is Compiler


def test_signatures_are_kept_between_functions(monkeypatch):
    use_numba()
    from numba.core.compiler import Compiler

    if resolving.quick_compiler() is Compiler:
        pytest.skip("numba compiles as it does")
    from numba.core import types

    asked = []
    known = types.Function.get_call_type

    def heard(self, context, args, kws):
        asked.append((str(self.typing_key), tuple(map(str, args))))
        return known(self, context, args, kws)

    def product(x, y):
        return x * y

    def square(x, y):
        return x * x * y

    for function in (product, square):
        asked.clear()
        monkeypatch.setattr(types.Function, "get_call_type", heard)
        made = dispatcher(function, {"nogil": True}, "once")
        made._cache = type(made._cache)(function, str(id(made)))
        made._cache.save_overload = lambda sig, data: None
        made.compile((types.float64, types.float64))
    assert not [each for each in asked if "mul" in each[0]]


def test_numba_functions_of_others_are_left_alone():
    use_numba()
    import numba
    from numba.core import types
    from numba.core.registry import cpu_target

    compiled(powers)
    operator = cpu_target.typing_context.resolve_value_type(__import__("operator").mul)
    assert type(operator) is types.Function

    @numba.njit
    def own(x):
        return x * 2

    assert own(3) == 6 and own(1.5) == 3.0


def test_what_numba_has_written_in_python_is_no_machine_code():
    use_numba()
    from numba.core import event
    from numba.core.compiler import Compiler

    if resolving.quick_compiler() is Compiler:
        pytest.skip("numba compiles as it does")
    made = []

    class Listener(event.Listener):
        def on_start(self, event):
            pass

        def on_end(self, event):
            made.append(event.data["dispatcher"])

    def largest_of(a):
        return a.max() + np.cumprod(a)[1]

    whole = dispatcher(largest_of, {"nogil": True, "error_model": "numpy"})
    # Compiled anew, whatever runs before have left.
    whole._cache.load_overload = lambda sig, target: None
    whole._cache.save_overload = lambda sig, data: None
    with event.install_listener("numba:compile", Listener()):
        found = whole(np.arange(3.0))
    assert found == 2.0
    libraries = [code.library for each in made for code in each.overloads.values()]
    inner = [each for each in libraries if "largest_of" not in each.name]
    assert inner and all(type(each).__name__ == "Part" for each in inner)
