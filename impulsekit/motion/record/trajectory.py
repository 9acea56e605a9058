"""``Trajectory``: a motion, its impacts, and what follows from it."""

from __future__ import annotations

import math
import os
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ...errors.calls import public
from ...formatting import one_line
from ...impact import Impact
from ...named import ByName
from ...scene import Scene
from . import histories
from .sampled import SampledMotion

if TYPE_CHECKING:
    from .balance import MomentumBalance
    from .comparing import Comparison, Recorded
    from .energies import EnergyHistory, MomentumHistory
    from .histories import ConstraintHistory, ContactHistory, ForceHistory, JointHistory

__all__ = ["Trajectory"]


@public
class Trajectory(SampledMotion):
    """The motion of a robot, as returned by ``impulsekit.simulate``.

    Attributes:
        scene: the scene.
        t: (T,) sample times [s].
        q: (T, nq) configurations; v: (T, nv) velocities. Where an impact happens at a
            sample, they are the values just after it.
        impacts: (time [s], ``Impact``) in order of time.
        rests: the intervals in which contacts were at rest.
        status: how the motion ended; the part computed until then is always kept.
        settings: the method, tolerances and limits of the simulation.
        steps: number of integrator steps.
        evaluations: number of evaluations of the accelerations.

    Example:
        >>> from impulsekit import Robot, Scene, simulate
        >>> panda = Robot.from_example("panda")
        >>> motion = simulate(Scene(panda), panda.neutral(), panda.velocity(), duration=0.1)
        >>> motion.q.shape, motion.status.finished
        ((201, 9), True)
    """

    @cached_property
    def ambiguous(self) -> tuple[tuple[float, Impact], ...]:
        """(time [s], ``Impact``) of the impacts at which the law leaves several v⁺ open.

        The motion is one of those that the law allows; computed on first access, from
        ``Impact.uniqueness``.
        """
        return tuple(hit for hit in self.impacts if hit[1].uniqueness.several)

    @cached_property
    def contacts(self) -> ByName[ContactHistory]:
        """By the name of a contact: its impacts, and its forces while it rested.

        ``motion.contacts["floor"]`` is the tuple of (time [s], ``ContactResult``) of each impact
        in which it touched, and has ``force(t)``, ``points(t)``, ``impulse``, ``work``.

        Raises:
            UnknownNameError: on a name that no contact of the scene has.
        """
        return ByName(histories.of_contacts(self), "contact")

    @cached_property
    def constraints(self) -> ByName[ConstraintHistory]:
        """By the name of a constraint: its impacts, and its forces between them.

        Raises:
            UnknownNameError: on a name that no constraint of the scene has.
        """
        return ByName(histories.of_constraints(self), "constraint")

    @cached_property
    def forces(self) -> ByName[ForceHistory]:
        """By the name of a spring, actuator or applied force: what it gave, and its work.

        Raises:
            UnknownNameError: on a name that no force of the scene has.
        """
        return ByName(histories.of_forces(self), "force")

    @cached_property
    def joints(self) -> ByName[JointHistory]:
        """By the name of a joint: what it transmits, ``motion.joints["knee"].reaction(t)``.

        Raises:
            UnknownNameError: on a name that no joint of the robot has.
        """
        return ByName(histories.of_joints(self), "joint")

    def balance(self, start: float | None = None, end: float | None = None) -> MomentumBalance:
        """Return the sources of momentum between two times: forces, and impulses of impacts.

        Args:
            start: after an impact at that time [s]; None for the beginning, before its impacts.
            end: after an impact at that time [s]; None for the end of the motion.

        Raises:
            RangeError: times outside the motion.

        Example:
            >>> from impulsekit import Contact, Robot, Scene, simulate
            >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
            >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5, name="floor")])
            >>> drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
            >>> balance = simulate(scene, drop, ball.velocity(), duration=1).balance()
            >>> round(float(balance.shares["weight"][2] / ball.mass), 9)
            -9.81
            >>> bool(abs(balance.residual).max() < 1e-8)
            True
        """
        from .balance import momentum_balance

        return momentum_balance(self, start, end)

    def energy(self) -> EnergyHistory:
        """Kinetic and potential energies at the sample times."""
        from .energies import energies_of

        return energies_of(self)

    def momentum(self) -> MomentumHistory:
        """Linear and angular momentum at the sample times, the latter about the world's origin."""
        from .energies import momenta_of

        return momenta_of(self)

    def compare(self, recording: Recorded, frame: str | None = None) -> Comparison:
        """Return the distance and angle over time between a frame and the same one of a recording.

        Args:
            recording: a ``Recording`` (times and configurations of a log, of a camera), or another
                ``Trajectory``, of the same robot; what is outside the motion's time is left out.
            frame: whose; by default the first link that moves.

        Raises:
            InputError: no recording of this robot.
            RangeError: none of its times is within the motion.
            UnknownNameError: no such frame.
        """
        from .comparing import compare

        return compare(self, recording, frame)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to an npz file of plain arrays and text; see ``motion.archive``.

        ``t``, ``q`` and ``v`` are readable by numpy alone. The scene stands in it as the
        text of a scene file, the URDFs in full. What no scene file can hold, a function or
        a robot made from a ``pin.Model``, has to be given to ``load``.

        Raises:
            InputError: the path does not end in .npz.
            FileError: nothing can be written there.
        """
        from .saved import save_motion

        save_motion(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str], scene: Scene | None = None) -> Trajectory:
        """Read what ``save`` wrote; nothing in the file is run.

        Args:
            path: the file.
            scene: the scene of the motion; wanted only where the file cannot hold it.

        Raises:
            InputError: no trajectory, one without its scene, or one of another robot.
            OSError: it cannot be read.
        """
        from .saved import load_motion

        return load_motion(cls, path, scene)

    def to_dict(self) -> dict[str, Any]:
        """Return the samples, impacts and rests, ready for JSON; SI units.

        Example:
            >>> from impulsekit import Contact, Robot, Scene, simulate
            >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
            >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5, name="floor")])
            >>> drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
            >>> found = simulate(scene, drop, ball.velocity(), duration=0.5).to_dict()
            >>> found["status"], found["impacts"][0]["contacts"]
            ('FINISHED', ['floor'])
        """
        return {
            "robot": self.scene.robot.name,
            "joints": list(self.scene.robot.joint_names),
            "status": self.status.name,
            "advice": self.status.value,
            "detail": self.detail,
            "duration": self.duration,
            "t": self.t.tolist(),
            "q": self.q.tolist(),
            "v": self.v.tolist(),
            "impacts": [
                {
                    "time": time,
                    "status": impact.status.name,
                    "contacts": [one.name for one in impact.contacts if one.touching],
                    "v_before": impact.v_before.tolist(),
                    "v_after": impact.v_after.tolist(),
                    "energy_change": impact.energy.change,
                }
                for time, impact in self.impacts
            ],
            "rests": [
                {
                    "contact": rest.contact,
                    "start": rest.start,
                    "end": rest.end if math.isfinite(rest.end) else None,
                }
                for rest in self.rests
            ],
        }

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over time: q, v by coordinate name, energies, momenta.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from .tables import state_table

        return state_table(self)

    def events(self) -> Any:
        """An ``xarray.Dataset`` of the impacts (by contact: impulse, mode) and of the rests.

        Along "impact" stand the time, the status, the energy before and its change, and by
        "contact" whether it touched, its mode, and its impulse on the first body in world axes
        [N s]; a joint stop has its one number first, and NaN. Along "rest" stand what rested,
        from when to when; an end that is infinite is after the motion.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from .tables import event_table

        return event_table(self)

    def __repr__(self) -> str:
        name, span = self.scene.robot.name, f"0 to {self.duration:g} s"
        count = f"{len(self.impacts)} impact{'s' if len(self.impacts) != 1 else ''}"
        return one_line("Trajectory", self.status.name, repr(name), span, count)
