"""The rooms of ``motion`` in their order: what runs in one imports only from those above it."""

import ast
from pathlib import Path

import impulsekit.motion

HOME = Path(impulsekit.motion.__file__).parent
# As the page for contributors lists them.
ROOMS = ["zeros", "tree", "forces", "gaps", "steps", "rest", "dynamics", "events", "travel"]
ROOMS += ["record", "course", "flight", "run", "simulate", "maps"]
CONTRIBUTING = Path(__file__).parents[2] / "docs" / "contributing.md"


def run_time_imports(tree):
    """All imports of a module, without those for the type checker alone."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.ImportFrom):
            yield node
        yield from run_time_imports(node)


def rooms_called(path):
    """The rooms of ``motion`` from which a file imports."""
    package = path.relative_to(HOME.parent).with_suffix("").parts[:-1]
    for node in run_time_imports(ast.parse(path.read_text())):
        if node.level:
            base = (*package[: len(package) - node.level + 1], *(node.module or "").split("."))
            if base[0] == "motion" and len(base) > 1 and base[1] in ROOMS:
                yield base[1]


def test_every_room_imports_only_from_those_above():
    for path in sorted(HOME.rglob("*.py")):
        own = path.relative_to(HOME).with_suffix("").parts[0]
        if own in ROOMS:
            later = {room for room in rooms_called(path) if ROOMS.index(room) > ROOMS.index(own)}
            assert not later, f"{path.relative_to(HOME)} imports from {sorted(later)}"


def test_all_rooms_are_listed_for_contributors():
    folders = {path.parent.name for path in HOME.glob("*/__init__.py")}
    assert folders <= set(ROOMS)
    page = CONTRIBUTING.read_text()
    places = [page.index(f"| `{room}/` |") for room in ROOMS if room in folders]
    assert places == sorted(places)
