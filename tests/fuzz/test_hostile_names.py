"""Names out of files reach pages, pictures and terminals as plain text."""

from __future__ import annotations

import html
import io
import json

import pytest

import impulsekit as ik
from impulsekit import errors
from impulsekit.scene import ReportPoint

SCRIPT = "</script><script>window.owned = 1</script><img src=x onerror=window.owned=1>"
NAMES = [
    SCRIPT,
    "</title><b>bold",
    "\"quoted\" 'name' & <!-- comment",
    "[red]markup[/red]",
    "$\\frac$ and $x",
    "{0.__class__} %s %n",
    "a|b*c_d`e",
    "__proto__",
]
LINK = (
    '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
    'ixz="0" iyz="0"/></inertial></link>'
)


def impact_of(name):
    written = html.escape(name)
    text = (
        f'<robot name="{written}">{LINK.format("base")}{LINK.format(written)}'
        f'<joint name="{written}" type="continuous"><parent link="base"/>'
        f'<child link="{written}"/><axis xyz="0 1 0"/></joint></robot>'
    )
    robot = ik.Robot.from_urdf(text)
    blow = ik.AppliedImpulse(name, linear=[1, 0, 0], at=[0, 0, 1], name=name)
    floor = ik.Contact(name, at=[0, 0, 1], normal=[1, 0, 0], name=f"{name} 2")
    scene = ik.Scene(robot, [blow], contacts=[floor])
    return ik.solve(scene, robot.neutral(), robot.velocity())


@pytest.mark.parametrize("name", NAMES)
def test_a_page_holds_names_as_text(name):
    point = ReportPoint(name, label=name)
    page = ik.replay(impact_of(name), points=[point], reactions=True, traces=[point]).html
    before_player = page[: page.index("MeshCat")]
    assert "<script>window" not in before_player
    assert "<b>" not in before_player
    assert "onerror=window" not in page.replace("\\u003c", "<").partition("</head>")[0].replace(
        html.escape(name), ""
    )
    facts = page.partition('id="replay">')[2].partition("</script>")[0]
    assert json.loads(facts)["title"] == name


@pytest.mark.slow
@pytest.mark.parametrize("name", [SCRIPT, "__proto__"])
def test_a_browser_runs_nothing_of_a_name(name, session_browser, tmp_path):
    session_browser.requests.clear()
    ik.replay(impact_of(name), tmp_path / "page.html", play=False)
    session_browser.open(tmp_path / "page.html")
    assert session_browser.run("() => window.owned === undefined")
    assert session_browser.run("() => document.querySelector('#legend b').textContent") == name
    assert session_browser.requests == []
    session_browser.leave()


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_pictures_take_names_as_they_are(name, tmp_path):
    pytest.importorskip("matplotlib")
    impact = impact_of(name)
    for ending in ("svg", "png"):
        ik.plots.overview(impact, tmp_path / f"a.{ending}")
    assert "<script" not in (tmp_path / "a.svg").read_text()
    robot = impact.scene.robot
    ellipsoid = ik.design.impact_ellipsoid(robot, impact.q, name, at=[0, 0, 1])
    axes = ik.design.plot_effective_mass(ellipsoid)
    axes.figure.savefig(tmp_path / "b.png")


@pytest.mark.parametrize("name", NAMES)
def test_a_terminal_shows_names_as_they_are(name):
    from rich.console import Console

    from impulsekit.view.forms import as_rich
    from impulsekit.view.report import report_blocks

    impact = impact_of(name)
    text = ik.report(impact)
    assert name in text
    assert json.loads(ik.report(impact, form="json"))
    assert "<script>" not in ik.report(impact, form="markdown").replace("\\<", "")
    console = Console(file=io.StringIO(), force_terminal=True, width=1000)
    console.print(as_rich(report_blocks(impact)))
    assert name in console.file.getvalue()


def as_references(name):
    """Each character by its number: a line end that stands for itself would become a blank."""
    return "".join(f"&#{ord(c)};" for c in name)


CONTROLS = ["\x1b[2J", "\x9b31m", "a\rb", "a\nb", "\u202egnp", "\x07", "\x00", "\u2028"]


@pytest.mark.parametrize("name", CONTROLS)
def test_what_a_terminal_would_obey_is_no_name(name):
    for make in (
        lambda: ik.AppliedImpulse("a", name=name),
        lambda: ik.Contact(name),
        lambda: ReportPoint("a", label=name),
        lambda: ik.combine({name: ik.Robot.from_urdf(ik.models.chain_urdf(1))}),
        lambda: ik.Robot.from_urdf(f'<robot name="r"><link name="{as_references(name)}"/></robot>'),
    ):
        with pytest.raises(errors.InputError) as caught:
            make()
        assert str(caught.value).isprintable()
