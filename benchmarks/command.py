"""A command whose mistakes of users are told in one line."""

from __future__ import annotations

from typing import Any

import click


class Command(click.Command):
    """A click command; errors of impulsekit end it with status 2."""

    def invoke(self, ctx: click.Context) -> Any:
        """What the command returns."""
        from impulsekit.errors import ImpulsekitError

        try:
            return super().invoke(ctx)
        except ImpulsekitError as error:
            raise click.UsageError(str(error)) from None
