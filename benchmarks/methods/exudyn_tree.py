"""A mechanism as Exudyn's kinematic tree in minimal coordinates.

A joint of several degrees of freedom is a row of single ones with links without mass between
them, which stand at zero, so no angles of a floating base come in.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .mechanism import Mechanism, third_along

__all__ = ["ExudynTree", "exudyn_settings", "struck_system"]
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
