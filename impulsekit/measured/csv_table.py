"""CSV tables as loggers and vendors write them: separators, decimal commas, units in names."""

from __future__ import annotations

import csv
import re
from typing import Any

from ..errors import InputError, quoted, shown

# By vendor, how the first line of an export begins, in any case.
_FIRST_LINES = {
    "Motive": r"format version,",
    "Vicon Nexus": r"(objects|trajectories|joints|segments|model outputs|devices)\s*,*$",
    "Qualisys Track Manager": r"no_of_frames[\t,;]",
}
_FORM = (
    "one row of names, such as t [s], position.x [m], position.y [m], position.z [m], "
    "quaternion_xyzw.x, .y, .z, .w, and one row for each sample below"
)
# Names that others have, and what the columns of a recording are called.
_OTHER_NAMES = (
    (r"%?(time|timestamp|stamp|secs?|seconds)(stamp)?[ _]?(s|ms|us|ns|\(seconds\))?", "t"),
    (r"(?:[pt]|pos|position|trans|translation|tf)?[ ._]?([xyz])", "position.{}"),
    (r"(?:q|quat|quaternion|rot|rotation|orientation)[ ._]?([xyzw])", "quaternion_xyzw.{}"),
    (r"(?:v|vel|velocity)[ ._]?([xyz])", "velocity.{}"),
)


def hint_for_table(first: str) -> str | None:
    """Return advice for a table that begins with this line; None if it looks like no export.

    Example:
        >>> hint_for_table("Format Version,1.23,Take Name,walk")[:35]
        'this looks like an export of Motive'
    """
    line = first.strip()
    for vendor, pattern in _FIRST_LINES.items():
        if re.match(pattern, line, re.IGNORECASE):
            return f"this looks like an export of {vendor}; it is not read as it is: give {_FORM}"
    cells = re.split(r"[,;\t ]+", line)
    if len(cells) > 1 and all(map(is_number, cells)):
        return f"the first row holds numbers, and no names of columns; give {_FORM}"
    return None


def hint_for_name(name: str) -> str | None:
    """Return the name that a column may be given, if its own is one that others have.

    Example:
        >>> hint_for_name("qw")
        'quaternion_xyzw.w'
    """
    for pattern, ours in _OTHER_NAMES:
        found = re.fullmatch(pattern, name.strip(), re.IGNORECASE)
        if found:
            return ours.format(found.group(1).lower() if "{" in ours else "")
    return None


def is_number(cell: Any) -> bool:
    """Return whether ``float`` takes a cell."""
    try:
        float(cell)
    except (TypeError, ValueError):
        return False
    return True


# A unit behind a name, as in "t [s]" or "position.x (mm)".
_UNIT = re.compile(r"(.+?)\s*(?:\[\s*([^\]\d]*?)\s*\]|\(\s*(.*?)\s*\))$")
# Units that columns have without further words, and what to state for the others.
_PLAIN = ("", "-", "1", "s", "m", "rad", "m/s", "rad/s")
_STATED = {"ms": 'time="ms"', "us": 'time="us"', "µs": 'time="us"', "ns": 'time="ns"',
           "mm": 'length="mm"', "cm": 'length="cm"', "mm/s": 'length="mm"', "cm/s": 'length="cm"',
           "deg": 'angle="deg"', "°": 'angle="deg"', "deg/s": 'angle="deg"',
           "°/s": 'angle="deg"'}  # fmt: skip
SEPARATORS = (";", "\t")


def csv_columns(data: bytes, label: str) -> dict[str, list[str]]:
    """Return the cells of each column by its name.

    Columns are separated by commas, or by semicolons or tabs where the names are; numbers may
    then have decimal commas. Lines that begin with # before the names are comments.

    Raises:
        InputError: no table in UTF-8, an export of motion capture as it is, no rows, rows of other
            lengths, a name twice.
    """
    try:
        text = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(f"{label}: no CSV table in UTF-8 ({error})") from None
    while text and (not text[0].strip() or text[0].lstrip().startswith("#")):
        text.pop(0)
    hint = hint_for_table(text[0]) if text else None
    if hint is not None:
        raise InputError(f"{label}: {hint}")
    separator = next((s for s in SEPARATORS if text and s in text[0] and "," not in text[0]), ",")
    try:
        lines = [line for line in csv.reader(text, delimiter=separator) if any(line)]
    except csv.Error as error:
        raise InputError(f"{label}: no CSV table in UTF-8 ({error})") from None
    if len(lines) < 2:
        raise InputError(f"{label}: there is no row below the names of the columns")
    header = [cell.strip() for cell in lines[0]]
    for number, line in enumerate(lines[1:], start=2):
        if len(line) != len(header):
            raise InputError(
                f"{label}: row {number} has {len(line)} cells, the first has {len(header)} "
                "columns; names of the columns stand in the first row, comments begin with #"
            )
    found: dict[str, list[str]] = {}
    for k, name in enumerate(header):
        cells = [line[k].strip() for line in lines[1:]]
        if not name and not any(cells):
            continue  # what a separator at the end of each line makes
        if name in found:
            raise InputError(f"{label}: two columns are called {quoted(name)}; keep one")
        found[name] = cells if separator == "," else [_with_point(cell) for cell in cells]
    return found


def _with_point(cell: str) -> str:
    """Return a number with its decimal comma as a point; with both it stays, which is no number."""
    return cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell


def without_unit(name: str, stated: tuple[str, str, str], label: str) -> str:
    """Return the name of a column without the unit behind it.

    Args:
        stated: units of time, length and angle of the ``RecordingFormat``.

    Raises:
        InputError: a unit that is not the stated one, or is not known.
    """
    found = _UNIT.match(name)
    unit = None if found is None else (found.group(2) or found.group(3) or "").strip()
    if found is None or unit is None or unit in _PLAIN:
        return name if found is None else found.group(1)
    if unit not in _STATED:
        raise InputError(f"{label}: column {quoted(shown(name, 80))} has an unknown unit")
    needed = _STATED[unit]
    if needed.split('"')[1] not in stated:
        raise InputError(
            f"{label}: column {quoted(shown(name, 80))}: state {needed} in the RecordingFormat"
        )
    return found.group(1)
