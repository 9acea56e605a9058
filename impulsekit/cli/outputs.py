"""Files that a command will write: what cannot be written is told before the work."""

from __future__ import annotations

__all__ = ["check_outputs"]


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
