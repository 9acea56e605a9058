"""Rooms of the native core in order: an include leads into its own room or one before it."""

import re
from pathlib import Path

import pytest

CORE = Path(__file__).parents[1] / "core"
PAGE = Path(__file__).parents[1] / "docs" / "core.md"
SOURCES = sorted(path for end in ("cpp", "hpp") for path in CORE.rglob(f"*.{end}"))
INCLUDE = re.compile(r'^ *# *include +(["<])([^">]+)[">]', re.MULTILINE)


def listed():
    """Return the rooms of the table of the page on the core, from the first to the last."""
    page = PAGE.read_text(encoding="utf-8")
    table = page[page.index("| room | holds") :].split("\n\n")[0]
    return [re.search(r"`(\w+)/`", line).group(1) for line in table.splitlines()[2:]]


def includes_of(path):
    """Return what a file includes: files of the core, then headers of others."""
    found = INCLUDE.findall(path.read_text(encoding="utf-8"))
    own, others = ([name for mark, name in found if mark == kind] for kind in '"<')
    return own, others


def room_of(path):
    return path.relative_to(CORE).parts[0]


def test_every_source_stands_in_a_room_of_the_table():
    assert {room_of(path) for path in SOURCES} == set(listed())


@pytest.mark.parametrize("room", listed())
def test_no_include_runs_back_to_a_later_room(room):
    rooms = listed()
    for path in SOURCES:
        if room_of(path) != room:
            continue
        for name in includes_of(path)[0]:
            assert (CORE / name).is_file(), f"{path.name}: {name} is named from the core's root"
            later = rooms[rooms.index(room) + 1 :]
            assert name.split("/")[0] not in later, f"{path.relative_to(CORE)} includes {name}"


def test_only_bind_includes_nanobind_or_python():
    python = {
        room_of(path)
        for path in SOURCES
        for name in includes_of(path)[1]
        if name == "Python.h" or name.startswith("nanobind/")
    }
    assert python == {"bind"}


def test_headers_do_not_include_each_other_in_a_circle():
    headers = {str(path.relative_to(CORE)): path for path in SOURCES if path.suffix == ".hpp"}
    done = set()

    def visit(name, above):
        assert name not in above, f"{name} includes itself by way of {above}"
        if name not in done:
            for other in includes_of(headers[name])[0]:
                visit(other, (*above, name))
            done.add(name)

    for name in headers:
        visit(name, ())
