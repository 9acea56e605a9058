"""``impulsekit warm-up``: compile everything once, so that nobody waits for it later."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["warm_up"]

_BALL = """<robot name="ball"><link name="ball">
<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius="1"/></geometry></collision></link></robot>"""


@click.command(name="warm-up")
@click.option("--single", is_flag=True, help="Also the kernels of batches in single precision.")
def warm_up(single: bool) -> None:
    """Compile motions and the kernels of batches; prints the processor time of each.

    What is compiled is kept on disk. Without this command things are compiled when first needed.
    """
    import numpy as np

    from ..batch.solve import warm_up as warm_up_scene
    from ..measured.free_body import fly_all, fly_along
    from ..motion.warm import compile_motion

    begin = time.process_time()
    compile_motion()
    click.echo(f"motions: {time.process_time() - begin:.1f} s")
    begin = time.process_time()
    for each in (fly_all, fly_along):
        each.compile()
    click.echo(f"recordings: {time.process_time() - begin:.1f} s")
    for dtype in (np.float64, np.float32) if single else (np.float64,):
        for name, scene in _scenes():
            begin = time.process_time()
            warm_up_scene(scene, dtype=dtype)
            click.echo(f"{name}, {np.dtype(dtype)}: {time.process_time() - begin:.1f} s")


def _scenes() -> Iterator[tuple[str, Scene]]:
    """Scenes that take all kernels together."""
    from ..errors import ImpulsekitError
    from ..robot import Robot
    from ..robot.combine import combine
    from ..scene import AppliedImpulse, Collision, Contact, Law, PointAnchor, Scene
    from ..scene.law import ORDERS, RESTITUTIONS, SLIPS

    ball = Robot.from_urdf(_BALL, root="freeflyer")
    yield "blows", Scene(ball, impulses=[AppliedImpulse("ball", linear=[0, 0, 1])])
    rough = Contact("ball", friction=0.5, stiffness=1.0)
    smooth = Contact("ball", at=[0, 0, -1], stiffness=1.0)
    yield "one contact", Scene(ball, contacts=[rough])
    held = [PointAnchor("ball")]
    yield "constraints", Scene(ball, constraints=held)
    for words in itertools.product(RESTITUTIONS, SLIPS, ORDERS):
        for name, constraints in (("", []), (", held", held)):
            try:
                scene = Scene(ball, [], constraints, [rough, smooth], law=Law(*words))
            except ImpulsekitError:
                # Words that cannot go together.
                continue
            yield f"{' '.join(words)}{name}", scene
    balls = combine(a=ball, b=ball)
    yield "collisions", Scene(balls, contacts=[Collision("a/ball", "b/ball", friction=0.5)])
