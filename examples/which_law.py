"""Which law predicts the impacts of a rod best? They are "measured" with Stronge's law and noise.

A rod hits the floor with its lower end, slips, sticks or slips back. Newton's, Poisson's and
Stronge's law are fitted to a part of the impacts and predict the others.

python examples/which_law.py
"""

import numpy as np

import impulsekit as ik
from impulsekit.measured import LawCandidate, Measurement, compare_laws

ROD = """<robot name="rod"><link name="rod"><inertial><mass value="1"/><inertia ixx="0.0833"
iyy="0.0833" izz="0.0833" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
LAWS = [
    LawCandidate("Newton, slip at the end", ik.Law()),
    LawCandidate("Poisson, slip at the end", ik.Law("poisson")),
    LawCandidate("Stronge, along the path", ik.Law("stronge", "path")),
]


def measured(count: int, rng: np.random.Generator) -> list[Measurement]:
    """Impacts at leans of 10 to 80 degrees, with noise of 2 cm/s and 0.05 rad/s."""
    rod = ik.Robot.from_urdf(ROD, root="planar")
    tip = ik.Contact("rod", normal=[0, 1, 0], restitution=0.6, friction=0.3, name="tip")
    scene = ik.Scene(rod, contacts=[tip], gap_bound=np.inf)
    true = ik.Scene(rod, contacts=[tip], law=ik.Law("stronge", "path"), gap_bound=np.inf)
    lean = rng.uniform(np.radians(10), np.radians(80), count)
    points = -0.5 * np.stack([np.cos(lean), np.sin(lean), 0 * lean], axis=1)
    v = np.stack([rng.normal(0, 0.5, count), rng.uniform(-3, -1, count), 0 * lean], axis=1)
    batch = ik.solve_batch(true, rod.neutral(), v, points={"tip": points})
    sigma = np.array([0.02, 0.02, 0.05])
    after = batch.v_after + sigma * rng.normal(size=v.shape)
    return [
        Measurement(scene, rod.neutral(), *each, sigma=sigma, points={"tip": point})
        for *each, point in zip(v, after, points, strict=True)
    ]


def main() -> None:
    seen = measured(60, np.random.default_rng(0))
    found = compare_laws(seen, LAWS, restitution=["tip"], friction=["tip"], folds=3)
    print(found.report(), end="")


if __name__ == "__main__":
    main()
