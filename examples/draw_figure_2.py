"""Draw Figure 2 of Chang & Huston 1995: the struck chain of ten rods moves on, free of force.

Whittaker's chain (1 kg and 1 m a rod) is struck at its end A with 5 N s, at right angles, and
followed for three seconds. Needs matplotlib: pip install ".[plot]".

    python examples/draw_figure_2.py [OUTPUT]        # figure_2.svg beside this file
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
INSTANTS = (0.0, 1.0, 2.0, 3.0)  # [s]
QUIET = "#7b8894"
COLOURS = ("#22303c", "#2b6cb0", "#2f855a", "#c8412b")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", nargs="?", type=Path, default=HERE / "figure_2.svg")
    output = parser.parse_args().output

    chain = ik.Robot.from_urdf(HERE.parent / "models" / "whittaker_chain_10.urdf", root="planar")
    blow = ik.AppliedImpulse("link_1", linear=[0, 5, 0])
    scene = ik.Scene(chain, impulses=[blow], gravity=[0, 0, 0])
    motion = ik.simulate(
        scene, chain.neutral(), chain.velocity(), duration=INSTANTS[-1], rtol=1e-12
    )

    style = {"svg.hashsalt": "figure 2", "font.family": "DejaVu Sans", "font.size": 10}
    with plt.rc_context(style):
        figure, axes = plt.subplots(figsize=(9, 7), layout="constrained")
        times = np.linspace(0.0, INSTANTS[-1], 400)
        for end in (0, -1):
            way = np.array([points(chain, motion.at(t)[0])[end] for t in times])
            axes.plot(way[:, 0], way[:, 1], color=QUIET, linewidth=0.8, linestyle=(0, (1, 2)))
        for i, (t, colour) in enumerate(zip(INSTANTS, COLOURS, strict=True), 1):
            at = points(chain, motion.at(t)[0])
            axes.plot(at[:, 0], at[:, 1], "o-", color=colour, linewidth=2.2, markersize=3.5)
            for name, point in (("A", at[0]), ("B", at[-1])):
                axes.annotate(
                    f"${name}_{i}$",
                    point,
                    xytext=(6, 7 if name == "A" else -14),
                    textcoords="offset points",
                    color=colour,
                    fontsize=12,
                )
            axes.plot([], [], color=colour, linewidth=2.2, label=f"{i}: t = {t:g} s")
        axes.annotate(
            "5 N s", (0, -0.1), xytext=(0, -1.3), ha="center", arrowprops={"arrowstyle": "-|>"}
        )
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_aspect("equal")
        axes.set_xlim(-1.5, 11.5)
        axes.set_ylim(-4.0, 6.0)
        axes.legend(frameon=False, loc="upper right")
        axes.spines[["top", "right"]].set_visible(False)
        metadata = {"Date": None} if output.suffix == ".svg" else None
        figure.savefig(output, metadata=metadata, dpi=110)

    energy = motion.energy().total
    print(f"{motion.steps} steps, energy kept to {np.ptp(energy) / energy[0]:.1e}")


def points(chain: ik.Robot, q: np.ndarray) -> np.ndarray:
    """(11, 2) x and y of the ends and pins, from the struck end on."""
    data = chain.model.createData()
    pin.framesForwardKinematics(chain.model, data, q)
    links = [data.oMf[chain.frame_id(f"link_{i}")] for i in range(1, 11)]
    tips = [link.translation for link in links] + [links[-1].act(np.array([1.0, 0, 0]))]
    return np.array(tips)[:, :2]


if __name__ == "__main__":
    main()
