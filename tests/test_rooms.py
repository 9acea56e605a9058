"""Rooms in order and files without circles: every import counts, in functions and for types too."""

import ast
import graphlib
import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "impulsekit"
CONTRIBUTING = Path(__file__).parents[1] / "docs" / "contributing.md"
# The package's face and its command stand above all rooms.
ABOVE = {"__init__", "__main__"}


def module_of(path):
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return parts[:-1] if parts[-1] == "__init__" else parts


FILES = {module_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def imports_of(module):
    """The modules of the package that a file imports, wherever in it."""
    path = FILES[module]
    package = module if path.name == "__init__.py" else module[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found = [tuple(alias.name.split(".")) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module != "_core":
            base = package[: len(package) - node.level + 1] if node.level else ()
            base += tuple(node.module.split(".")) if node.module else ()
            found = [(*base, alias.name) for alias in node.names]
        else:
            continue
        for name in found:
            while name and name not in FILES:
                name = name[:-1]
            if name and name != module:
                yield name


IMPORTS = {module: set(imports_of(module)) for module in FILES}


def listed(heading):
    """The rooms of a table of the page for contributors, from the first to the last."""
    page = CONTRIBUTING.read_text(encoding="utf-8")
    table = page[page.index(heading) :].split("\n\n")[0]
    first_columns = [line.split("|")[1] for line in table.splitlines()[2:]]
    return [
        name.removesuffix("/").removesuffix(".py")
        for column in first_columns
        for name in re.findall(r"`([\w./]+)`", column)
    ]


ORDERS = {
    ("impulsekit",): "| package | holds",
    ("impulsekit", "motion"): "| package of `motion/` | holds",
}


@pytest.mark.parametrize("home", ORDERS)
def test_no_import_runs_back_to_a_later_room(home):
    rooms, depth = listed(ORDERS[home]), len(home)
    place = {room: i for i, room in enumerate(rooms)}
    for module, imported in IMPORTS.items():
        if module[:depth] != home or len(module) == depth or module[depth] not in place:
            continue
        own = place[module[depth]]
        later = [
            ".".join(name)
            for name in imported
            if name[:depth] == home and len(name) > depth and place.get(name[depth], 0) > own
        ]
        assert not later, f"{'.'.join(module)} imports {later}"


def test_all_rooms_are_listed_for_contributors():
    rooms = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py"} - ABOVE
    rooms |= {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert sorted(listed(ORDERS["impulsekit",])) == sorted(rooms)
    folders = {path.parent.name for path in PACKAGE.glob("motion/*/__init__.py")}
    assert folders <= set(listed(ORDERS["impulsekit", "motion"]))


def test_no_files_import_each_other_in_a_circle():
    # Raises CycleError, which names the circle.
    tuple(graphlib.TopologicalSorter(IMPORTS).static_order())


def test_imports_in_functions_and_for_types_are_seen():
    of_face = IMPORTS["impulsekit",]
    assert ("impulsekit", "view", "notebook") in of_face, "in a function"
    of_scene = IMPORTS["impulsekit", "scene", "scene"]
    assert ("impulsekit", "scene", "entries") in of_scene, "for types"
