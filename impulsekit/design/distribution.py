"""The spread of a quantity of an impact over coefficients, pose, velocity and order of contacts."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError, RangeError, SetupWarning, check_kind
from ..errors.calls import public
from ..formatting import OneLine, one_line
from ..impact.all_outcomes import one_outcome
from ..impact.solver import solve
from ..robot import state
from ..robot.arrays import read_only
from ..scene import Scene
from ..scene.numbers import whole
from .box import Box, bounds_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..impact import Impact

# Independent Sobol sequences, whose quantiles differ by chance.
SEQUENCES = 8


@public
@dataclass(frozen=True, eq=False, repr=False)
class Distribution(OneLine):
    """The values of a quantity over a box of what is not known exactly.

    Attributes:
        values: (8, N) of 8 independent scrambled Sobol sequences; NaN where an impact is not valid,
            or friction jams its contacts.
        refused: how many those are.

    Example:
        >>> import numpy as np
        >>> spread = Distribution(np.arange(800.0).reshape(100, 8).T, 0)
        >>> spread.quantile(0.5)
        399.5
    """

    values: np.ndarray
    refused: int

    def __repr__(self) -> str:
        low, middle, high = (f"{self.quantile(p):.4g}" for p in (0.05, 0.5, 0.95))
        count = f"{self.values.size - self.refused} samples, {self.refused} refused"
        return one_line("Distribution", f"5 % {low}", f"50 % {middle}", f"95 % {high}", count)

    def quantile(self, share: float) -> float:
        """Return the value that a share of all samples, 0 to 1, does not exceed.

        Raises:
            RangeError: a share that is not 0 to 1.
        """
        if not 0.0 <= share <= 1.0:
            raise RangeError.of("share", share, "0 to 1")
        return float(np.nanquantile(self.values, share))

    def error(self, share: float) -> float:
        """Return the standard error of a quantile: of the mean of those of the 8 sequences."""
        own = np.nanquantile(self.values, share, axis=1)
        return float(own.std(ddof=1) / math.sqrt(SEQUENCES))

    def convergence(self, share: float) -> np.ndarray:
        """(K, 3) numbers of samples, doubled each time; the quantile and its error with so many."""
        rows, size = [], 8
        while size <= self.values.shape[1]:
            part = Distribution(self.values[:, :size], 0)
            rows.append((size * SEQUENCES, part.quantile(share), part.error(share)))
            size *= 2
        return np.array(rows)


@public
def distribution(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike,
    quantity: Callable[[Impact], float],
    *,
    restitution: Sequence[float] | None = None,
    friction: Sequence[float] | None = None,
    pose: Mapping[str, Sequence[float]] | None = None,
    velocity: Mapping[str, Sequence[float]] | None = None,
    any_order: bool = True,
    samples: int = 1024,
    seed: int = 0,
) -> Distribution:
    """Return how a quantity spreads over a box, uniform in it, and over orders of the contacts.

    Args:
        scene: with contacts. q, v: (nq,), (nv,) the state in the middle.
        quantity: of an ``Impact`` a number, such as ``lambda i: i.joint_loads["knee"].shear``.
        restitution, friction: (low, high), for all contacts alike; None leaves those of the scene.
        pose, velocity: by joint name (low, high), offsets on its single coordinate or its speed.
        any_order: True for one outcome at random of each point, as ``outcomes`` has them; False
            for the answer of the scene's law.
        samples: in total, rounded up to a power of 2, 64 at least. seed: of sequences and orders.

    Raises:
        UnknownNameError: no such joint. RangeError: bounds out of range or order, samples, seed.
        InputError: nothing is varied; contacts that ``outcomes`` refuses; no impact is valid.

    Example:
        >>> from impulsekit import Contact, Robot
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")  # 0.5 kg
        >>> scene = Scene(ball, contacts=[Contact("ball", at=[0, 0, -0.1])], gap_bound=1)
        >>> fall = ball.velocity(root_joint=[0, 0, -1, 0, 0, 0])
        >>> def upwards(impact):
        ...     return impact.v_after[2]
        >>> box = {"restitution": (0.2, 0.6), "samples": 64}
        >>> spread = distribution(scene, ball.neutral(), fall, upwards, **box)
        >>> round(spread.quantile(0.5), 1)
        0.4
    """
    check_kind(scene, Scene, "distribution")
    model = scene.robot.model
    place, moving = state.checked_configuration(model, q), state.checked_velocity(model, v)
    bounds = bounds_of(
        scene.robot, "distribution", restitution, friction, pose or {}, velocity or {}
    )
    power = max(math.ceil(math.log2(whole(samples, "samples", 1) / SEQUENCES)), 3)
    seed = whole(seed, "seed", 0)
    box = Box(scene, place, moving, bounds)
    values = np.array(
        [
            _values(box, quantity, any_order, 2**power, seed * SEQUENCES + k)
            for k in range(SEQUENCES)
        ]
    )
    refused = int(np.isnan(values).sum())
    if refused == values.size:
        raise InputError("distribution: no impact of the box is valid")
    return Distribution(read_only(values), refused)


def _values(
    box: Box, quantity: Callable[[Impact], float], any_order: bool, count: int, seed: int
) -> np.ndarray:
    """(count,) the quantity along one Sobol sequence."""
    from scipy.stats import qmc

    points = qmc.Sobol(len(box.bounds), rng=seed).random(count)
    q, v, coefficients = box.at(points)
    named, found = box.by_contact(coefficients), np.full(count, np.nan)
    names = box.scene.entry_names("contacts")
    for k in range(count):
        contacts = [
            replace(entry, **{kind: own[name][k] for kind, own in named.items() if name in own})
            for name, entry in zip(names, box.scene.contacts, strict=True)
        ]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SetupWarning)
            impact = solve(replace(box.scene, contacts=contacts), q[k], v[k])
        own = one_outcome(impact, seed * count + k) if any_order else impact
        if own is not None and impact.is_valid():
            found[k] = quantity(own)
    return found
