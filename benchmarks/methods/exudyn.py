"""Exudyn: the mass matrix of its kinematic tree, one step, its contacts, its motion.

Contacts are Exudyn's sphere on
a triangle: a spring with the damper of Carvalho & Martins and friction that is proportional below
a creep speed, followed by its implicit trapezoidal rule; steps and creep go with the root of
the stiffness. Without friction it goes to every law's answer; with it, to one
about 1 % off Stronge's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from ..problems.problem import Problem
from .mechanism import Mechanism, is_blow, is_flight, is_landing, mechanism_of, third_along
from .method import Answer, Method, approach_speed, half_swing

# Of the triangle that stands for a plane [m].
REACH = 0.1


def add_touch(
    system: Any,
    tree: ExudynTree,
    mechanism: Mechanism,
    item: Any,
    touch: Any,
    radius: float,
    **contact: Any,
) -> None:
    """Give a system one contact of the mechanism.

    Args:
        system: not yet assembled.
        tree, item: of the mechanism in it.
        touch: one of ``mechanism.touches``.
        radius: of the sphere [m]; the plane is met by the point that is nearest to it.
        contact: Exudyn's own words for stiffness, restitution and friction.
    """
    import exudyn as exu
    from exudyn.itemInterface import (
        MarkerBodyRigid,
        NodeGenericData,
        ObjectContactSphereTriangle,
        ObjectGround,
    )

    centre = touch.place + radius * touch.normal
    sphere = system.AddMarker(tree.on_body(mechanism, item, touch.body, centre))
    turn = np.eye(3)
    if touch.other >= 0:
        plane = system.AddMarker(tree.on_body(mechanism, item, touch.other, touch.place))
        turn = (mechanism.rotations[touch.other] @ tree.axes[tree.last[touch.other]]).T
    else:
        ground = system.AddObject(ObjectGround())
        plane = system.AddMarker(MarkerBodyRigid(bodyNumber=ground, localPosition=touch.place))
    first, second = third_along(touch.normal)[:, :2].T
    corners = [
        REACH * (math.cos(angle) * first + math.sin(angle) * second)
        for angle in (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
    ]
    # It was apart before: else the damper takes the impact for one that goes on.
    memory = system.AddNode(
        NodeGenericData(numberOfDataCoordinates=4, initialCoordinates=[radius, 0.0, 0.0, 0.0])
    )
    system.AddObject(
        ObjectContactSphereTriangle(
            markerNumbers=[sphere, plane],
            nodeNumber=memory,
            sphereRadius=radius,
            trianglePoints=exu.Vector3DList([turn @ corner for corner in corners]),
            includeEdges=0,
            **contact,
        )
    )


# A time that no run reaches [s].
NEVER = 1e9


class ExudynTree:
    """The tree in Exudyn's links, one for each degree of freedom.

    Attributes:
        q: (nv,) its coordinates.
        last: of each body, the index of the link that has its inertia.
        axes: of each link (3, 3), from its own axes, whose third is the joint's, to the body's.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.types: list[bool] = []
        self.parents: list[int] = []
        self.transforms: list[np.ndarray] = []
        self.offsets: list[np.ndarray] = []
        self.masses: list[float] = []
        self.centres: list[np.ndarray] = []
        self.inertias: list[np.ndarray] = []
        self.axes: list[np.ndarray] = []
        self.last: list[int] = []
        coordinates = []
        for body in mechanism.bodies:
            link = self.last[body.parent] if body.parent >= 0 else -1
            rotation, offset = body.rotation, body.offset
            for i, (slides, axis) in enumerate(zip(body.slides, body.axes, strict=True)):
                is_last = i == len(body.slides) - 1
                turned = third_along(axis)
                before = self.axes[link].T if link >= 0 else np.eye(3)
                self.types.append(slides)
                self.parents.append(link)
                self.transforms.append(before @ rotation @ turned)
                self.offsets.append(before @ offset)
                self.masses.append(body.mass if is_last else 0.0)
                self.centres.append(turned.T @ body.centre if is_last else np.zeros(3))
                inertia = turned.T @ body.inertia @ turned
                self.inertias.append(inertia if is_last else np.zeros((3, 3)))
                self.axes.append(turned)
                coordinates.append(body.coordinate)
                link = len(self.axes) - 1
                rotation, offset = np.eye(3), np.zeros(3)
            self.last.append(link)
        self.q = np.array(coordinates)

    def system(
        self,
        v: np.ndarray,
        joint_forces: np.ndarray | None = None,
        gravity: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
    ) -> tuple[Any, Any, Any]:
        """Exudyn's container (to be kept), its system, and the tree in it, not yet assembled."""
        import exudyn as exu
        from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree

        count = len(self.q)
        container = exu.SystemContainer()
        system = container.AddSystem()
        node = system.AddNode(
            NodeGenericODE2(
                referenceCoordinates=self.q.tolist(),
                initialCoordinates=[0.0] * count,
                initialCoordinates_t=v.tolist(),
                numberOfODE2Coordinates=count,
            )
        )
        kinds = exu.JointType
        tree = system.AddObject(
            ObjectKinematicTree(
                nodeNumber=node,
                gravity=list(gravity),
                jointTypes=[
                    kinds.PrismaticZ if slides else kinds.RevoluteZ for slides in self.types
                ],
                linkParents=self.parents,
                jointTransformations=exu.Matrix3DList(self.transforms),
                jointOffsets=exu.Vector3DList(self.offsets),
                linkInertiasCOM=exu.Matrix3DList(self.inertias),
                linkCOMs=exu.Vector3DList(self.centres),
                linkMasses=self.masses,
                jointForceVector=[] if joint_forces is None else joint_forces,
            )
        )
        return container, system, tree

    def on_body(self, mechanism: Mechanism, item: Any, body: int, place: np.ndarray) -> Any:
        """The marker of a point of a body, given by its place in the world."""
        from exudyn.itemInterface import MarkerKinematicTreeRigid

        link = self.last[body]
        at = mechanism.rotations[body].T @ (place - mechanism.places[body])
        return MarkerKinematicTreeRigid(
            objectNumber=item, linkNumber=link, localPosition=self.axes[link].T @ at
        )


def struck_system(
    mechanism: Mechanism, tree: ExudynTree, v: np.ndarray, over: float
) -> tuple[Any, Any]:
    """A system, and its container, whose loads give the blows over a time [s].

    The tree's own linkForces do not act on the joints as they should (1.13.6): loads do.
    """
    from exudyn.itemInterface import LoadForceVector, LoadTorqueVector

    container, system, item = tree.system(v, mechanism.joint_impulse / over)
    for blow in mechanism.blows:
        marker = system.AddMarker(tree.on_body(mechanism, item, blow.body, blow.place))
        system.AddLoad(LoadForceVector(markerNumber=marker, loadVector=blow.linear / over))
        system.AddLoad(LoadTorqueVector(markerNumber=marker, loadVector=blow.angular / over))
    system.Assemble()
    return container, system


def exudyn_settings(step: float, steps: int) -> Any:
    import exudyn as exu

    exu.config.printToConsole = False
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = step * steps
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = NEVER
    return settings


NEEDS = ("exudyn",)
STEP = 1e-6
# Exudyn wants a restitution above zero.
LEAST = 1e-3
# Half swings that are followed: an impact, and those it sets off.
LASTS = 3.0
# Steps times contacts times the size of the matrices: about a second.
MOST_WORK = 5e4
# Approaches below this share of the fastest have no restitution.
SLOWEST = 1e-6


def _by_mass_matrix(problem: Problem) -> Answer:
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree = ExudynTree(mechanism)
    # At rest, so that the loads are all there is on the right.
    still = np.zeros(len(tree.q))
    container, system = struck_system(mechanism, tree, still, 1.0)
    solver = exu.MainSolverImplicitSecondOrder()
    solver.InitializeSolver(system, exudyn_settings(1.0, 1))
    q, v, size = np.zeros(len(tree.q)), mechanism.v, len(tree.q)
    data, current = system.systemData, exu.ConfigurationType.Current

    def velocity_after() -> np.ndarray:
        data.SetODE2Coordinates(q, current)
        solver.ComputeMassMatrix(system)
        solver.ComputeODE2RHS(system)
        momentum = solver.GetSystemResidual()[:size]
        return v + np.linalg.solve(solver.GetSystemMassMatrix(), momentum)

    # The container owns what the solver points into.
    velocity_after.owner = container  # type: ignore[attr-defined]
    return velocity_after


def _by_motion(problem: Problem, step: float, solver: str) -> Answer:
    """The jump by the mass matrix, then steps of one of Exudyn's solvers."""
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree, after_blow = ExudynTree(mechanism), _by_mass_matrix(problem)
    container, system, _ = tree.system(mechanism.v, gravity=problem.scene.gravity)
    system.Assemble()
    steps = max(1, round(problem.duration / step))
    settings = exudyn_settings(problem.duration / steps, steps)
    data, moments = system.systemData, exu.ConfigurationType

    def state_after() -> np.ndarray:
        data.SetODE2Coordinates_t(after_blow(), moments.Initial)
        system.SolveDynamic(
            settings, solverType=getattr(exu.DynamicSolverType, solver), showHints=False
        )
        q = tree.q + data.GetODE2Coordinates(moments.Current)
        return np.concatenate([q, data.GetODE2Coordinates_t(moments.Current)])

    state_after.owner = container  # type: ignore[attr-defined]
    return state_after


def _suits_motion(problem: Problem) -> bool:
    """Joints of one degree of freedom alone: others are turned through angles that end."""
    robot = problem.scene.robot
    return is_flight(problem) and robot.nq == robot.nv


def _by_step(problem: Problem) -> Answer:
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree = ExudynTree(mechanism)
    container, system = struck_system(mechanism, tree, mechanism.v, STEP)
    return _solved(container, system, exudyn_settings(STEP, 1), exu.DynamicSolverType.ExplicitEuler)


def _solved(container: Any, system: Any, settings: Any, solver: Any) -> Answer:
    """The velocities at the end of a run of Exudyn's."""
    import exudyn as exu

    def velocity_after() -> np.ndarray:
        try:
            system.SolveDynamic(settings, solverType=solver, showHints=False)
        except exu.SolverError:
            return np.full(system.systemData.ODE2Size(), np.nan)
        return np.array(system.systemData.GetODE2Coordinates_t(exu.ConfigurationType.Current))

    velocity_after.owner = container  # type: ignore[attr-defined]
    return velocity_after


def _by_contacts(problem: Problem, stiffness: float) -> Answer:
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree = ExudynTree(mechanism)
    container, system, item = tree.system(mechanism.v)
    approach = approach_speed(problem, mechanism)
    swing = half_swing(problem, mechanism, stiffness)
    # The middle of the sphere stays in front of the triangle.
    radius = 2.0 * approach * swing

    for touch in mechanism.touches:
        add_touch(
            system,
            tree,
            mechanism,
            item,
            touch,
            radius,
            dynamicFriction=touch.friction,
            frictionProportionalZone=approach / math.sqrt(stiffness),
            contactStiffness=stiffness,
            restitutionCoefficient=max(touch.restitution, LEAST),
            minimumImpactVelocity=SLOWEST * approach,
            impactModel=2,
        )
    system.Assemble()
    steps = int(LASTS * math.sqrt(stiffness))
    settings = exudyn_settings(LASTS * swing / steps, steps)
    settings.timeIntegration.newton.useModifiedNewton = False
    return _solved(container, system, settings, exu.DynamicSolverType.TrapezoidalIndex2)


def _suits_contacts(problem: Problem, stiffness: float) -> bool:
    work = math.sqrt(stiffness) * len(problem.scene.contacts) * problem.scene.robot.nv**2
    return is_landing(problem) and work <= MOST_WORK


METHODS: tuple[Method, ...] = (
    Method("exudyn, mass matrix", is_blow, _by_mass_matrix, peer=True, needs=NEEDS),
    Method("exudyn, one step", is_blow, _by_step, peer=True, needs=NEEDS, setting=STEP),
    *(
        Method(
            "exudyn, contacts",
            partial(_suits_contacts, stiffness=stiffness),
            partial(_by_contacts, stiffness=stiffness),
            peer=True,
            needs=NEEDS,
            setting=stiffness,
        )
        for stiffness in (1e3, 1e4, 1e5, 1e6, 1e7)
    ),
    *(
        each
        for name, solver, steps in (
            ("generalized alpha", "GeneralizedAlpha", (1e-3, 1e-4)),
            ("RK44", "RK44", (4e-3, 1e-3, 2.5e-4)),
        )
        for each in Method(
            f"exudyn, {name}",
            _suits_motion,
            partial(_by_motion, solver=solver),
            peer=True,
            needs=NEEDS,
        ).at(steps)
    ),
)
