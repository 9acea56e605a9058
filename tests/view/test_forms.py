"""The forms of a report: they all say what the plain text says."""

import json

import pytest

import impulsekit as ik
from impulsekit.errors import RangeError
from impulsekit.view.forms import as_rich
from impulsekit.view.report import report_blocks

BAD = "[red]*x*|<b>`y`"


@pytest.fixture(scope="module")
def impact():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    scene = ik.Scene(
        robot,
        [ik.AppliedImpulse("base_link", [0, 0, -1], name=BAD)],
        constraints=[ik.JointLock("FL_KFE")],
        contacts=[ik.Contact("FR_FOOT", friction=0.5)],
    )
    return ik.solve(scene, robot.neutral(), robot.velocity(root_joint=[0.1, 0, -1, 0, 0, 0]))


def test_every_cell_of_the_text_is_in_the_others(impact):
    blocks = report_blocks(impact)
    markdown = ik.report(impact, form="markdown").replace("\\", "")
    data = json.loads(ik.report(impact, form="json"))
    flat = json.dumps(data, ensure_ascii=False)
    for block in blocks:
        assert block[0].strip() in markdown
        assert json.dumps(block[0], ensure_ascii=False)[1:-1] in flat
        for line in block:
            for row in line.table.rows if hasattr(line, "table") else ():
                assert "| " + " | ".join(row) + " |" in markdown


def test_json_has_numbers_and_units(impact):
    data = json.loads(ik.report(impact, form="json"))
    speeds = next(s for s in data["sections"] if s["title"] == "Joint speeds")
    (table,) = speeds["tables"]
    assert table["columns"] == ["joint", "before", "after", "jump", "unit"]
    row = next(r for r in table["rows"] if r[0] == "root_joint vz")
    assert row[1] == -1
    assert row[2] == pytest.approx(impact.v_after[2], rel=1e-5)
    assert row[4] == "m/s"


def test_markdown_escapes_names(impact):
    text = ik.report(impact, form="markdown")
    assert r"\[red\]\*x\*\|\<b\>\`y\`" in text
    assert text.startswith("# solo: 1 impulse, 1 constraint, 1 contact")
    for line in text.splitlines():
        if line.startswith("|"):
            assert line.endswith("|")


def test_rich_draws_tables_and_keeps_names_as_they_are(impact):
    import io

    from rich.console import Console

    out = io.StringIO()
    Console(file=out, width=140, color_system=None).print(as_rich(report_blocks(impact)))
    text = out.getvalue()
    assert BAD in text
    assert "Joint speeds" in text
    assert "─" in text
    for word in ("root_joint vz", "rad/s", "FR_FOOT" if "FR_FOOT" in ik.report(impact) else "J"):
        assert word in text


def test_another_form_is_refused(impact):
    with pytest.raises(RangeError, match='"text" or "markdown" or "json"'):
        ik.report(impact, form="latex")
