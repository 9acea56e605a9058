"""``Measurement``: one measured impact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..display import OneLine
from ..scene import Scene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Measurement"]


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(OneLine):
    """One measured impact.

    Attributes:
        scene: the scene of the impact; the fit starts from its coefficients and inertias.
        q: (nq,) configuration. v_before: (nv,); both taken as exact without ``covariance``;
            noise in them then widens the intervals if sigma is None, or too small for it.
        v_after: (nv,) as measured; NaN for missing entries.
        sigma: standard deviation of the noise of v_after, one number or (nv,); None if unknown;
            it is then estimated from the residuals.
        covariance: (3 nv, 3 nv) of (q on its tangent, v_before, v_after), instead of sigma:
            errors in variables, carried through the impact to first order.
        points: by name of a contact, (3,) in place of its ``at`` in the coordinates of its frame
            [m], such as the point at which an ellipse touches.
        group: name of a kind of impacts, such as "edge"; see ``fit_impacts(by_group=True)``.
        recording: where it is from; ``compare_laws`` holds out all impacts of a recording at once.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, solve
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5, name="floor")])
        >>> q, v = ball.neutral(), [0.0, 0, -2, 0, 0, 0]
        >>> measured = Measurement(scene, q, v, solve(scene, q, v).v_after, sigma=1e-3)
        >>> measured.sigma
        0.001
    """

    scene: Scene
    q: ArrayLike
    v_before: ArrayLike
    v_after: ArrayLike
    sigma: ArrayLike | None = None
    covariance: ArrayLike | None = None
    points: Mapping[str, ArrayLike] = field(default_factory=dict)
    group: str = ""
    recording: str = ""
