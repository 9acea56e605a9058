"""What results show of themselves: HTML that parses, in one plain line otherwise."""

import html.parser

import numpy as np
import pytest

import impulsekit as ik

BAD = "<script>alert('&amp;')</script>\" onload=\"x"
VOID = {"br", "hr", "img", "input", "meta", "link", "col"}
ALLOWED = {"div", "p", "b", "br", "table", "thead", "tbody", "tr", "th", "td", "details", "summary"}


class Strict(html.parser.HTMLParser):
    """Keeps what is open; a tag that closes what is not open fails, as does an unknown one."""

    def __init__(self, allowed):
        super().__init__(convert_charrefs=True)
        self.allowed, self.open, self.words, self.attributes = allowed, [], [], {}

    def handle_starttag(self, tag, attrs):
        assert tag in self.allowed, tag
        assert not {name for name, _ in attrs if name.startswith("on")}
        self.attributes[tag] = dict(attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def parsed(text, allowed=ALLOWED):
    parser = Strict(allowed)
    parser.feed(text)
    parser.close()
    assert parser.open == []
    return parser


def markup(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


@pytest.fixture(scope="module")
def things():
    """One of each kind, with names that are markup wherever a name can stand."""
    text = ik.models.chain_urdf(2).replace("joint_2", markup(BAD))
    robot = ik.Robot.from_urdf(text, root="planar")
    robot.name = BAD
    scene = ik.Scene(
        robot,
        [ik.AppliedImpulse("link_1", [0, -1, 0], name=BAD)],
        contacts=[ik.Contact("link_1", normal=[0, 1, 0], restitution=0.5, name=f"c{BAD}")],
        gravity=[0, 0, 0],
    )
    q, v = robot.neutral(), robot.velocity()
    impact = ik.solve(scene, q, v)
    still = ik.Scene(robot, gravity=[0, 0, 0])
    measured = []
    for spin in (0.0, 0.3):
        v_before = np.array([0.1, -1.0, 0.0, spin])
        v_after = ik.solve(scene, q, v_before).v_after
        measured.append(ik.measured.Measurement(scene, q, v_before, v_after))
    blow = ik.Scene(robot, [ik.AppliedImpulse("link_1", [0, 1, 0], name=BAD)])
    return {
        "Impact": impact,
        "Trajectory": ik.simulate(still, q, impact.v_after, duration=0.1),
        "Scene": scene,
        "Robot": robot,
        "Fit": ik.measured.fit_impacts(measured, restitution=[f"c{BAD}"]),
        "Check": ik.check(ik.solve(blow, q, v)),
        "Replay": ik.replay(impact),
        "ContactResult": impact.contacts[0],
        "Energy": impact.energy,
        "JointLoad": impact.joint_loads[BAD],
        "Derivatives": ik.derivatives(ik.solve(scene, q, np.array([0.1, -1.0, 0.0, 0.3]))),
        "ImpactBatch": ik.solve_batch(scene, np.tile(q, (3, 1)), np.zeros((3, robot.nv))),
    }


PARTS = ["ContactResult", "Energy", "JointLoad", "Derivatives"]
KINDS = ["Impact", "Trajectory", "Scene", "Robot", "Fit", "Check", "ImpactBatch", *PARTS]


@pytest.mark.parametrize("kind", KINDS)
def test_it_shows_itself_as_valid_html(things, kind):
    text = things[kind]._repr_html_()
    words = "".join(parsed(text).words)
    assert "<script" not in text
    assert words
    assert "<script>alert" in words or kind == "ImpactBatch"


@pytest.mark.parametrize("kind", [*KINDS, "Replay"])
def test_the_plain_form_is_one_line(things, kind):
    line = repr(things[kind])
    assert line.startswith(f"{kind}(") and line.endswith(")")
    assert "\n" not in line and 20 < len(line) <= 170
    first = line.removeprefix(f"{kind}(").split(",")[0]
    wanted = {
        "Impact": "SOLVED",
        "Trajectory": "FINISHED",
        "Fit": "CONVERGED",
        "Check": "AGREES",
        "ImpactBatch": "3 SOLVED",
    }
    assert first == wanted.get(kind, first)


def test_the_numbers_are_those_of_the_result(things):
    words = parsed(things["Impact"]._repr_html_()).words
    assert any("SOLVED" in word or "olved" in word for word in words)
    fit = things["Fit"]
    assert f"{fit.values[0]:.6g}" in parsed(fit._repr_html_()).words
    robot = parsed(things["Robot"]._repr_html_()).words
    assert f"2 links, {things['Robot'].mass:.6g} kg" in " ".join(robot)
    energy = things["Energy"]
    assert f"{energy.after:.6g}" in parsed(energy._repr_html_()).words
    load = things["JointLoad"]
    assert f"{load.torque:.4g}" in parsed(load._repr_html_()).words
    contact = parsed(things["ContactResult"]._repr_html_()).words
    assert f"({', '.join(f'{x:.4g}' for x in things['ContactResult'].impulse)})" in contact
    derivatives = things["Derivatives"]
    assert (
        f"{np.abs(derivatives['v_after', 'q']).max():.4g}"
        in parsed(derivatives._repr_html_()).words
    )


def test_long_tables_end(things):
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(60))
    text = robot._repr_html_()
    assert text.count("<tr>") == 21
    # 60 links make 59 joints.
    assert "and 39 more" in text


def test_a_replay_moves_in_a_frame_of_its_own(things, page, tmp_path):
    shown = things["Replay"]
    parser = parsed(shown._repr_html_(), {"iframe"})
    frame = parser.attributes["iframe"]
    assert frame["srcdoc"] == shown.html
    assert frame["sandbox"] == "allow-scripts allow-downloads"
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<!DOCTYPE html><title>n</title>{shown._repr_html_()}", encoding="utf-8")
    page.page.goto(notebook.as_uri())
    inner = page.page.frames[-1]
    inner.wait_for_function("() => viewer.animator.time > 0.05", timeout=20_000)
    inner.get_by_role("button", name="Pause", exact=True).click()
    assert not inner.evaluate("() => viewer.animator.playing")
