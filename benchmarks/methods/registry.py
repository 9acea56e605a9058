"""All methods: ours, and those of other programs as far as they are installed."""

from __future__ import annotations

import importlib
from collections.abc import Iterable

from impulsekit.errors import UnknownNameError

from .method import Method

# Each file has a tuple METHODS.
ROOMS = ("own", "bare", "mujoco", "crocoddyl", "exudyn")
# Ways of the batch that a quick run does without.
VARIANTS = (
    "impulsekit, batch on one thread",
    "impulsekit, large batch",
)


def few(chosen: Iterable[Method]) -> list[Method]:
    """Fewer of them, for a quick run: every second setting of each name, from its second on."""
    kept: list[Method] = []
    seen: dict[str, int] = {}
    for method in chosen:
        place = seen[method.name] = seen.get(method.name, -1) + 1
        if method.name not in VARIANTS and (method.setting is None or place % 2 == 1):
            kept.append(method)
    return kept


def methods(names: Iterable[str] = (), peers: bool = True) -> list[Method]:
    """Methods by the beginnings of their names, or all of them.

    Args:
        names: beginnings, such as "mujoco" or "impulsekit, batch".
        peers: also those of other programs and the classical ways.

    Raises:
        UnknownNameError: a beginning that no method has.
    """
    known = [
        method
        for room in ROOMS
        for method in importlib.import_module(f".{room}", __package__).METHODS
        if peers or not method.peer
    ]
    chosen = list(names)
    for name in chosen:
        if not any(method.label.startswith(name) for method in known):
            raise UnknownNameError.among("method", name, dict.fromkeys(m.name for m in known))
    if not chosen:
        return known
    return [method for method in known if any(method.label.startswith(n) for n in chosen)]


def method_labelled(label: str) -> Method:
    """One method, by its label.

    Raises:
        UnknownNameError: no method is so called.
    """
    for method in methods():
        if method.label == label:
            return method
    raise UnknownNameError.among("method", label, [method.label for method in methods()])
