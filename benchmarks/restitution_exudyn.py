"""The sphere of ``benchmarks.restitution`` in Exudyn, whose contacts take e themselves.

Its contact of a sphere and a triangle is a spring with the damper of Carvalho & Martins; its
implicit trapezoidal rule shortens steps where contact begins and ends.
"""

from __future__ import annotations

from typing import Any

import numpy as np

# Friction is proportional below this speed [m/s].
CREEP = 1e-3
# Of the triangle that stands for the plane [m].
REACH = 20.0
# Approaches below this speed have no restitution [m/s].
SLOWEST = 1e-3


def sphere_in_exudyn(
    e: float, stiffness: float, dt: float, *, radius: float, height: float, friction: float,
    v: tuple[float, float, float], gravity: float, duration: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Return heights of the centre, velocities, ω and forces of a sphere of 1 kg, by step."""
    import exudyn as exu
    from exudyn import itemInterface as items
    from exudyn.utilities import InertiaSphere

    from .methods.exudyn import exudyn_settings

    container = exu.SystemContainer()
    system: Any = container.AddSystem()
    sphere = system.CreateRigidBody(
        inertia=InertiaSphere(1.0, radius), referencePosition=[0, 0, radius + height],
        initialVelocity=list(v), gravity=[0, 0, -gravity],
    )  # fmt: skip
    ground = system.AddObject(items.ObjectGround())
    markers = [
        system.AddMarker(items.MarkerBodyRigid(bodyNumber=body)) for body in (sphere, ground)
    ]
    # It is apart at first: else the damper takes the impact for one that goes on.
    memory = system.AddNode(
        items.NodeGenericData(numberOfDataCoordinates=4, initialCoordinates=[radius, 0, 0, 0])
    )
    corners = [[-REACH, -REACH, 0], [2 * REACH, -REACH, 0], [-REACH, 2 * REACH, 0]]
    contact = system.AddObject(
        items.ObjectContactSphereTriangle(
            markerNumbers=markers, nodeNumber=memory, sphereRadius=radius, includeEdges=0,
            trianglePoints=exu.Vector3DList(corners), dynamicFriction=friction,
            frictionProportionalZone=CREEP, contactStiffness=stiffness, restitutionCoefficient=e,
            minimumImpactVelocity=SLOWEST, impactModel=2,
        )
    )  # fmt: skip
    kinds = exu.OutputVariableType
    sensors = [
        items.SensorBody(bodyNumber=sphere, outputVariableType=kind, storeInternal=True)
        for kind in (kinds.Position, kinds.Velocity, kinds.AngularVelocity)
    ]
    force = {"objectNumber": contact, "outputVariableType": kinds.Force}
    sensors.append(items.SensorObject(**force, storeInternal=True))
    numbers = [system.AddSensor(sensor) for sensor in sensors]
    system.Assemble()
    settings = exudyn_settings(dt, round(duration / dt))
    settings.solution.sensors.writePeriod = dt
    settings.timeIntegration.newton.useModifiedNewton = False
    system.SolveDynamic(
        settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2, showHints=False
    )
    at, velocity, omega, force = (system.GetSensorStoredData(i)[:, 1:] for i in numbers)
    return at[:, 2], velocity, omega, np.linalg.norm(force, axis=1)
