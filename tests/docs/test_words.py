"""What users read uses the usual terms: statuses, help texts and pages hold no riddles."""

import pathlib
import re

import click
import pytest

import impulsekit as ik
from impulsekit.cli import main

ROOT = pathlib.Path(__file__).parents[2]
# Each has a usual term: energy balance, machine precision, valid, carries, infinite, expected.
NOT_SAID = re.compile(
    r"\bthe books\b|books close|rounding level|answer holds|(?:is|no) (?:an )?answer that|"
    r"is no answer|had to bear|\bbears\b|hang on each other|all but dependent|all but stretched|"
    r"\blawful|wandering|faintest|nobody asks|wanted (?:is|are)|allowed is|without end\b|"
    r"jump less|told of\b|tells of\b|come to rest has|what can only push|comes back e times",
    re.I,
)
PAGES = [
    path
    for path in (ROOT / "docs").rglob("*.md")
    if not {"_build", "_generated"} & set(path.relative_to(ROOT / "docs").parts)
]


@pytest.mark.parametrize("path", [ROOT / "README.md", *sorted(PAGES)], ids=lambda p: p.stem)
def test_pages(path):
    assert NOT_SAID.findall(path.read_text("utf-8")) == []


@pytest.mark.parametrize("status", [*ik.Status, *ik.MotionStatus], ids=lambda s: s.name)
def test_statuses(status):
    assert NOT_SAID.findall(status.value) == []


@pytest.mark.parametrize("name", sorted(main.commands))
def test_help(name):
    text = main.commands[name].get_help(click.Context(main.commands[name], info_name=name))
    assert NOT_SAID.findall(" ".join(text.split())) == []


def test_reports():
    file = ik.load_scene(ROOT / "examples/four_bar.toml")
    text = ik.report(ik.solve(file.scene, file.q, file.v), file.points)
    assert NOT_SAID.findall(text) == []
    assert "energy balance closes" in text
