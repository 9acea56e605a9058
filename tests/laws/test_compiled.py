"""Functions run as Python at first; compiled code is kept apart by all that it is made of."""

import gc
import importlib
import math
import os
import pathlib
import pkgutil
import subprocess
import sys
import textwrap
import typing
from concurrent.futures import ThreadPoolExecutor

import pytest

import impulsekit
from impulsekit.laws import store
from impulsekit.laws.compiled import ENTRIES, compiled, dispatcher, entry, use_numba
from impulsekit.laws.fingerprint import fingerprint

_MODULE = """
import math
from impulsekit.laws.compiled import compiled, entry

FACTOR = {factor}

@compiled
def length(x, y):
    return FACTOR * math.sqrt(x * x + y * y)

@entry(lambda: (1.0, 1.0), seconds={seconds})
def twice(x, y):
    return 2.0 * length(x, y) / x

@entry(lambda: (1.0,), seconds={seconds}, apart=True)
def half(x: float) -> float:
    return 0.5 * x

@entry(lambda: (1.0,), seconds={seconds})
def quarter(x: float) -> float:
    return 0.5 * half(x)
"""


def run(folder: pathlib.Path, script: str, *, factor: float = 1.0, seconds: float = 9.0) -> str:
    """What a fresh process prints that has the module above as ``impulsekit.made``."""
    (folder / "made.py").write_text(_MODULE.format(factor=factor, seconds=seconds))
    begin = """
        import importlib.util, sys, impulsekit
        spec = importlib.util.spec_from_file_location("impulsekit.made", {path!r})
        made = sys.modules["impulsekit.made"] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(made)
    """
    code = textwrap.dedent(begin.format(path=str(folder / "made.py"))) + textwrap.dedent(script)
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "NUMBA_CACHE_DIR": str(folder / "kept")},
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return done.stdout.strip()


def test_the_first_answer_needs_no_numba(tmp_path):
    shown = run(tmp_path, "print(made.twice(3.0, 4.0), 'numba' in sys.modules)")
    assert shown == f"{2.0 * 5.0 / 3.0} False"


def test_compiled_code_of_other_sources_is_not_used(tmp_path):
    script = "made.twice.compile(); print(made.twice(3.0, 4.0), made.twice.is_compiled)"
    assert run(tmp_path, script) == f"{10.0 / 3.0} True"
    # The file that calls is the same; a constant of a function within has changed.
    assert run(tmp_path, script, factor=3.0) == f"{30.0 / 3.0} True"


def test_what_is_compiled_is_kept(tmp_path):
    run(tmp_path, "made.twice.compile()")
    loads = """
        from numba.core import event
        with event.install_recorder("numba:compile") as seen:
            made.twice.compile()
        ours = [e.data["dispatcher"].__name__ for _, e in seen.buffer]
        print(made.twice(3.0, 4.0), ours.count("twice") + ours.count("length"))
    """
    assert run(tmp_path, loads) == f"{10.0 / 3.0} 0"


def test_of_two_processes_one_compiles_and_the_other_waits_for_it(tmp_path):
    script = """
        import pathlib, time
        from numba.core import event
        from impulsekit.laws.compiled import use_numba
        use_numba()
        begin = time.monotonic() + 60.0
        pathlib.Path({mine!r}).touch()
        while not pathlib.Path({others!r}).exists() and time.monotonic() < begin:
            time.sleep(0.001)
        with event.install_recorder("numba:compile") as seen:
            made.twice.compile()
        ours = [e.data["dispatcher"].__name__ for _, e in seen.buffer if e.is_start]
        print(made.twice(3.0, 4.0), ours.count("twice") + ours.count("length"))
    """
    names = [str(tmp_path / "first"), str(tmp_path / "second")]
    scripts = [script.format(mine=a, others=b) for a, b in (names, names[::-1])]
    with ThreadPoolExecutor() as pool:
        shown = list(pool.map(lambda text: run(tmp_path, text).split(), scripts))
    assert [float(answer) for answer, _ in shown] == [10.0 / 3.0] * 2
    assert sum(int(count) for _, count in shown) == 2


def test_what_another_process_has_compiled_since_is_loaded_when_looked_for_again(tmp_path):
    script = """
        import os, subprocess
        made.twice.load()
        compiles = "made.twice.compile()"
        subprocess.run([sys.executable, "-c", begin + compiles], check=True)
        made.twice.load()
        first = made.twice.is_compiled
        made.twice.load(again=True)
        print(first, made.twice.is_compiled)
    """
    begin = (
        "import importlib.util, sys, impulsekit\n"
        "spec = importlib.util.spec_from_file_location("
        f"'impulsekit.made', {str(tmp_path / 'made.py')!r})\n"
        "made = sys.modules['impulsekit.made'] = importlib.util.module_from_spec(spec)\n"
        "spec.loader.exec_module(made)\n"
    )
    assert run(tmp_path, f"begin = {begin!r}\n" + textwrap.dedent(script)) == "False True"


@pytest.mark.parametrize(
    "damage", [lambda data: data[:1000], lambda data: b"", lambda data: b"?" * 99]
)
def test_a_damaged_file_is_compiled_anew(tmp_path, damage):
    run(tmp_path, "made.twice.compile()")
    for path in (tmp_path / "kept").rglob("*.code"):
        path.write_bytes(damage(path.read_bytes()))
    assert run(tmp_path, "made.twice.compile(); print(made.twice(3.0, 4.0))") == f"{10.0 / 3.0}"


def test_without_a_folder_to_write_code_is_compiled_all_the_same(tmp_path):
    (tmp_path / "kept").write_text("a file stands where the folder would be")
    assert run(tmp_path, "made.twice.compile(); print(made.twice(3.0, 4.0))") == f"{10.0 / 3.0}"


def test_it_compiles_where_the_compiler_is_switched_off_for_a_users_own_code(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    script = """
        made.twice.compile(), made.quarter.compile()
        print(made.twice(3.0, 4.0), made.quarter(1.0))
    """
    assert run(tmp_path, script).split() == [str(10.0 / 3.0), "0.25"]


def test_it_is_compiled_once_interpreting_has_cost_as_much(tmp_path):
    script = """
        import time
        begin = time.perf_counter()
        while not made.twice.is_compiled and time.perf_counter() - begin < 60.0:
            made.twice(3.0, 4.0)
        print(made.twice.is_compiled, made.twice(3.0, 4.0))
    """
    assert run(tmp_path, script, seconds=0.1) == f"True {10.0 / 3.0}"


def test_what_python_cannot_divide_compiled_code_does(tmp_path):
    assert run(tmp_path, "print(made.twice(0.0, 4.0))") == "inf"


def test_arguments_of_other_types_are_not_compiled_for(tmp_path):
    script = """
        import numpy as np
        code = made.twice.compile()
        try:
            code(np.ones(2), np.ones(2))
        except TypeError:
            print("refused")
    """
    assert run(tmp_path, script) == "refused"


def test_a_fingerprint_sees_all_that_is_called():
    def of(factor, root):
        def inner(x):
            return factor * root(x)

        def outer(x):
            return inner(x) + 1.0

        inner.__module__ = outer.__module__ = "impulsekit.made"
        return fingerprint(outer)

    assert of(2.0, math.sqrt) == of(2.0, math.sqrt)
    assert len({of(2.0, math.sqrt), of(3.0, math.sqrt), of(2.0, math.sin)}) == 3


def test_a_fingerprint_sees_what_is_read_today():
    """It is kept from one call to the next only while the same values stand there."""
    names = {"__name__": "impulsekit.made", "FACTOR": 2.0}
    exec("def inner(x): return FACTOR * x\ndef outer(x): return inner(x)", names)
    before = fingerprint(names["outer"])
    assert fingerprint(names["outer"]) == before
    names["FACTOR"] = 3.0
    assert fingerprint(names["outer"]) != before
    names["FACTOR"] = 2.0
    assert fingerprint(names["outer"]) == before


def test_a_fingerprint_sees_how_what_is_called_is_compiled():
    def of(mark):
        def inner(x: float) -> float:
            return 2.0 * x

        marked = mark(inner)

        def outer(x):
            return marked(x) + 1.0

        inner.__module__ = outer.__module__ = "impulsekit.made"
        return fingerprint(outer)

    use_numba()
    marks = [
        compiled,
        lambda function: compiled(function, forceinline=True),
        entry(lambda: (1.0,), seconds=1.0),
        entry(lambda: (1.0,), seconds=1.0, apart=True),
        lambda function: dispatcher(function, {"nogil": True}),
        lambda function: dispatcher(function, {"nogil": True, "error_model": "numpy"}),
    ]
    seen = [of(mark) for mark in marks]
    assert seen[0] == of(compiled)
    assert len(set(seen)) == len(marks)


def test_what_only_compiled_code_calls_is_no_machine_code_of_its_own(tmp_path):
    script = """
        import pathlib, pickle
        made.twice.compile()
        kept = {}
        for path in pathlib.Path(__import__("os").environ["NUMBA_CACHE_DIR"]).rglob("*.code"):
            kept[path.name.partition("-")[0]] = pickle.loads(path.read_bytes()[32:])[0][1]
        print(kept["made.length"], kept["made.twice"], made.twice(3.0, 4.0))
    """
    assert run(tmp_path, script) == f"part object {10.0 / 3.0}"
    # It is read from disk for a caller that is not there.
    for path in (tmp_path / "kept").rglob("made.twice-*.code"):
        path.unlink()
    script = """
        from numba.core import event
        with event.install_recorder("numba:compile") as seen:
            made.twice.compile()
        print(*{e.data["dispatcher"].__name__ for _, e in seen.buffer}, made.twice(3.0, 4.0))
    """
    assert run(tmp_path, script) == f"twice {10.0 / 3.0}"


def test_what_is_marked_stays_the_function_that_it_is():
    def work(impulse, speed):
        return impulse * speed

    assert compiled(work) is work
    made = entry(lambda: (1.0, 1.0), seconds=1.0)(work)
    assert made.py_func is work
    assert made(2.0, 3.0) == 6.0


def test_no_entry_returns_a_named_tuple():
    """numba makes it by running Python, and an interrupt in the middle of that ends the process."""
    for module in pkgutil.walk_packages(impulsekit.__path__, "impulsekit."):
        if module.name.split(".")[1] in ("laws", "motion"):
            importlib.import_module(module.name)
    assert len(ENTRIES) > 10
    for name, made in ENTRIES.items():
        returned = typing.get_type_hints(made.py_func).get("return")
        parts = (returned, *typing.get_args(returned))
        assert not any(hasattr(part, "_fields") for part in parts), name


def test_what_cannot_be_compiled_keeps_no_other_process_waiting(tmp_path, monkeypatch):
    use_numba()
    from numba.core.errors import TypingError

    begun: list[pathlib.Path] = []
    ended: list[pathlib.Path] = []
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(store, "begin_compiling", begun.append)
    monkeypatch.setattr(store, "end_compiling", ended.append)

    @compiled
    def unknown(a):
        return a.no_such_thing

    @entry(lambda: (1.0,), seconds=0.1)
    def asks(a):
        return unknown(a)

    with pytest.raises(TypingError):
        asks.compile()
    assert len(begun) >= 2 and sorted(ended) == sorted(begun)


def test_an_interrupt_while_compiled_code_has_more_compiled_is_raised_behind_it(tmp_path):
    script = """
        def interrupted():
            raise KeyboardInterrupt
        made.quarter.compile()
        made.half._dispatcher = interrupted
        try:
            print(made.quarter(2.0))
        except KeyboardInterrupt:
            print("interrupted")
        del made.half._dispatcher
        from impulsekit.laws.apart import failed
        # What ended one in another thread is raised there.
        failed[-1] = KeyboardInterrupt()
        print(made.quarter(2.0), *failed)
    """
    assert run(tmp_path, script).split() == ["interrupted", "0.5", "-1"]


def test_no_cycles_are_looked_for_while_something_is_compiled(tmp_path, monkeypatch):
    """Each look goes through all that numba has made: up to a fifth of the time."""
    from numba.core import event

    use_numba()
    seen = []

    class Listener(event.Listener):
        def on_start(self, event):
            seen.append(gc.isenabled())

        def on_end(self, event):
            pass

    def twice(x):
        return 2.0 * x

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    twice.__module__ = "impulsekit.laws.twice"
    listener = Listener()
    event.register("numba:compile", listener)
    try:
        for on, argument in ((True, 1.0), (False, 1)):
            (gc.enable if on else gc.disable)()
            assert dispatcher(twice, {})(argument) == 2.0
            assert gc.isenabled() is on
    finally:
        gc.enable()
        event.unregister("numba:compile", listener)
    assert seen
    assert not any(seen)


@pytest.mark.slow
def test_entries_called_by_address_return_what_they_say():
    from impulsekit.laws.apart import _numba_type

    for module in pkgutil.iter_modules(impulsekit.laws.__path__):
        importlib.import_module(f"impulsekit.laws.{module.name}")
    for name, each in ENTRIES.items():
        if name.startswith("impulsekit.laws.") and each.compiled_with["apart"]:
            (made,) = each.compile().overloads.values()
            said = typing.get_type_hints(each.py_func)["return"]
            assert made.signature.return_type == _numba_type(said), name
