"""Code that only compiled code calls: made once, kept on disk, and linked into what reaches it."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from numba.core.errors import TypingError

from impulsekit.laws import linked, store
from impulsekit.laws.compiled import compiled, entry, use_numba

SOURCE = """
@compiled
def inner(a, k):
    if k > 1:
        raise ValueError("too far")
    return 2.0 * a[1:][k - 1]

@compiled
def middle(a):
    return inner(a, 1) + a.copy().sum()

@entry(lambda: (np.ones(2),), seconds=0.1)
def outer(a):
    return middle(a)

@entry(lambda: (np.ones(2),), seconds=0.1)
def other(a):
    return middle(a) - inner(a, 1)
"""


def written_anew():
    names = {"compiled": compiled, "entry": entry, "np": np, "__name__": "written.anew"}
    exec(SOURCE, names)
    return names


def files(folder):
    return {path.name.rpartition("-")[0] for path in folder.rglob("*.code")}


@pytest.fixture(autouse=True)
def fresh(tmp_path, monkeypatch):
    use_numba()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(linked, "_by_path", {})


def test_another_entry_links_what_is_on_disk(tmp_path, monkeypatch):
    first = written_anew()
    assert first["outer"].compile()(np.array([3.0, 4.0])) == 15.0
    kept = files(tmp_path)
    assert len(kept) == 3
    monkeypatch.setattr(linked, "_by_path", {})
    # As another process would.
    second = written_anew()
    assert second["other"].compile()(np.array([3.0, 4.0])) == 7.0
    assert len(files(tmp_path)) == 4
    assert len(linked._by_path) == 2


def test_what_is_not_on_disk_is_compiled_anew(tmp_path, monkeypatch):
    assert written_anew()["outer"].compile()(np.array([3.0, 4.0])) == 15.0
    monkeypatch.setattr(linked, "_by_path", {})
    for path in tmp_path.rglob("*inner*.code"):
        path.unlink()
    assert written_anew()["other"].compile()(np.array([3.0, 4.0])) == 7.0


def test_code_within_has_no_machine_code_and_counts_no_references_it_need_not():
    from numba.core.registry import cpu_target

    names = written_anew()
    names["outer"].compile()
    typed = cpu_target.typing_context
    made = {name: typed.resolve_value_type(names[name]).dispatcher for name in ("inner", "middle")}
    libraries = {}
    for name, one in made.items():
        (found,) = one.overloads.values()
        libraries[name] = found.library
    assert all(isinstance(one, linked.InnerLibrary) for one in libraries.values())
    assert "NRT_incref" not in str(libraries["inner"].own_module())
    assert "NRT_" in str(libraries["middle"].own_module())
    assert libraries["middle"].within == [libraries["inner"]]


def test_arrays_made_and_passed_are_given_back():
    from numba.core.runtime import _nrt_python, rtsys

    _nrt_python.memsys_enable_stats()
    code = written_anew()["outer"].compile()
    a = np.array([3.0, 4.0])
    code(a)
    gc.collect()
    before = rtsys.get_allocation_stats()
    for _ in range(100):
        code(a)
    after = rtsys.get_allocation_stats()
    _nrt_python.memsys_disable_stats()
    assert after.alloc - before.alloc == after.free - before.free >= 100
    assert a.tolist() == [3.0, 4.0]


def test_arrays_are_written_into_arrays_within_a_function_that_makes_none():
    @compiled
    def rows_after(a):
        for k in range(1, len(a)):
            a[k] = a[k - 1]

    @entry(lambda: (np.ones((2, 2)),), seconds=0.1)
    def spread(a):
        rows_after(a)

    table = np.array([[1.0, 2.0], [3.0, 4.0]])
    spread.compile()(table)
    np.testing.assert_array_equal(table, [[1.0, 2.0], [1.0, 2.0]])


def test_what_cannot_be_compiled_keeps_no_other_process_waiting(monkeypatch):
    begun, ended = [], []
    monkeypatch.setattr(store, "begin_compiling", begun.append)
    monkeypatch.setattr(store, "end_compiling", ended.append)

    @compiled
    def unknown(a):
        return a.no_such_thing

    @entry(lambda: (np.ones(2),), seconds=0.1)
    def asks(a):
        return unknown(a)

    with pytest.raises(TypingError):
        asks.compile()
    assert len(begun) >= 2 and sorted(ended) == sorted(begun)
