"""The group of commands, and how errors reach the user. Commands import what they need."""

from __future__ import annotations

import errno
import itertools
import re
import warnings
from collections.abc import Sequence
from typing import Any

import click

from .. import __version__
from ..errors import AssumptionWarning, ImpulsekitError, SetupWarning, shown
from ..files import reason_of
from .batch import batch
from .common import BAD_INPUT, INTERRUPTED, OWN_FAULT
from .design import design, fit, identify
from .doctor import doctor
from .robots import init, inspect, robots
from .simulate import replay, simulate
from .solve import solve

# The commands by purpose, as the help text has them.
SECTIONS = {
    "Start": (init, robots, inspect, doctor),
    "Solve": (solve, simulate, replay),
    "Many states": (batch,),
    "Design and fit": (design, fit, identify),
}


class _Group(click.Group):
    """A group that turns exceptions into one line and an exit status."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands by purpose, instead of one list by the alphabet."""
        for title, commands in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl(
                    [(str(each.name), each.get_short_help_str(limit=200)) for each in commands]
                )

    def invoke(self, ctx: click.Context) -> Any:
        try:
            with warnings.catch_warnings():
                _show_warnings_once()
                return super().invoke(ctx)
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except KeyboardInterrupt:
            if ctx.params.get("debug"):
                raise
            click.echo("interrupted", err=True)
            ctx.exit(INTERRUPTED)
        except Exception as error:
            if ctx.params.get("debug") or getattr(error, "errno", None) == errno.EPIPE:
                raise
            if isinstance(error, ImpulsekitError | OSError):
                options = self.commands[ctx.invoked_subcommand or ""].params
                click.echo(f"error: {_by_option(_message(error), options)}", err=True)
                ctx.exit(BAD_INPUT)
            click.echo(
                f"bug: {type(error).__name__}: {error} (this is a fault of impulsekit "
                f'{__version__}; "impulsekit --debug {ctx.invoked_subcommand} ..." shows where)',
                err=True,
            )
            ctx.exit(OWN_FAULT)


def _show_warnings_once() -> None:
    """Warnings of impulsekit as a line each on stderr, and each of their sentences once."""
    otherwise = warnings.showwarning
    seen: set[str] = set()

    def show(message: Any, category: Any, *place: Any, **more: Any) -> None:
        if not isinstance(message, AssumptionWarning | SetupWarning):
            otherwise(message, category, *place, **more)
            return
        sentences = message.doubts if isinstance(message, SetupWarning) else (str(message),)
        for sentence in sentences:
            if sentence not in seen:
                seen.add(sentence)
                click.echo(f"warning: {sentence}", err=True)

    warnings.showwarning = show
    warnings.simplefilter("always", SetupWarning)
    warnings.simplefilter("always", AssumptionWarning)


def _message(error: ImpulsekitError | OSError) -> str:
    """An error in words; the system's reason without its number."""
    if isinstance(error, ImpulsekitError) or not error.filename:
        return str(error)
    return f"{shown(str(error.filename), 200)}: {reason_of(error)}"


# Functions in Python that a command stands for: their names say nothing to its user.
_FUNCTIONS = re.compile(r"(fit_impacts|fit_motion|find_impacts|calibrate|compare_laws|identify): ")
_OF_FORMAT = re.compile(r" (in|of) the RecordingFormat('s topics)?")


def _by_option(message: str, options: Sequence[click.Parameter]) -> str:
    """Return a message of Python in the words of a command: options in place of arguments."""
    message = _OF_FORMAT.sub("", _FUNCTIONS.sub("", message, count=1))
    for option in options:
        name, flag = option.name or "", option.opts[0]
        if not flag.startswith("--"):
            continue
        message = re.sub(rf'\b{re.escape(name)}="(\w+)"', rf"{flag} \1", message)
        if name and message.startswith((f"{name} ", f"{name}[", f"{name}:")):
            message = flag + message.removeprefix(name)
    return message


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, message="%(prog)s %(version)s")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
def main(debug: bool) -> None:
    """Rigid-body impact dynamics for URDF robots.

    A scene file (TOML) holds a robot, its state, and what strikes, holds or touches it.
    "impulsekit init first.toml" writes one to start from, "impulsekit solve first.toml"
    solves it. "impulsekit COMMAND --help" describes a command.
    """


for command in itertools.chain(*SECTIONS.values()):
    main.add_command(command)
