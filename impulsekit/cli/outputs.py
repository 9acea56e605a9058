"""Files that a command will write: what cannot be written is told before the work."""

from __future__ import annotations

import json
from typing import Any

import click

__all__ = ["check_outputs", "json_option", "write_json"]

json_option = click.option(
    "--json", "json_to", type=click.Path(), help='Write all results as JSON; "-": stdout.'
)


def check_outputs(*files: str | None, picture: str | None = None) -> None:
    """Prove that files can be written; None and "-" stand for no file.

    Raises:
        FileError: one cannot be written.
        InputError: the ending of the picture is none that matplotlib knows.
        MissingExtraError: a picture is asked for, and matplotlib is not installed.
    """
    from ..files import check_writable

    for file in files:
        if file not in (None, "-"):
            check_writable(str(file))
    if picture is not None:
        from ..view.plots.canvas import check_picture

        check_picture(picture)


def write_json(data: Any, target: str | None) -> bool:
    """Write data as JSON, if that is asked for; whether stdout is left to text.

    Raises:
        FileError: the file cannot be written.
    """
    from ..display.plain import plain
    from ..files import write_file

    if target is None:
        return True
    text = json.dumps(plain(data), indent=2, allow_nan=False)
    if target != "-":
        write_file(target, text + "\n")
        return True
    click.echo(text)
    return False
