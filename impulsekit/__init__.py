"""impulsekit: what happens when a multibody system is hit.

The public names resolve on first use, so importing the package loads nothing heavy.
The list of them is the stub ``__init__.pyi`` beside this file: what a first program needs,
and the modules ``compliance``, ``design``, ``measured``, ``study``, ``long`` and ``models``
with the rest.
"""

import typing as _typing

import lazy_loader as _lazy

from .formatting import show_with as _show_with

__version__ = "0.1.0"

_get, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)

# What programs written against earlier versions may still ask for.
_GONE = {"warm_up": "nothing is compiled at run time, so leave it out"}
# Where names stand that are not at the top.
_ROOMS = (
    "compliance", "measured", "design", "study", "long", "models", "plots", "impact", "motion",
    "scene", "scenefile", "robot", "batch", "control", "checking", "view",
)  # fmt: skip


def __getattr__(name: str) -> _typing.Any:
    try:
        return _get(name)
    except AttributeError:
        if name.startswith("_"):
            raise
    raise AttributeError(_absent(name), name=name)


def _absent(name: str) -> str:
    """A sentence on a name that is not at the top: where it is, or what is like it."""
    from importlib import import_module, util

    from .errors import nearest_names
    from .errors.wording import one_of

    if name.isidentifier() and util.find_spec(f"{__name__}.{name}"):
        return f"impulsekit.{name} has to be imported: import impulsekit.{name}"
    for room in _ROOMS:
        if name in dir(import_module(f"{__name__}.{room}")):
            return f'impulsekit has no "{name}" at the top; it is impulsekit.{room}.{name}'
    if name in _GONE:
        return f'impulsekit has no "{name}" any more: {_GONE[name]}'
    nearest = nearest_names(name, __all__)
    hint = f"; did you mean {one_of(nearest)}?" if nearest else ""
    return f'impulsekit has no "{name}"{hint}'


def _html_of(result: _typing.Any) -> str:
    from .view.notebook import html_of

    return html_of(result)


_show_with(_html_of)
