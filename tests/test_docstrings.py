"""The short examples in the docstrings are true."""

import doctest
import importlib
import inspect
import pathlib
import pkgutil

import pytest

import impulsekit

ROOT = pathlib.Path(__file__).parents[1]
MODULES = sorted(
    module.name for module in pkgutil.walk_packages(impulsekit.__path__, "impulsekit.")
)


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    needs = {"torch": "torch", "jax": "jax", "rl": "torch", "casadi": "casadi", "mujoco": "mujoco"}
    if name.split(".")[1] in needs:
        pytest.importorskip(needs[name.split(".")[1]])
    assert doctest.testmod(importlib.import_module(name)).failed == 0


PUBLIC = [impulsekit] + [getattr(impulsekit, name) for name in dir(impulsekit)]
PUBLIC = [module for module in PUBLIC if inspect.ismodule(module)]


@pytest.mark.parametrize("module", PUBLIC, ids=lambda module: module.__name__)
def test_every_public_name_has_an_example(module):
    """``help()`` of each ends in an example that runs (above)."""
    for name in module.__all__:
        each = getattr(module, name)
        if inspect.isfunction(each) or inspect.isclass(each):
            assert ">>>" in (inspect.getdoc(each) or ""), f"{module.__name__}.{name}"
