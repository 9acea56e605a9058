"""What exports of motion capture look like, and what to make of them: told, not guessed."""

from __future__ import annotations

import re

__all__ = ["hint_for_name", "hint_for_table"]

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
    """What to do with a table that begins with this line; None if it looks like no export.

    Example:
        >>> hint_for_table("Format Version,1.23,Take Name,walk")[:35]
        'this looks like an export of Motive'
    """
    line = first.strip()
    for vendor, pattern in _FIRST_LINES.items():
        if re.match(pattern, line, re.IGNORECASE):
            return f"this looks like an export of {vendor}; it is not read as it is: give {_FORM}"
    cells = re.split(r"[,;\t ]+", line)
    if len(cells) > 1 and all(map(_is_number, cells)):
        return f"the first row holds numbers, and no names of columns; give {_FORM}"
    return None


def hint_for_name(name: str) -> str | None:
    """What a column may be called instead, if its name is one that others have.

    Example:
        >>> hint_for_name("qw")
        'quaternion_xyzw.w'
    """
    for pattern, ours in _OTHER_NAMES:
        found = re.fullmatch(pattern, name.strip(), re.IGNORECASE)
        if found:
            return ours.format(found.group(1).lower() if "{" in ours else "")
    return None


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
