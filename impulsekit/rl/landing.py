"""``Landing``: how hard feet would land, for rewards and penalties of learning, in torch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
import torch

from ..batch.differentiable import Differentiable
from ..batch.solve import solve_batch
from ..errors import InputError, UnknownNameError, check_kind, quoted
from ..errors.calls import public
from ..impact.status import BY_CODE
from ..robot import Robot
from ..robot.mjcf import read_mjcf
from ..scene import Contact, Scene
from ..scene.numbers import positive
from .feet import lowest_points
from .layout import Columns, Layout

__all__ = ["OUTPUTS", "Landing"]

OUTPUTS = ("impulse", "lost_energy", "joint_impulse", "gear_torque")
_VALID = np.array([code in BY_CODE and BY_CODE[code].valid for code in range(64)])


@public
class Landing:
    """The impact of feet on the floor at many states, as if all of them touched now.

    Called with q (N, nq) and v (N, nv), it returns a dict of tensors (N, ...), on the device and
    in the type of v. A value depends on the state alone, on no time step. Everything is computed
    on the processor in float64; gradients by q and v of "impulse", "lost_energy" and
    "gear_torque" come from ``impulsekit.vjp``, "joint_impulse" has none.

    Args:
        robot: of the model that is learned on.
        feet: names of frames whose origins touch the floor z = 0, or ``Contact`` entries, which
            keep their own coefficients.
        restitution, friction: of the feet that are given by name.
        layout: "mujoco", "isaac", "pinocchio", or a ``Layout`` with the order of joints.
        controlled: joints under stiff control, as in ``Scene``.
        outputs: "impulse": (N, feet, 3) [N s] what each foot receives, world axes;
            "lost_energy": (N,) [J] kinetic energy lost; "joint_impulse": (N, joints, 6) the wrench
            [N s, N m s] that each joint of ``joints`` carries, linear before angular, world axes;
            "gear_torque": (N, gears) [N m] the peak torque Δω √(k J) in each gear, where J is the
            rotor's inertia on the joint's side. "valid" (N,) is always there; other rows hold NaN.
        gear_stiffness: by joint, k of its gear on the joint's side [N m/rad].

    Attributes:
        scene: the scene that is solved. joints: names of the axis of "joint_impulse".

    Raises:
        UnknownNameError: no such foot, joint, layout or output.
        InputError: "gear_torque" without gear_stiffness or rotor inertia; no feet.

    Example:
        >>> import torch
        >>> from impulsekit import Robot
        >>> from impulsekit.rl import Landing
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> landing = Landing(ball, ["ball"], friction=0.6, layout="mujoco")
        >>> q = torch.tensor([[0, 0, 0.1, 1, 0, 0, 0.0]])
        >>> out = landing(q, torch.tensor([[0, 0, -2.0, 0, 0, 0]]))
        >>> out["lost_energy"].tolist()  # m v²/2, of 0.5 kg
        [1.0]
    """

    def __init__(
        self,
        robot: Robot,
        feet: Sequence[str | Contact],
        restitution: float = 0.0,
        friction: float = 0.6,
        layout: str | Layout = "mujoco",
        controlled: Sequence[str] = (),
        outputs: Sequence[str] = OUTPUTS[:2],
        gear_stiffness: Mapping[str, float] | None = None,
    ) -> None:
        check_kind(robot, Robot, "Landing: robot")
        if isinstance(feet, str) or not len(feet):
            raise InputError(f"Landing: feet must be a list of names, got {quoted(feet)}")
        contacts = [
            foot
            if isinstance(foot, Contact)
            else Contact(foot, restitution=restitution, friction=friction, name=str(foot))
            for foot in feet
        ]
        for name in outputs:
            if name not in OUTPUTS:
                raise UnknownNameError.among("output", str(name), OUTPUTS)
        self.scene = Scene(robot, contacts=contacts, controlled=controlled, gap_bound=np.inf)
        self.outputs, self.joints = tuple(outputs), robot.joint_names
        self._columns = Columns(robot, layout if isinstance(layout, Layout) else Layout(layout))
        self._gears = _gears(robot, gear_stiffness) if "gear_torque" in outputs else None
        self._solve = _Solver(self.scene, "joint_impulse" in outputs)

    @classmethod
    def from_mujoco(cls, model: Any, feet: Sequence[str], **given: Any) -> Landing:
        """Return the landing of a MuJoCo model, of feet that are names of its sites or geoms.

        A sphere, capsule or box touches with its lowest points in the model's reference pose
        ``qpos0``, which stay fixed on their body; other geoms by their centres.

        Args:
            model: a ``mujoco.MjModel``, or what else ``Robot.from_mjcf`` takes.
            feet: names of sites or geoms. given: as of ``Landing``; restitution and friction
                numbers.

        Example:
            >>> ball = '<body name="b"><freejoint/><geom name="foot" size="0.1"/></body>'
            >>> text = f"<mujoco><worldbody>{ball}</worldbody></mujoco>"
            >>> Landing.from_mujoco(text, ["foot"]).scene.contacts[0].at
            (0.0, 0.0, -0.1)
        """
        compiled = read_mjcf(model)[0]
        e, mu = given.pop("restitution", 0.0), given.pop("friction", 0.6)
        contacts = [
            Contact(body, at=at, restitution=e, friction=mu, name=name)
            for foot in feet
            for name, body, at in lowest_points(compiled, foot)
        ]
        return cls(Robot.from_mjcf(compiled), contacts, **given)

    def __call__(
        self, q: torch.Tensor, v: torch.Tensor, *, gap: float | None = None
    ) -> dict[str, torch.Tensor]:
        """Return the outputs by name at N states.

        Args:
            q, v: (N, nq), (N, nv) in the layout.
            gap: a height h [m]: outputs are multiplied by exp(−g/h), where g ≥ 0 is the height of
                the lowest foot, so that a reward weighs a landing before it happens. Gradients
                take this weight as constant.

        Raises:
            InputError: no tensors. ShapeError: of another shape.
            RangeError: a gap that is not above zero.
        """
        own_q, own_v = self._columns.taken(q, v)
        after, impulse, lost, loads, gaps, valid = _Land.apply(self._solve, own_q, own_v)
        found = {"impulse": impulse, "lost_energy": lost, "joint_impulse": loads}
        if self._gears is not None:
            place, root = (each.to(v.device) for each in self._gears)
            found["gear_torque"] = (after - own_v)[:, place].abs() * root
        weight = torch.ones_like(lost)
        if gap is not None:
            lowest = gaps.amin(dim=1).clamp(min=0.0)
            weight = torch.exp(-lowest / positive(gap, "gap"))
        kind = v.dtype if v.is_floating_point() else torch.float64
        out = {
            name: (found[name] * weight.reshape(-1, *[1] * (found[name].ndim - 1))).to(kind)
            for name in self.outputs
        }
        return {**out, "valid": valid}


class _Solver:
    """Impacts, and their gradients, of arrays in Pinocchio's layout."""

    def __init__(self, scene: Scene, with_loads: bool) -> None:
        self.scene = scene
        self._own = Differentiable(scene, ())
        loads = ("reactions",) if with_loads else ()
        self._outputs = ("v_after", "contact_impulses", "energy_change", "gaps", *loads)
        self._model = pin.Model(scene.robot.model)
        self._model.gravity.setZero()
        self._data = self._model.createData()

    def forward(self, q: np.ndarray, v: np.ndarray) -> list[np.ndarray]:
        """v⁺, impulses, energy lost, wrenches of joints, gaps, and which rows are valid."""
        found = solve_batch(self.scene, q, v, outputs=self._outputs)
        loads = found.arrays.get("reactions", np.zeros((len(q), 0, 6)))
        return [
            found.v_after, found.contact_impulses, -found.energy_change, loads,
            found.arrays["gaps"], _VALID[found.status],
        ]  # fmt: skip

    def backward(
        self, q: np.ndarray, v: np.ndarray, after: np.ndarray, cotangents: Sequence[np.ndarray]
    ) -> list[np.ndarray]:
        """Gradients by q and v, of cotangents of v⁺, impulses and energy lost."""
        of_after, of_impulses, of_lost = cotangents
        direct_v, slopes = np.zeros_like(v), np.zeros_like(v)
        unit = self._own.unit(q)
        for i in np.flatnonzero(of_lost):
            if np.isfinite(after[i]).all():
                (slope, momentum), (slope_after, momentum_after) = (
                    self._energy_slopes(unit[i], each) for each in (v[i], after[i])
                )
                direct_v[i] = of_lost[i] * momentum
                slopes[i] = of_lost[i] * (slope - slope_after)
                of_after[i] -= of_lost[i] * momentum_after
        given = {"v_after": of_after, "contact_impulses": of_impulses.reshape(len(q), -1)}
        by_q, by_v = self._own.pull([q, v], given)
        return [by_q + self._own.by_entries(q, unit, slopes), by_v + direct_v]

    def _energy_slopes(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Slopes of T = vᵀM(q)v/2 by the tangent of q and by v; of M v Pinocchio has the former."""
        rest = np.zeros_like(v)
        by_q, _, mass = pin.computeRNEADerivatives(self._model, self._data, q, rest, v)
        return 0.5 * v @ by_q, mass @ v


class _Land(torch.autograd.Function):
    """Forward and backward on the core's threads, in float64."""

    @staticmethod
    def forward(ctx: Any, solver: _Solver, q: torch.Tensor, v: torch.Tensor) -> Any:
        found = solver.forward(*(each.detach().cpu().numpy() for each in (q, v)))
        tensors = [torch.from_numpy(np.array(own)).to(v.device) for own in found]
        ctx.solver = solver
        ctx.save_for_backward(q, v, tensors[0])
        ctx.mark_non_differentiable(*tensors[3:])
        return tuple(tensors)

    @staticmethod
    def backward(ctx: Any, *cotangents: Any) -> Any:
        arrays = [each.detach().cpu().numpy() for each in ctx.saved_tensors]
        given = [np.nan_to_num(each.detach().cpu().numpy()) for each in cotangents[:3]]
        device = ctx.saved_tensors[1].device
        found = ctx.solver.backward(*arrays, given)
        return None, *(torch.from_numpy(each).to(device) for each in found)


def _gears(
    robot: Robot, stiffness: Mapping[str, float] | None
) -> tuple[torch.Tensor, torch.Tensor]:
    """The places in v of joints with a gear, and √(k J) of each."""
    if not isinstance(stiffness, Mapping) or not stiffness:
        raise InputError(
            'output "gear_torque" is Δω √(k J): give gear_stiffness={joint: k}, k [N m/rad] on the '
            "joint's side"
        )
    places, roots = [], []
    for name, k in stiffness.items():
        joint = robot.model.joints[robot.joint_id(name, "gear_stiffness")]
        if joint.nv != 1:
            raise InputError(f'gear_stiffness: joint "{name}" has {joint.nv} degrees of freedom')
        rotor = float(robot.model.armature[joint.idx_v])
        if not rotor > 0.0:
            raise InputError(
                f'output "gear_torque": the rotor inertia of joint "{name}" is unknown; give it by '
                "robot.with_armature({joint: J}, gear={joint: ratio}), or armature in MJCF"
            )
        places.append(joint.idx_v)
        roots.append((positive(k, f'gear_stiffness of "{name}"') * rotor) ** 0.5)
    return torch.tensor(places), torch.tensor(roots, dtype=torch.float64)
