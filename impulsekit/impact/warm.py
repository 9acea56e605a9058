"""Which compiled laws a scene needs, so that they can be compiled beforehand."""

from __future__ import annotations

import importlib

from ..laws.compiled import ENTRIES
from ..laws.uniqueness import MOST_IN_PLANE
from ..scene import Scene
from ..scene.contacts import turns

__all__ = ["compile_all_laws", "compile_laws", "laws_of"]

# How well an answer satisfies its equations.
_JUDGED = ("residual_bound",)
_ALONG_THE_PATH = ("path",)
_AT_THE_END = ("single", "coulomb")
# Several that rub.
_TOGETHER = (
    "modes", "frictional", "approach", "redundant", "even_shares", "least_shares", "unloading",
    "sharpening",
)  # fmt: skip
_SMOOTH = ("frictionless", "sharpening")
# Whether there are other solutions.
_RUBBING = ("others", "coupling", "uniqueness")
# All modes of few contacts are tried.
_FEW = ("plane_modes", "space_modes")
# Of more, answers beside the one shown are looked for.
_MANY = ("neighbours",)
# Of which some resist rolling or spin.
_TURNING = ("product_cones",)


def laws_of(scene: Scene) -> tuple[str, ...]:
    """Modules of ``laws`` whose entries ``solve`` and ``simulate`` call for a scene."""
    if not scene.contacts:
        return ("holding",) if scene.held else ()
    held = ("spanning",) if scene.held else ()
    return (*_JUDGED, *held, *_laws_of_contacts(scene))


def _laws_of_contacts(scene: Scene) -> tuple[str, ...]:
    in_turn: tuple[str, ...] = ()
    if scene.law.order == "sequential":
        in_turn = ("sequence", "struck_in_turn") if len(scene.contacts) > 1 else ("sequence",)
    if scene.law.restitution == "lzb":
        return (*_ALONG_THE_PATH, "lzb", *in_turn)
    if scene.law.slip == "path":
        return _ALONG_THE_PATH + in_turn
    rubs = any(getattr(contact, "friction", 0.0) for contact in scene.contacts)
    together = len(scene.contacts) > 1 and scene.law.order == "simultaneous"
    several: tuple[str, ...] = ("several", "groups", "at_once", "struck") if together else ()
    if any(map(turns, scene.contacts)):
        several = (*several, *_TURNING)
    if not rubs:
        return _AT_THE_END + in_turn + several + (_SMOOTH if together else ())
    few = _FEW if together and len(scene.contacts) <= MOST_IN_PLANE else ()
    many = _MANY if together and len(scene.contacts) >= MOST_IN_PLANE else ()
    more = (_TOGETHER if together else ()) + _RUBBING + few + many
    return _AT_THE_END + in_turn + several + more


def compile_laws(scene: Scene) -> None:
    """Compile what ``solve`` and ``simulate`` call for a scene, or load it from disk."""
    _compile(laws_of(scene))


def compile_all_laws() -> None:
    """Compile the laws of all scenes."""
    together = (
        "several",
        "groups",
        "at_once",
        "struck",
        *_TOGETHER,
        *_SMOOTH,
        *_RUBBING,
        *_FEW,
        *_MANY,
        *_TURNING,
    )
    _compile(
        (
            "holding",
            "spanning",
            *_JUDGED,
            *_ALONG_THE_PATH,
            "lzb",
            *_AT_THE_END,
            "sequence",
            "struck_in_turn",
            *together,
        )
    )


def _compile(modules: tuple[str, ...]) -> None:
    for module in modules:
        name = f"{__package__.rpartition('.')[0]}.laws.{module}"
        importlib.import_module(name)
        for key, entry in ENTRIES.items():
            if key.startswith(f"{name}."):
                entry.compile()
