"""Draw Figure 3 of Chang & Huston 1995: the hanging pendulum of ten rods after the blow, in feet.

Ten links of 1 slug and 1 ft hang from a pin; the lowest end is struck with 30 lbf s and the
motion under gravity is followed for two seconds. Needs matplotlib:
pip install ".[plot]".

    python examples/draw_figure_3.py [OUTPUT]        # figure_3.svg beside this file
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("svg")

import numpy as np
import pinocchio as pin
from matplotlib import pyplot as plt

import impulsekit as ik

HERE = Path(__file__).parent
FOOT = 0.3048
PIN = (5.0, 15.0)  # [ft]; the free end starts at a height of 5
INSTANTS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.2, 1.6, 2.0)  # [s]
INK, QUIET = "#22303c", "#7b8894"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", nargs="?", type=Path, default=HERE / "figure_3.svg")
    output = parser.parse_args().output

    file = ik.load_scene(HERE / "pendulum_10.toml")
    motion = ik.simulate(file.scene, file.q, file.v, duration=2.0)
    robot = file.scene.robot

    style = {"svg.hashsalt": "figure 3", "font.family": "DejaVu Sans", "font.size": 10}
    with plt.rc_context(style):
        figure, axes = plt.subplots(figsize=(8, 8.6), layout="constrained")
        colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.88, len(INSTANTS)))
        way = np.array([points(robot, motion.at(t)[0])[-1] for t in np.linspace(0, 2, 600)])
        axes.plot(way[:, 0], way[:, 1], color=QUIET, linewidth=0.8, linestyle=(0, (1, 2)))
        for t, colour in zip(INSTANTS, colours, strict=True):
            at = points(robot, motion.at(t)[0])
            axes.plot(
                at[:, 0],
                at[:, 1],
                "o-",
                color=colour,
                linewidth=2,
                markersize=3,
                label=f"{t:.1f} s",
            )
        axes.plot(*PIN, "s", color=INK, markersize=8)
        axes.annotate(
            "30 lbf s", (5, 5), xytext=(2.6, 5), va="center", arrowprops={"arrowstyle": "-|>"}
        )
        axes.set_xlabel("x [ft]")
        axes.set_ylabel("y [ft]")
        axes.set_aspect("equal")
        axes.set_xlim(0, 15)
        axes.set_ylim(4, 21)
        # The paper's axes end at 15 ft; the whip of the free end goes higher.
        axes.axhline(15, color=QUIET, linewidth=0.6)
        axes.legend(frameon=False, loc="upper left", ncols=2)
        axes.spines[["top", "right"]].set_visible(False)
        metadata = {"Date": None} if output.suffix == ".svg" else None
        figure.savefig(output, metadata=metadata, dpi=110)

    energy = motion.energy()
    kept = np.ptp(energy.total) / energy.kinetic[0]
    print(f"{motion.steps} steps, energy kept to {kept:.1e} of the blow's")


def points(robot: ik.Robot, q: np.ndarray) -> np.ndarray:
    """(11, 2) x and y [ft] of the pins and the free end, from the fixed pin on."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    links = [data.oMf[robot.frame_id(f"link_{i}")] for i in range(1, 11)]
    tips = [link.translation for link in links] + [links[-1].act(np.array([0, 0, -FOOT]))]
    return np.array(tips)[:, [0, 2]] / FOOT + np.array(PIN)


if __name__ == "__main__":
    main()
