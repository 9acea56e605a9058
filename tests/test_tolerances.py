"""Every threshold has a name and a reason, at one place: none stands in the body of a function."""

import ast
import pathlib
import re
from collections import defaultdict

import pytest

PACKAGE = pathlib.Path(__file__).parent.parent / "impulsekit"
ROOMS = sorted(path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists())
# A number smaller than the first decides what counts as nothing, one above the second what is too
# much to count.
SMALL, LARGE = 1e-2, 1e7
# What formulas are made of.
OF_FORMULAS = (0.0, 0.5, 1.0, 2.0, 3.0)


def value_of(node):
    """The number that an expression of numbers, powers of them and EPS is; None if it is more."""
    try:
        found = eval(compile(ast.Expression(node), "", "eval"), {"EPS": 2.0**-52})
    except (NameError, AttributeError, TypeError, ValueError, SyntaxError, ZeroDivisionError):
        return None
    return found if type(found) is float else None


def floats(nodes):
    return [n for n in nodes if isinstance(n, ast.Constant) and type(n.value) is float]


def is_draw(node):
    """Whether it is a comparison with a random number: its odds are no threshold."""
    return any(isinstance(n, ast.Attribute) and n.attr == "random" for n in ast.walk(node))


def thresholds_in(body):
    """The numbers in a function's body that decide something."""
    told = {id(n) for text in ast.walk(body) if isinstance(text, ast.JoinedStr)
            for n in ast.walk(text)}  # fmt: skip
    for node in ast.walk(body):
        if id(node) in told:
            continue
        if isinstance(node, ast.Constant):
            if type(node.value) is float and not (
                node.value == 0.0 or SMALL <= abs(node.value) < LARGE
            ):
                yield node
        elif isinstance(node, ast.BinOp):
            power = isinstance(node.op, ast.Pow) and isinstance(node.left, ast.Constant)
            by_eps = isinstance(node.op, ast.Mult) and any(
                isinstance(side, ast.Name) and side.id == "EPS" for side in (node.left, node.right)
            )
            if (power and isinstance(node.right, ast.UnaryOp)) or (
                by_eps and floats((node.left, node.right))
            ):
                yield node
        elif isinstance(node, ast.Compare) and not is_draw(node):
            yield from (n for n in floats(ast.walk(node)) if abs(n.value) not in OF_FORMULAS)


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
        found |= {id(node): node.lineno for node in thresholds_in(body)}
    return sorted(found.values())


def named_in(source):
    """The names and values of a module's own thresholds."""
    for node in ast.parse(source).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            pairs = [(node.targets[0], node.value)]
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple):
            names = node.targets[0]
            pairs = zip(getattr(names, "elts", ()), node.value.elts, strict=False)
        else:
            continue
        for name, value in pairs:
            number = value_of(value)
            if isinstance(name, ast.Name) and name.id.isupper() and number:
                yield name.id, number


def test_what_is_looked_for():
    source = """
BAR = 1e-9
ONE, OTHER = 2.0, 4.0 * EPS
def close(x, y=1e-12):
    if x < 1e-9 or x == 0.5 or x < -2.0**-40:
        return 1e3 * BAR
    if x < 10.0 * BAR or rng.random() < 0.3:
        return 64.0 * EPS, f"{x / 1e9}"
    return lambda z: z + 1e-15
"""
    assert unnamed_in(source) == [5, 5, 7, 8, 9]
    assert list(named_in(source)) == [("BAR", 1e-9), ("ONE", 2.0), ("OTHER", 2.0**-50)]


@pytest.mark.parametrize("room", ROOMS)
def test_thresholds_have_names(room):
    found = [
        f"{path.name}:{line}"
        for path in sorted((PACKAGE / room).rglob("*.py"))
        for line in unnamed_in(path.read_text(encoding="utf-8"))
    ]
    assert not found


@pytest.mark.parametrize("room", ROOMS)
def test_thresholds_stand_once(room):
    """No two modules of a room have a threshold of one name: it is in one place, or two things."""
    values, where = defaultdict(set), defaultdict(list)
    for path in sorted((PACKAGE / room).rglob("*.py")):
        for name, value in named_in(path.read_text(encoding="utf-8")):
            values[name].add(value)
            where[name].append(path.name)
    twice = {name: where[name] for name in where if len(where[name]) > 1}
    again = {name for name in twice if len(values[name]) < len(where[name])}
    assert not again, f"one value, two places: {[(name, twice[name]) for name in sorted(again)]}"
    assert not twice, f"two values, one name: {sorted(twice)}"


CORE = PACKAGE.parent / "core"
SMALL_NUMBER = re.compile(r"(?<![A-Za-z_0-9.])[0-9]+(?:\.[0-9]+)?e-(?:[4-9]|[1-9][0-9])")
# Small numbers with a name and without one in the core; each may only fall.
NAMED_IN_CORE, LITERAL_IN_CORE = 56, 7


def small_numbers_of_core():
    """Yield the path, the code and the count of small numbers of a line."""
    for path in sorted((*CORE.rglob("*.cpp"), *CORE.rglob("*.hpp"))):
        for line in path.read_text(encoding="utf-8").splitlines():
            code = line.split("//")[0]
            # The polynomials of sine and cosine are formulas.
            if path.name != "numbers.hpp":
                yield path, code, len(SMALL_NUMBER.findall(code))


def test_thresholds_of_the_core_are_few_and_have_names():
    named, literal = 0, []
    for path, code, count in small_numbers_of_core():
        if "constexpr" in code:
            named += count
        else:
            literal += count * [f"{path.name}: {code.strip()}"]
    assert named <= NAMED_IN_CORE
    assert len(literal) <= LITERAL_IN_CORE, "\n".join(literal)


def test_a_name_of_the_core_has_one_value():
    found = defaultdict(set)
    for path in (*CORE.rglob("*.cpp"), *CORE.rglob("*.hpp")):
        for name, value in re.findall(
            r"constexpr double (\w+) = ([^;,]+)[;,]", path.read_text(encoding="utf-8")
        ):
            found[name].add(value)
    assert {name: values for name, values in found.items() if len(values) > 1} == {}
