"""Groups of commands that are imported when used, so that help is fast."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import click

from skiros_py.errors import UnknownName


class LazyGroup(click.Group):
    """A group of which some commands are in other modules.

    Args:
        *arguments: Those of a group.
        elsewhere: Where each of them is, as "module:object", and its short help, by its name.
        **options: Those of a group.
    """

    def __init__(self, *arguments: Any, elsewhere: Mapping[str, tuple[str, str]], **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._elsewhere = elsewhere

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Lists the names of all commands."""
        return [*self._elsewhere, *super().list_commands(ctx)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Imports a command.

        Raises:
            UsageError: There is none of that name.
        """
        if cmd_name in self._elsewhere:
            module, _, name = self._elsewhere[cmd_name][0].partition(":")
            command: click.Command = getattr(import_module(f"skiros_py.cli.{module}"), name or "command")
            return command
        if cmd_name not in self.commands:
            raise click.UsageError(str(UnknownName("command", cmd_name, self.list_commands(ctx))), ctx)
        return self.commands[cmd_name]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002  click's
        """Writes the short help of all commands, without importing them."""
        here = [(name, command.get_short_help_str(100)) for name, command in sorted(self.commands.items())]
        with formatter.section("Commands"):
            formatter.write_dl([*((name, help_) for name, (_, help_) in self._elsewhere.items()), *here])
