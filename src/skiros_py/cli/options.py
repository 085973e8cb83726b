"""Options that several commands have."""

from __future__ import annotations

import getpass
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from skiros_py.world.journal import DataDirectory

__all__ = ["AUTHOR", "DATA", "JSON", "Seconds", "data_option", "open_existing"]

_Command = TypeVar("_Command", bound=Callable[..., Any])


def data_option(*, required: bool = True) -> Callable[[_Command], _Command]:
    """Makes the option that names a data directory."""
    return click.option(
        "--data",
        required=required,
        metavar="DIR",
        type=click.Path(path_type=Path),
        help="Data directory in which the world lives.",
    )


def open_existing(data: Path) -> DataDirectory:
    """Opens a data directory that is there already.

    Raises:
        FileError: It is not there, another process uses it, it cannot be read or written, or a file is broken.
    """
    from skiros_py.runtime import open_data

    return open_data(data, create=False)


class Seconds(click.FloatRange):
    """A time [s] that a wait can last: more than none, and no longer than an hour."""

    def __init__(self) -> None:
        super().__init__(min=0.0, max=3600.0, min_open=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Reads the time that was given."""
        seconds: float = super().convert(value, param, ctx)
        if math.isnan(seconds):  # it is in every range, for all that comparisons tell
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return seconds


def _login() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a container may run as a user without a name
        return "somebody"


DATA = data_option()
"""Where the world lives."""
JSON = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
"""For programs that read the answer."""
AUTHOR = click.option("--author", default=_login, metavar="NAME", help="Who does it.  [default: your login]")
"""Who an edit is by."""
