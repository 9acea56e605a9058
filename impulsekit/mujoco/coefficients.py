"""Restitution and friction of pairs of geoms, as MuJoCo's model and the user give them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import mujoco
import numpy as np

from ..errors import InputError, RangeError, UnknownNameError, quoted
from ..scene.coefficients import checked_restitution, restitution_at
from ..scene.numbers import not_negative

__all__ = ["COMBINATIONS", "PairCoefficients", "geom_name"]

# How the values of two geoms make that of a pair, as the physics engines offer it.
COMBINATIONS: dict[str, Callable[[float, float], float]] = {
    "max": max,
    "min": min,
    "average": lambda a, b: 0.5 * (a + b),
    "multiply": lambda a, b: a * b,
}


def geom_name(model: Any, geom: int) -> str:
    """Return the name of a geom, or of its body and its number there."""
    name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom)
    if name:
        return str(name)
    body = int(model.geom_bodyid[geom])
    of_body = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body {body}"
    return f"{of_body}/geom {geom - int(model.body_geomadr[body])}"


class PairCoefficients:
    """e and µ by pair of geoms; values are looked up once and kept.

    Args:
        model: the ``mujoco.MjModel``.
        restitution: a number, a function of the approach speed, "user", or a mapping from
            names of geoms or bodies, or from pairs of them, to numbers or functions.
        friction: None for MuJoCo's own, or µ of all pairs.
        combine: a key of ``COMBINATIONS``.
        pairs: names of geoms or bodies, or pairs of them, that are handled; None for all.
        limits: e of the limits of joints and tendons.

    Attributes:
        friction: of all pairs, or None.
        handled: sorted keys of the pairs whose impacts are treated, in both orders; None for all.
    """

    def __init__(
        self, model: Any, restitution: Any, friction: Any, combine: str, pairs: Any,
        limits: float | None,
    ) -> None:  # fmt: skip
        if combine not in COMBINATIONS:
            raise RangeError.of("combine", combine, " or ".join(f'"{c}"' for c in COMBINATIONS))
        self._model = model
        self._combine = COMBINATIONS[combine]
        self.friction = None if friction is None else not_negative(friction, "friction")
        self._by_geom: list[Any] = [0.0] * model.ngeom
        self._by_pair: dict[frozenset[int], Any] = {}
        self._keep_restitution(restitution)
        self.handled = None if pairs is None else _keys_of(self._pairs_of(pairs))
        self._limits = limits or 0.0
        self._found: dict[tuple[int, int], float] = {}

    def _keep_restitution(self, given: Any) -> None:
        if isinstance(given, str):
            if given != "user":
                raise InputError(
                    'restitution must be a number, a function of the speed, "user" or a mapping '
                    f"by geom, body or pair, got {quoted(given)}"
                )
            if not self._model.nuser_geom:
                raise InputError('restitution="user": no geom of the model has a user="..." value')
            own = self._model.geom_user[:, 0]
            self._by_geom = [
                checked_restitution(float(e), f'geom "{geom_name(self._model, i)}": user')
                for i, e in enumerate(own)
            ]
        elif isinstance(given, Mapping):
            for key, value in given.items():
                e = checked_restitution(value, f"restitution of {key!r}")
                if isinstance(key, tuple):
                    for pair in self._pairs_of([key]):
                        self._by_pair[pair] = e
                else:
                    for geom in self._geoms_of(key):
                        self._by_geom[geom] = e
        else:
            e = checked_restitution(given, "restitution")
            self._by_geom = [e] * self._model.ngeom

    def _geoms_of(self, name: Any) -> list[int]:
        """The geoms of a name: one geom, or all of a body."""
        model = self._model
        if isinstance(name, str):
            geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name)
            if geom >= 0:
                return [geom]
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
            if body >= 0:
                first = int(model.body_geomadr[body])
                return list(range(first, first + int(model.body_geomnum[body])))
        kinds = ((mujoco.mjtObj.mjOBJ_GEOM, model.ngeom), (mujoco.mjtObj.mjOBJ_BODY, model.nbody))
        known = [mujoco.mj_id2name(model, kind, i) for kind, count in kinds for i in range(count)]
        raise UnknownNameError.among("geom or body", name, list(filter(None, known)))

    def _pairs_of(self, given: Iterable[Any]) -> set[frozenset[int]]:
        found: set[frozenset[int]] = set()
        everything = range(self._model.ngeom)
        for one in given:
            first, second = one if isinstance(one, tuple | list) else (one, None)
            others = everything if second is None else self._geoms_of(second)
            found |= {frozenset((a, b)) for a in self._geoms_of(first) for b in others}
        return found

    def restitution(self, pairs: Iterable[tuple[int, int, float]]) -> list[float]:
        """Return e of each (first, second, rate of the gap [m/s]).

        A pair whose first is below zero is a limit.
        """
        found, limits = self._found, self._limits
        return [
            limits if first < 0
            else e if isinstance(e := found.get((first, second)), float)
            else self._restitution_at(first, second, max(-rate, 0.0))
            for first, second, rate in pairs
        ]  # fmt: skip

    def _restitution_at(self, first: int, second: int, speed: float) -> float:
        """e of a pair at an approach speed, kept where it is a number."""
        both, what = frozenset((first, second)), "restitution"
        geoms = [self._by_geom[first], self._by_geom[second]]
        own = [self._by_pair[both]] if both in self._by_pair else geoms
        numbers = [restitution_at(e, speed, what) for e in own]
        e = float(self._combine(*numbers) if len(own) == 2 else numbers[0])
        if not any(map(callable, own)):
            self._found[first, second] = e
        return e


def _keys_of(pairs: set[frozenset[int]]) -> np.ndarray:
    """Pairs of geoms as one integer for each order, sorted."""
    both = [(min(pair), max(pair)) for pair in pairs]
    ordered = np.array(both + [(b, a) for a, b in both], dtype=np.int32).reshape(-1, 2)
    return np.unique(ordered.view(np.int64))
