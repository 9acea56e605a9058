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

    Attributes:
        friction: of all pairs, or None.
        handled: sorted keys of the pairs whose impacts are treated, in both orders; None for all.
    """

    def __init__(
        self, model: Any, restitution: Any, friction: Any, combine: str, pairs: Any
    ) -> None:
        if combine not in COMBINATIONS:
            raise RangeError.of("combine", combine, " or ".join(f'"{c}"' for c in COMBINATIONS))
        self._model = model
        self._combine = COMBINATIONS[combine]
        self.friction = None if friction is None else not_negative(friction, "friction")
        self._by_geom: list[Any] = [0.0] * model.ngeom
        self._by_pair: dict[frozenset[int], Any] = {}
        self._keep_restitution(restitution)
        self.handled = None if pairs is None else _keys_of(self._pairs_of(pairs))
        self._found: dict[tuple[int, int], Any] = {}

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

    def restitution(self, first: int, second: int, speed: float) -> float:
        """Return e of a pair at an approach speed [m/s]."""
        pair = (first, second)
        if pair not in self._found:
            both = frozenset(pair)
            if both in self._by_pair:
                e = self._by_pair[both]
            else:
                a, b = self._by_geom[first], self._by_geom[second]
                e = (a, b) if callable(a) or callable(b) else self._combine(a, b)
            self._found[pair] = e
        e = self._found[pair]
        what = "restitution"
        if isinstance(e, tuple):
            return self._combine(*(restitution_at(own, speed, what) for own in e))
        return restitution_at(e, speed, what)


def _keys_of(pairs: set[frozenset[int]]) -> np.ndarray:
    """Pairs of geoms as one integer for each order, sorted."""
    both = [(min(pair), max(pair)) for pair in pairs]
    ordered = np.array(both + [(b, a) for a, b in both], dtype=np.int32).reshape(-1, 2)
    return np.unique(ordered.view(np.int64))
