"""Plots: they take and return axes, and show the numbers that they should."""

import builtins
import pathlib
import sys

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from matplotlib import pyplot as plt

import impulsekit as ik
from impulsekit.errors import MissingExtraError, RangeError, UnknownNameError
from impulsekit.view import plots

from .sheets import faults_of

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def solved(name):
    scene_file = ik.load_scene(EXAMPLES / f"{name}.toml")
    return ik.solve(scene_file.scene, scene_file.q, scene_file.v)


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture
def ax():
    return plt.figure().add_subplot()


@pytest.mark.parametrize(
    "draw",
    [plots.velocity_jump, plots.contact_cones, plots.joint_reactions, plots.energy_balance],
)
def test_axes_are_taken_and_returned(draw, ax):
    impact = solved("rocking_block")
    before = len(plt.get_fignums())
    assert draw(impact, ax) is ax
    assert len(plt.get_fignums()) == before
    assert draw(impact) is not ax
    assert ax.get_title(loc="left")


def test_the_velocity_jump(ax):
    impact = solved("whittaker_chain")
    plots.velocity_jump(impact, ax, rows=3)
    largest = np.sort(np.argsort(-np.abs(impact.dv))[:3])
    panels = ax.figure.axes
    drawn = [[line.get_xdata() for line in panel.lines[1:3]] for panel in panels]
    assert np.concatenate([before for before, _ in drawn]).tolist() == [0.0] * 3
    assert np.concatenate([after for _, after in drawn]) == pytest.approx(impact.v_after[largest])
    labels = [t.get_text().split("[")[1] for panel in panels for t in panel.get_yticklabels()]
    assert labels == ["m/s]", "rad/s]", "rad/s]"]
    assert "9 smaller not shown" in ax.get_title(loc="left")


def test_reactions_in_order_and_rounding_is_nothing(ax):
    impact = solved("whittaker_chain")
    plots.joint_reactions(impact, ax)
    sizes = [bar.get_width() for bar in ax.patches]
    wanted = [np.linalg.norm(impact.reactions[n][:3]) for n in impact.scene.robot.joint_names]
    assert sizes == pytest.approx(wanted, abs=1e-9)
    couples = plots.joint_reactions(impact, part="couple")
    assert [bar.get_width() for bar in couples.patches] == [0.0] * 10
    assert couples.get_xlabel() == "size [N m s]"
    with pytest.raises(RangeError, match="force"):
        plots.joint_reactions(impact, ax, part="torque")


def test_the_books_of_energy_lead_from_before_to_after(ax):
    impact = solved("rocking_block")
    plots.energy_balance(impact, ax)
    first, *works, last = ax.patches
    assert first.get_width() == pytest.approx(impact.energy.before)
    assert last.get_width() == pytest.approx(impact.energy.after)
    assert [w.get_width() for w in works] == pytest.approx(list(impact.energy.work.values()))
    assert works[-1].get_x() + works[-1].get_width() == pytest.approx(impact.energy.after)


def test_a_stroboscope_of_the_struck_chain(ax):
    impact = solved("whittaker_chain")
    plots.stroboscope(impact, [0.0], ax, unit="ft", ends=("A", "B"))
    xs = sorted({round(float(x), 6) for line in ax.lines for x in line.get_xdata()})
    assert xs == pytest.approx(np.arange(11) / 0.3048)
    assert [text.get_text() for text in ax.texts] == ["$A_{0}$", "$B_{0}$"]
    assert ax.get_ylabel() == "y [ft]"
    for wrong in ({"plane": "xx"}, {"plane": "xyz"}, {"unit": "mile"}):
        with pytest.raises(RangeError):
            plots.stroboscope(impact, [0.0], ax, **wrong)
    with pytest.raises(RangeError, match="time"):
        plots.stroboscope(impact, [99.0], ax)


def test_histories_of_a_motion():
    impact = solved("whittaker_chain")
    scene = ik.Scene(impact.scene.robot, gravity=[0, 0, 0])
    motion = ik.simulate(scene, impact.q, impact.v_after, duration=0.1)
    ax = plots.energy_history(motion)
    assert ax.lines[-1].get_ydata() == pytest.approx(impact.energy.after)
    # Rounding does not fill the picture.
    assert np.ptp(ax.get_ylim()) > 1e-4 * impact.energy.after
    ax = plots.momentum_history(motion)
    assert ax.lines[1].get_ydata() == pytest.approx(5.0)
    assert ax.get_ylabel() == "linear momentum [kg m/s]"
    with pytest.raises(RangeError):
        plots.momentum_history(motion, part="both")
    # Of a struck chain in the plane all but the angular momentum about its own normal is there.
    assert len(plots.overview(motion).axes) == 3


@pytest.fixture(scope="module")
def bounced():
    """A ball that bounces twice and comes to rest on a floor, dropped beside its foot."""
    ball = ik.Robot.from_urdf(EXAMPLES.parent / "models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5, name="floor")])
    drop = ball.configuration(root_joint=[0, 0, 0.2, 0, 0, 0, 1])
    return ik.simulate(scene, drop, ball.velocity(), duration=1.0)


def test_jumps_are_vertical(bounced):
    (time, impact), *_ = bounced.impacts
    ax = plots.energy_history(bounced)
    total = next(line for line in ax.lines if line.get_label() == "total")
    at = total.get_xdata() == time
    values = total.get_ydata()[at]
    assert len(values) >= 2
    assert values[0] - values[-1] == pytest.approx(impact.energy.before - impact.energy.after)
    # Between two impacts the total is level, up to both of them.
    level = total.get_ydata()[(total.get_xdata() <= time)][: np.flatnonzero(at)[0] + 1]
    assert np.ptp(level) < 1e-9 * level[0]
    lift = next(line for line in plots.momentum_history(bounced).lines if line.get_label() == "z")
    jump = np.diff(lift.get_ydata()[lift.get_xdata() == time])
    assert jump.max() == pytest.approx(impact.contacts["floor"].impulse[2])


def test_loads_over_time_in_one_call(bounced, tmp_path):
    figure = plots.load_history(bounced, tmp_path / "loads.png", samples=40)
    (ax,) = figure.axes
    assert ax.get_ylabel() == "contact force [N]"
    curve = next(line for line in ax.lines if line.get_label() == "floor")
    weight = 9.81 * bounced.scene.robot.mass
    assert curve.get_ydata()[0] == 0.0
    assert curve.get_ydata()[-1] == pytest.approx(weight)
    assert faults_of(figure) == []
    # A notebook shows it, whether or not pyplot has drawn there before.
    assert figure._repr_png_().startswith(b"\x89PNG")
    rod = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    swing = ik.simulate(ik.Scene(rod), [0.3, 0.0], [0.0, 0.0], 0.2)
    axes = plots.load_history(swing, joints=["joint_2"], samples=9).axes
    assert axes[0].get_ylabel() == "force in joints [N]"
    wanted = np.linalg.norm(swing.joints["joint_2"].reaction(0.2)[:3])
    assert axes[0].lines[0].get_ydata()[-1] == pytest.approx(wanted)
    with pytest.raises(UnknownNameError):
        plots.load_history(swing, joints=["joint_3"])


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_a_sheet_is_written(ending, tmp_path):
    path = tmp_path / f"sheet.{ending}"
    figure = plots.overview(solved("solo12_landing"), path)
    # Speeds in m/s and in rad/s stand apart.
    assert len(figure.axes) == 5
    assert path.stat().st_size > 5000


def test_without_matplotlib_the_line_to_install_it_is_told(monkeypatch):
    real = builtins.__import__

    def refuse(name, *rest, **more):
        if name.startswith("matplotlib"):
            raise ImportError(name)
        return real(name, *rest, **more)

    impact = solved("four_bar")
    for name in [n for n in sys.modules if n.startswith("matplotlib")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", refuse)
    for draw in (plots.velocity_jump, plots.overview):
        with pytest.raises(MissingExtraError, match=r"\.\[plot\]"):
            draw(impact)


SCENES = ("whittaker_chain", "solo12_landing", "talos_heel_strike", "billiard", "hammer_nail")


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("name", SCENES)
def test_no_word_leaves_the_sheet_or_lies_over_another(name, dark):
    impact = solved(name)
    with plt.style.context("dark_background" if dark else []):
        for draw in (
            plots.velocity_jump,
            plots.contact_cones,
            plots.joint_reactions,
            plots.energy_balance,
            lambda impact: plots.stroboscope(impact, [0.0], ends=("A", "B")),
        ):
            assert faults_of(draw(impact).figure) == []
    assert faults_of(plots.overview(impact, dark=dark)) == []


@pytest.mark.parametrize(
    ("axis", "turn", "plane"), [("x", 0, "yz"), ("y", 1, "xz"), ("z", 2, "xy")]
)
def test_a_stroboscope_looks_along_the_axis_about_which_it_turns(axis, turn, plane):
    xyz = " ".join("1" if i == turn else "0" for i in range(3))
    far = " ".join("1" if i == (turn + 1) % 3 else "0" for i in range(3))
    text = f"""<robot name="r"><link name="a"/><link name="b"><inertial><origin xyz="{far}"/>
      <mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="j" type="continuous"><parent link="a"/><child link="b"/>
      <axis xyz="{xyz}"/></joint></robot>"""
    robot = ik.Robot.from_urdf(text)
    q = [robot.configuration(j=angle) for angle in (0.0, 1.0, 2.0)]
    motion = ik.measured.Recording(robot, [0.0, 1.0, 2.0], q)
    ax = plots.stroboscope(motion, [0.0, 1.0, 2.0])
    assert (ax.get_xlabel()[0], ax.get_ylabel()[0]) == tuple(plane)
    assert plots.stroboscope(motion, [0.0], plane="zx").get_xlabel() == "z [m]"


def test_speeds_of_a_free_flyer_are_in_world_axes():
    """A ball that turns while it falls: its speed upwards falls by g, whatever its body axes do."""
    robot = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    floor = ik.Contact("ball", at=[0, 0, 0], restitution=0.6, name="floor")
    scene = ik.Scene(robot, contacts=[floor])
    start = robot.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1])
    motion = ik.simulate(scene, start, [0, 0, 0, 9.0, 0, 0], duration=0.5, samples=51)
    recording = ik.measured.Recording(robot, motion.t, motion.q, name="7")
    found = ik.measured.find_impacts(recording, scene, sigma=1e-6)
    ax = ik.plots.found_impacts(recording, found)
    assert ax.get_title(loc="left") == "Impacts in recording 7"
    up = next(line for line in ax.lines if line.get_label() == "z, world axes")
    early = up.get_xdata() < 0.25
    slope = np.polyfit(up.get_xdata()[early][1:], up.get_ydata()[early][1:], 1)[0]
    assert slope == pytest.approx(-9.81, abs=0.2)
    (height,) = ax.figure.axes[1].lines
    np.testing.assert_array_equal(height.get_ydata(), motion.q[:, 2])


def test_x_y_and_z_are_red_green_and_blue():
    from matplotlib.colors import to_rgb

    robot = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    motion = ik.simulate(ik.Scene(robot), robot.neutral(), robot.velocity(), duration=0.1)
    lines = ik.plots.momentum_history(motion).lines
    by_axis = {line.get_label(): int(np.argmax(to_rgb(line.get_color()))) for line in lines}
    assert {axis: by_axis[axis] for axis in "xyz"} == {"x": 0, "y": 1, "z": 2}
