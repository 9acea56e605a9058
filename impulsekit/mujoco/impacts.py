"""``Impacts``: steps of MuJoCo in which contacts hit with restitution."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any, Literal

import mujoco
import numpy as np

from .._core import ClosingGaps
from ..errors import InputError, RangeError, ShapeError, check_kind, warn_of_setup
from ..scene.law import Law
from ..scene.numbers import between, not_negative
from .coefficients import PairCoefficients
from .instant import TOUCHING, find_instant
from .listing import KEPT, StepModels
from .record import StepImpact
from .system import ImpactSolver

__all__ = ["Impacts"]

# Impacts within one step; a step with more ends as MuJoCo has it, with a doubt.
MOST_IMPACTS = 32
_get_state, _step1, _step2 = mujoco.mj_getState, mujoco.mj_step1, mujoco.mj_step2
_forward_skip, _check_acceleration = mujoco.mj_forwardSkip, mujoco.mj_checkAcc
_runge_kutta, _VELOCITIES = mujoco.mj_RungeKutta, int(mujoco.mjtStage.mjSTAGE_VEL)
_RK4 = int(mujoco.mjtIntegrator.mjINT_RK4)
_INTEGRATORS = {
    int(kind)
    for kind in (
        mujoco.mjtIntegrator.mjINT_EULER,
        mujoco.mjtIntegrator.mjINT_RK4,
        mujoco.mjtIntegrator.mjINT_IMPLICIT,
        mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    )
}


class Impacts:
    """Steps of MuJoCo in which contacts hit with restitution, by the laws of impulsekit.

    ``step(data)`` stands for ``mujoco.mj_step(model, data)``. Where a pair of geoms comes to
    touch faster than ``threshold`` during a step, the step is taken back, its instant is found,
    the impact of all that touches then is solved (M Δv = Aᵀλ + JᵀP, M with armature, equalities
    as bilateral rows, resting contacts and limits as rows too), and the step goes on from there.
    Slower contacts and rest stay MuJoCo's own; a step without an impact gives MuJoCo's bits.

    After ``step``, positions, contacts and sensors of positions and velocities in ``data`` are
    those of the new state, as after ``mj_step`` and ``mj_step1``.

    Args:
        model: a ``mujoco.MjModel``, of which copies are kept: changes of it that are made
            later count after ``Impacts`` is made anew.
        restitution: e of all geoms, 0 to 1; a function of the approach speed or a
            ``RestitutionTable``; a mapping from names of geoms, bodies or pairs of them
            (others have 0); or "user", the first ``user`` value of each geom.
        friction: µ of all contacts; None: MuJoCo's own, slip along both tangents, spin and
            rolling by ``condim``, on the elliptic cone whatever ``cone`` says.
        combine: how the values of two geoms make that of the pair: "max", "min", "average",
            "multiply". A value given for the pair itself counts alone.
        pairs: names of geoms or bodies, or pairs of them, that are treated; None for all.
        limits: e of the limits of joints and tendons; None leaves their own impacts to MuJoCo.
            Those that are reached when a contact hits bear load as resting contacts do.
        law: one that takes several contacts without stiffnesses.
        threshold: approach speed [m/s] above which a contact is an impact; None for
            max(0.05, 2 g dt), below which MuJoCo's soft contact takes the speed within a step.
        instant: "exact", or "step": the impulse acts at the start of the step in which a pair
            would touch, without taking the step back twice; positions err by v dt at most, e
            is exact.

    Attributes:
        last: the impacts of the last step, ``StepImpact`` each.
        doubts: sentences on what the model holds that is not treated as one may expect.

    Raises:
        InputError: what cannot be treated: flexes, speculative contacts, sleeping or the IPC
            solver switched on, contacts switched off, a law that needs stiffnesses.
        UnknownNameError, RangeError, NotFiniteError: what is wrong with a coefficient.
        MissingExtraError: mujoco is not installed (``pip install "impulsekit[mujoco]"``).

    Example:
        >>> import mujoco
        >>> model = mujoco.MjModel.from_xml_string('''<mujoco><option integrator="RK4"/>
        ...   <worldbody><geom name="floor" type="plane" size="1 1 .1"/><body pos="0 0 .5">
        ...   <freejoint/><geom name="ball" size=".1"/></body></worldbody></mujoco>''')
        >>> data = mujoco.MjData(model)
        >>> impacts = Impacts(model, restitution=0.5)
        >>> while not impacts.last:
        ...     impacts.step(data)
        >>> hit = impacts.last[0]
        >>> print(hit.pairs[0], (hit.separation / hit.approach).round(12))
        ('floor', 'ball') [0.5]
    """

    def __init__(
        self,
        model: Any,
        restitution: Any,
        friction: float | None = None,
        *,
        combine: str = "max",
        pairs: Any = None,
        limits: float | None = None,
        law: Law | None = None,
        threshold: float | None = None,
        instant: Literal["exact", "step"] = "exact",
    ) -> None:
        law = Law() if law is None else law
        check_kind(model, mujoco.MjModel, "Impacts")
        check_kind(law, Law, "Impacts: law")
        if instant not in ("exact", "step"):
            raise RangeError.of("instant", instant, '"exact" or "step"')
        _refuse(model, law)
        self._models = StepModels(copy.copy(model))
        self._limits = None if limits is None else between(0.0, 1.0)(limits, "limits")
        self._coefficients = PairCoefficients(
            model, restitution, friction, combine, pairs, self._limits
        )
        self._solver = ImpactSolver(self._models.plain, self._coefficients, law)
        self._is_exact = instant == "exact"
        gravity = float(np.linalg.norm(model.opt.gravity))
        default = max(0.05, 2.0 * gravity * model.opt.timestep)
        self.threshold = default if threshold is None else not_negative(threshold, "threshold")
        self.last: tuple[StepImpact, ...] = ()
        self.doubts = tuple(_doubts_of(model))
        warn_of_setup(self.doubts)
        self._is_rk4 = model.opt.integrator == _RK4
        self._has_gaps = bool(model.geom_gap.any() or model.pair_gap.any())
        self._state = np.empty(mujoco.mj_stateSize(model, KEPT))
        self._left, self._data = b"", None
        self._touching, self._reached = b"", 0
        self._log: list[StepImpact] | None = None
        self._shape = (model.nq, model.nv, model.nbody, model.ngeom)

    def step(self, data: Any) -> None:
        """Advance ``data`` by one time step, as ``mujoco.mj_step`` does, with impacts.

        Raises:
            InputError: not an ``MjData``. ShapeError: data of another model.
        """
        model, state = self._models.plain, self._state
        if data is not self._data:
            self._check(data)
            self._left, self._data = b"", data
        _get_state(model, data, state, KEPT)
        start = state.tobytes()
        if start != self._left:
            _step1(model, data)
            self._touching, self._reached = self._pairs_touching(data), data.nl
        # One step from a state whose positions and velocities MuJoCo has looked at.
        if self._is_rk4:
            _forward_skip(model, data, _VELOCITIES, 0)
            _check_acceleration(model, data)
            _runge_kutta(model, data, 4)
        else:
            _step2(model, data)
        _step1(model, data)
        self.last = ()
        touching = self._pairs_touching(data)
        if touching != self._touching or (self._limits is not None and data.nl > self._reached):
            self._resolve(data, np.frombuffer(start))
            touching = self._pairs_touching(data)
        self._touching, self._reached = touching, data.nl
        _get_state(model, data, state, KEPT)
        self._left = state.tobytes()

    def log(self, keep: bool = True) -> list[StepImpact]:
        """Begin to keep all impacts from now on, or stop, and return the list that grows."""
        kept: list[StepImpact] = [] if self._log is None else self._log
        self._log = kept if keep else None
        return kept

    def _check(self, data: Any) -> None:
        check_kind(data, mujoco.MjData, "Impacts.step")
        shape = (len(data.qpos), len(data.qvel), len(data.xpos), len(data.geom_xpos))
        if shape != self._shape:
            raise ShapeError.of("data (nq, nv, nbody, ngeom)", self._shape, shape)

    def _pairs_touching(self, data: Any) -> bytes:
        """The pairs of contacts that touch, to be compared with those of another state."""
        if not data.ncon:
            return b""
        contact = data.contact
        pairs = contact.geom[contact.exclude != 1] if self._has_gaps else contact.geom
        return pairs.tobytes()

    def _resolve(self, data: Any, start: np.ndarray) -> None:
        """Solve the impacts of a step that has been taken from ``start``."""
        models = self._models
        left, end = models.plain.opt.timestep, data.time
        known = np.frombuffer(self._touching, dtype=np.int64).tolist()
        # Stages of a Runge-Kutta method have felt the soft contact: the speed now says little.
        slowest = -np.inf if self._is_rk4 else self.threshold
        reached = self._reached
        found: list[StepImpact] = []
        while len(found) < MOST_IMPACTS:
            limits = reached if self._limits is not None else models.plain.nv
            gaps = ClosingGaps(
                models.look(data, 0.0), known, limits, self._coefficients.handled, slowest
            )
            if not gaps.count:
                break
            passed, listing, hits = find_instant(
                models, data, start, left, gaps, self.threshold, self._is_exact
            )
            if hits:
                which = listing.within(TOUCHING, hits)
                impact = self._solver.solve(data, listing, which)
                data.qvel[:] += impact.dv
                found.append(impact)
                keys = listing.keys(which)
                known += keys
                reached = len(which) - len(keys)
                left -= passed
                start = np.empty_like(start)
                _get_state(models.plain, data, start, KEPT)
            else:
                models.restore(data, start)
            models.step(data, left)
            if not hits or not impact.status.valid:
                break
        # Contacts and rows as the plain model has them, for the next step.
        _step1(models.plain, data)
        if found:
            data.time = end
        self.last = tuple(found)
        if self._log is not None:
            self._log += found


def _refuse(model: Any, law: Law) -> None:
    """Raise an error for what cannot be treated."""
    bits, off = mujoco.mjtEnableBit, mujoco.mjtDisableBit
    for flag, what in (
        (bits.mjENBL_SPECULATIVE, "speculative contacts, whose distances are not those of geoms"),
        (bits.mjENBL_SLEEP, "sleeping trees, which impacts do not wake"),
        (bits.mjENBL_IPC, "the IPC solver, in which nothing touches"),
    ):
        if model.opt.enableflags & flag:
            raise InputError(f"Impacts cannot be used with {what}: switch that flag off")
    if model.opt.disableflags & (off.mjDSBL_CONTACT | off.mjDSBL_CONSTRAINT):
        raise InputError("Impacts: contacts are switched off in the model's flags")
    if model.nflex:
        raise InputError("Impacts: the model has flexes, whose vertices are not treated")
    if model.opt.integrator not in _INTEGRATORS:
        name = mujoco.mjtIntegrator(model.opt.integrator).name
        raise InputError(f"Impacts: integrator {name} steps and contacts at once; choose another")
    if law.restitution == "lzb":
        raise InputError(
            'Impacts: law "lzb" needs a stiffness of each contact; use "newton", "poisson" or '
            '"stronge"'
        )


def _doubts_of(model: Any) -> Iterator[str]:
    """Sentences on what is treated otherwise than one may expect."""
    geom = mujoco.mjtGeom
    flat = np.isin(model.geom_type, [geom.mjGEOM_MESH, geom.mjGEOM_CYLINDER])
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_MULTICCD and (flat & solid).any():
        yield (
            "meshes or cylinders collide with multiccd switched off: lying flat they have one "
            "contact that jumps from corner to corner"
        )
    rolling = model.pair_friction[:, 3:]
    if (rolling[:, 0] != rolling[:, 1]).any():
        yield "the two rolling frictions of a contact count by their mean, without direction"
