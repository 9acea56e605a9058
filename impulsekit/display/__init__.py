"""The display of results: one line or tables of plain text, tables in a notebook."""

from .notebook import Displayed, show_with
from .one_line import OneLine, one_line

__all__ = ["Displayed", "OneLine", "one_line", "show_with"]
