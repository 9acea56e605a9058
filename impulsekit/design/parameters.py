"""The unknowns of a fit: coefficients of contacts and inertias of bodies, put into scenes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError, ShapeError, UnknownNameError, quoted, shown
from ..errors.calls import public
from ..formatting import OneLine
from ..robot.arrays import floats
from ..robot.robot import with_masses
from ..scene import JointStop, RestitutionTable, Rope, Scene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@public
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


def checked_sigma(given: Any, nv: int, what: str) -> np.ndarray:
    """Return standard deviations of noise as an array, () or (nv,).

    Raises:
        ShapeError, RangeError: they have another shape, or are not above 0.
    """
    sigma = floats(given, what)
    if sigma.shape not in ((), (nv,)):
        raise ShapeError.of(what, (nv,), sigma.shape, "or one number")
    if not (np.isfinite(sigma) & (sigma > 0.0)).all():
        raise RangeError.of(what, given, "above 0")
    return sigma


# The order of pinocchio.Inertia.toDynamicParameters.
INERTIA_PARAMETERS = ("mass", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz")
# Ratios of stiffnesses are above 0: with this a contact is as good as without friction.
LEAST_RATIO = 1e-3
# What forces have that is no direction and no place.
FORCE_PARAMETERS = ("stiffness", "damping", "torque")


@dataclass(frozen=True)
class Parameter:
    """One unknown.

    Attributes:
        kind: "restitution", "friction", "stiffness_ratio", "inertia" or "force".
        entry: the contact, the pattern or names of contacts that share it, the joint before
            the body, or the force.
        contacts: the contacts that have it.
        index: which inertia or force parameter, or which point of a table of restitution.
        speeds: of the points of that table [m/s]; none for a restitution that is one number.
        group: of the measurements that it is for; None for all.
        start, low, high: where the fit starts, and its bounds.
        scale: the size of its values.
    """

    kind: str
    entry: str
    index: int
    start: float
    low: float
    high: float
    contacts: tuple[str, ...] = ()
    speeds: tuple[float, ...] = ()
    group: str | None = None
    scale: float = 1.0

    @property
    def name(self) -> str:
        """Its name in results."""
        names = {"inertia": INERTIA_PARAMETERS, "force": FORCE_PARAMETERS}.get(self.kind)
        what = names[self.index] if names else self.kind
        where = f" at {self.speeds[self.index]:g} m/s" if self.speeds else ""
        return f"{self.entry}: {what}{where}" + (f", {self.group}" if self.group else "")


def parameters_of(
    scenes: Scene | Sequence[Scene],
    restitution: Sequence[str | Sequence[str]],
    friction: Sequence[str | Sequence[str]],
    inertias: Mapping[str, Sequence[str]],
    groups: Sequence[str] = (),
    grouped: Sequence[str] = ("restitution",),
    stiffness_ratio: Sequence[str | Sequence[str]] = (),
) -> list[Parameter]:
    """Return the unknowns by their names, starting from the values of the first scene.

    A pattern with ``*`` or ``?``, such as "corner_*", or a tuple of names is one unknown that
    these contacts share. A ``RestitutionTable`` is one unknown for each of its points.

    Args:
        groups: of measurements, each with coefficients of its own; none: all share them.
        grouped: which coefficients these are.

    Raises:
        UnknownNameError: no such contact, joint or inertia parameter.
        InputError: a coefficient that is no number.
    """
    several = [scenes] if isinstance(scenes, Scene) else list(scenes)
    scene = several[0]
    contacts: dict[str, Any] = {}
    # Of contacts of one name the first scene's counts.
    for each in reversed({id(each): each for each in several}.values()):
        contacts |= zip(each.entry_names("contacts"), each.contacts, strict=True)
    found = []
    coefficients = {
        "restitution": restitution, "friction": friction, "stiffness_ratio": stiffness_ratio
    }  # fmt: skip
    for kind, wanted in coefficients.items():
        if isinstance(wanted, str):
            raise InputError(
                f"fit: {kind} takes a list of contacts, got {quoted(wanted)}; "
                f"give [{quoted(wanted)}]"
            )
        taken: dict[str, str] = {}
        for given in wanted:
            entry, names = _tied(given, contacts)
            for name in names:
                if name in taken:
                    raise InputError(
                        f"fit: {kind} of {name} is in {taken[name]} and in {entry}; name it once"
                    )
                taken[name] = entry
            values: list[Any] = [getattr(contacts[name], kind, None) for name in names]
            speeds = _speeds(values) if kind == "restitution" else ()
            for name, value in zip(names, values, strict=True):
                if not (speeds or isinstance(value, float)):
                    raise InputError(f"fit_impacts: {name} has no {kind} that is a number")
            high = 1.0 if kind == "restitution" else np.inf
            for group in groups if groups and kind in grouped else (None,):
                for k in range(len(speeds) or 1):
                    own = [each.values[k] if speeds else each for each in values]
                    start = float(np.mean(own))
                    low = LEAST_RATIO if kind == "stiffness_ratio" else 0.0
                    found.append(Parameter(kind, entry, k, start, low, high, names, speeds, group))
    return found + _inertia_parameters(scene, inertias)


def _inertia_parameters(scene: Scene, inertias: Mapping[str, Sequence[str]]) -> list[Parameter]:
    found = []
    for joint, items in inertias.items():
        body = scene.robot.model.inertias[scene.robot.joint_id(joint)]
        values = body.toDynamicParameters()
        # tr I = 2 ∫ r² dm: first moments and products may be zero, and have its size.
        second = 0.5 * float(np.asarray(values)[[4, 6, 9]].sum())
        sizes = {"m": float(np.sqrt(body.mass * second)), "i": second}
        for item in items:
            if item not in INERTIA_PARAMETERS:
                raise UnknownNameError.among(
                    "inertia parameter", item, INERTIA_PARAMETERS, "fit_impacts"
                )
            index = INERTIA_PARAMETERS.index(item)
            low = 0.0 if item in ("mass", "ixx", "iyy", "izz") else -np.inf
            start = float(values[index])
            scale = (start if low == 0.0 else max(abs(start), sizes[item[0]])) or 1.0
            found.append(Parameter("inertia", joint, index, start, low, np.inf, scale=scale))
    return found


def force_parameters_of(scene: Scene, forces: Mapping[str, Sequence[str]]) -> list[Parameter]:
    """Return the unknowns of forces by their names, starting from the values of the scene.

    Raises:
        InputError: no lists of parameters by name.
        UnknownNameError: no such force, or it has no such parameter.
        RangeError: a value that is not above 0: its size is looked for about it.
    """
    names, found = scene.entry_names("forces"), []
    if not isinstance(forces, Mapping) or any(isinstance(each, str) for each in forces.values()):
        raise InputError(
            "fit_motion: forces takes lists of parameters by the name of a force, such as "
            f'{{"bearing": ["damping"]}}, got {shown(forces, 80)}'
        )
    for entry, items in forces.items():
        if entry not in names:
            raise UnknownNameError.among("force", entry, names, "fit_motion")
        force = scene.forces[names.index(entry)]
        known = [each for each in FORCE_PARAMETERS if isinstance(getattr(force, each, None), float)]
        for item in items:
            if item not in known:
                raise UnknownNameError.among(f"parameter of force {entry}", item, known)
            start = float(getattr(force, item))
            if not start > 0.0:
                raise RangeError.of(
                    f"fit_motion: {item} of {entry}", start, "above 0; values around it are tried"
                )
            index = FORCE_PARAMETERS.index(item)
            found.append(Parameter("force", entry, index, start, 0.0, np.inf, scale=start))
    return found


def groups_of(
    measurements: Sequence[Measurement], by_group: bool | Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the groups, and which coefficients each has of its own.

    Raises:
        InputError: no such coefficient.
    """
    if isinstance(by_group, bool | np.bool_):
        by_group = ("restitution",) if by_group else ()
    kinds = (by_group,) if isinstance(by_group, str) else tuple(by_group)
    for kind in kinds:
        if kind not in ("restitution", "friction"):
            raise InputError(
                'by_group must be True, False or of "restitution" and "friction", '
                f"got {shown(kind, 80)}"
            )
    groups = tuple(sorted({each.group for each in measurements})) if kinds else ()
    return groups, kinds


def _speeds(values: Sequence[Any]) -> tuple[float, ...]:
    """Return the speeds of tables of restitution that are alike; none if there are others."""
    if not all(isinstance(value, RestitutionTable) for value in values):
        return ()
    speeds: tuple[float, ...] = values[0].speeds
    if any(value.speeds != speeds for value in values):
        raise InputError("fit: contacts that share e by speed need tables of the same speeds")
    return speeds


def _tied(given: str | Sequence[str], contacts: Mapping[str, Any]) -> tuple[str, tuple[str, ...]]:
    """Return the name of a shared coefficient, and the contacts that share it."""
    if not isinstance(given, str):
        names = tuple(str(name) for name in given)
        entry = ", ".join(names)
    elif given not in contacts and set("*?") & set(given):
        parts = re.split(r"([*?])", given)
        fitting = re.compile("".join({"*": ".*", "?": "."}.get(p, re.escape(p)) for p in parts))
        names = tuple(name for name in contacts if fitting.fullmatch(name))
        entry = given
    else:
        names, entry = (given,), given
    for name in names or (entry,):
        if name not in contacts:
            raise UnknownNameError.among("contact", name, contacts, "fit_impacts")
    return entry, names


def scene_of(
    measurement: Measurement, parameters: Sequence[Parameter], x: np.ndarray, kept: dict[Any, Scene]
) -> Scene:
    """Return the scene of a measurement with the values of the unknowns and its own points.

    ``kept``: scenes made before, which measurements without points share.
    """
    key = id(measurement.scene), measurement.group
    if key not in kept:
        kept[key] = changed_scene(measurement.scene, parameters, x, measurement.group)
    scene = kept[key]
    if not measurement.points:
        return scene
    names = scene.entry_names("contacts")
    for name in measurement.points:
        if name not in names:
            raise UnknownNameError.among("contact", str(name), names)
    contacts: list[Any] = list(scene.contacts)
    for name, point in measurement.points.items():
        index = names.index(name)
        contacts[index] = replace(contacts[index], at=point)
    return replace(scene, contacts=contacts)


def changed_scene(
    scene: Scene, parameters: Sequence[Parameter], x: np.ndarray, group: str = ""
) -> Scene:
    """Return a scene with the values x (P,) of the unknowns, those of a group of measurements."""
    changes: dict[str, dict[str, Any]] = {}
    bodies: dict[str, dict[int, float]] = {}
    acting: dict[str, dict[str, Any]] = {}
    for parameter, value in zip(parameters, x.tolist(), strict=True):
        if parameter.kind == "force":
            acting.setdefault(parameter.entry, {})[FORCE_PARAMETERS[parameter.index]] = value
        if parameter.kind == "inertia":
            bodies.setdefault(parameter.entry, {})[parameter.index] = value
        if parameter.group not in (None, group):
            continue
        for name in parameter.contacts:
            own = changes.setdefault(name, {})
            if parameter.speeds:
                own.setdefault("restitution", {})[parameter.index] = value
            else:
                own[parameter.kind] = value
    contacts = []
    for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True):
        own = dict(changes.get(name, {}))
        if isinstance(own.get("restitution"), dict):
            given: Any = entry.restitution
            values = tuple(own["restitution"][k] for k in range(len(own["restitution"])))
            own["restitution"] = RestitutionTable(given.speeds, values)
        if isinstance(entry, JointStop | Rope):
            own = {key: value for key, value in own.items() if key == "restitution"}
        contacts.append(replace(entry, **own))
    robot = scene.robot
    if bodies:
        model = pin.Model(robot.model)
        for joint, items in bodies.items():
            joint_id = robot.joint_id(joint)
            values = model.inertias[joint_id].toDynamicParameters()
            for index, value in items.items():
                values[index] = value
            model.inertias[joint_id] = pin.Inertia.FromDynamicParameters(values)
        robot = with_masses(robot, model)
    named = zip(scene.entry_names("forces"), scene.forces, strict=True)
    forces = [replace(each, **acting.get(name, {})) for name, each in named]
    return replace(scene, robot=robot, contacts=contacts, forces=forces)
