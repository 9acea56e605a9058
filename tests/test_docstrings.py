"""The short examples in the docstrings are true."""

import doctest
import importlib
import pathlib
import pkgutil

import pytest

import impulsekit

ROOT = pathlib.Path(__file__).parents[1]
MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(impulsekit.__path__, "impulsekit.")
    if not module.name.startswith("impulsekit.bench")
)


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    assert doctest.testmod(importlib.import_module(name)).failed == 0
