"""Every threshold has a name and a reason, at one place: none stands in the body of a function."""

import ast
import pathlib
from collections import Counter

PACKAGE = pathlib.Path(__file__).parent.parent / "impulsekit"
# What is left, by room: it only shrinks. Tables of problems and plots are numbers by themselves.
LEFT: dict[str, int] = {}
# A number smaller than this decides what counts as nothing.
SMALL = 1e-3


def is_threshold(node):
    """Whether a piece of source is so small a number, or a negative power of one."""
    if isinstance(node, ast.Constant):
        return type(node.value) is float and 0.0 < abs(node.value) < SMALL
    power = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)
    return power and isinstance(node.left, ast.Constant) and isinstance(node.right, ast.UnaryOp)


def unnamed_in(source):
    """The lines of a module in which functions hold thresholds."""
    bodies = [
        part
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FunctionDef | ast.Lambda)
        for part in (node.body if isinstance(node.body, list) else [node.body])
    ]
    found = {}
    for body in bodies:
        found |= {id(node): node.lineno for node in ast.walk(body) if is_threshold(node)}
    return sorted(found.values())


def test_what_is_looked_for():
    source = """
BAR = 1e-9
def close(x, y=1e-12):
    if x < 1e-9 or x == 0.5 or x < -2.0**-40:
        return 1e3 * BAR
    return lambda z: z + 1e-15
"""
    assert unnamed_in(source) == [4, 4, 6]


def test_thresholds_have_names():
    found, where = Counter(), {}
    for path in sorted(PACKAGE.rglob("*.py")):
        lines = unnamed_in(path.read_text(encoding="utf-8"))
        room = path.relative_to(PACKAGE).parts[0]
        found[room] += len(lines)
        where.setdefault(room, []).extend(f"{path.name}:{line}" for line in lines)
    for room in sorted(found):
        left = LEFT.get(room, 0)
        assert found[room] <= left, f"{room}: name what is new in {where[room]}"
        assert found[room] >= left, f"{room}: {found[room]} are left, say so in LEFT"
