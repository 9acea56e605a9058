"""impulsekit: what happens when a multibody system is hit.

The public names resolve on first use, so importing the package loads nothing heavy.
The list of them is the stub ``__init__.pyi`` beside this file: what a first program needs,
and the modules ``compliance``, ``design``, ``measured``, ``study``, ``long`` and ``models``
with the rest.
"""

import typing as _typing

import lazy_loader as _lazy

from .display import show_with as _show_with

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)


def _html_of(result: _typing.Any) -> str:
    from .view.notebook import html_of

    return html_of(result)


_show_with(_html_of)
