"""What users read uses the usual terms: errors, statuses, help, pages and plots hold no riddles."""

import ast
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
    r"jump less|told of\b|tells of\b|come to rest has|what can only push|comes back e times|"
    r"(?:is|are) wanted\b|no [a-z ]+ is called|there is \"|has shape|known are|what is left over|"
    r"\bwaver|law gave no answer|has no answer|\bdoubt\b|make room|\blittle room|goes with a point|"
    r"^tell |\btell the design|moving p(?:age|icture)",
    re.I,
)
PACKAGE = ROOT / "impulsekit"
PAGES = [
    path
    for path in (ROOT / "docs").rglob("*.md")
    if not {"_build", "_generated"} & set(path.relative_to(ROOT / "docs").parts)
]


def sentences_of(path):
    """The texts in a source file that are more than a word, docstrings apart: line and text."""
    tree = ast.parse(path.read_text("utf-8"))
    nodes = list(ast.walk(tree))
    parts = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    docstrings = {
        id(first.value)
        for node in nodes
        if (body := getattr(node, "body", None)) and isinstance(body, list)
        for first in body
        if isinstance(first, ast.Expr)
    }
    for node in nodes:
        if id(node) in parts or id(node) in docstrings:
            continue
        if isinstance(node, ast.JoinedStr):
            # What is put in stands for itself.
            told = (p.value if isinstance(p, ast.Constant) else "{}" for p in node.values)
            text = "".join(map(str, told))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value
        else:
            continue
        if " " in text.strip():
            yield node.lineno, text


@pytest.mark.slow
def test_errors_reports_and_plots():
    """Every sentence in the source of the package: raised, warned, printed, drawn."""
    found = [
        (path.relative_to(PACKAGE).as_posix(), line, text, said)
        for path in sorted(PACKAGE.rglob("*.py"))
        for line, text in sentences_of(path)
        if (said := NOT_SAID.findall(text))
    ]
    assert found == []


def test_the_table_of_faults():
    """What users get for over 300 faults, each committed."""
    table = (ROOT / "tests/faults/faults.md").read_text("utf-8").splitlines()
    words = [line.split(" | ")[2] for line in table if line.count(" | ") >= 2]
    assert len(words) > 300
    assert [each for each in words if NOT_SAID.search(each)] == []


EXAMPLES = [path for path in (ROOT / "examples").iterdir() if path.suffix in (".py", ".toml")]


@pytest.mark.parametrize(
    "path", [ROOT / "README.md", *sorted(PAGES), *sorted(EXAMPLES)], ids=lambda p: p.name
)
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
    assert "energy balance error" in text
