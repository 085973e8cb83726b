"""Options that several commands have."""

from __future__ import annotations

import getpass
import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from skiros_py.config import IMPORTS as IMPORT_FOLDERS
from skiros_py.errors import UsageError
from skiros_py.system import default_simulation

if TYPE_CHECKING:
    from skiros_py.world.journal.data_directory import DataDirectory

_SLOWEST, _FASTEST = 0.01, 1000.0
_Command = TypeVar("_Command", bound=Callable[..., Any])


def data_option(*, required: bool = True) -> Callable[[_Command], _Command]:
    """Returns the option for a data directory."""
    return click.option(
        "--data",
        required=required,
        metavar="DIR",
        type=click.Path(path_type=Path),
        help="Data directory of the world.",
    )


def open_existing(data: Path) -> DataDirectory:
    """Opens an existing data directory.

    Raises:
        FileError: It is not there, another process uses it, it cannot be read or written, or a file is broken.
    """
    from skiros_py.station.worlds import open_data

    return open_data(data, create=False)


GOAL = click.option("--goal", multiple=True, metavar="TEXT", help="Goal instead of the scene's; may be repeated.")
"""The option that states a goal."""
SEED = click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of all random numbers.")
"""The option that seeds a run."""
FAKE = click.option("--fake", is_flag=True, help="No physics: skills only assert their effects.")
"""The option that leaves out physics."""
GUI = click.option("--gui", is_flag=True, help="Open the simulation's window.")
"""The option that opens the simulation's window."""
DRIVER = click.option("--driver", metavar="NAME", help="Cell driver of a plug-in, instead of the simulation.")
"""The option that names a cell driver."""

SIMULATION = click.option(
    "--simulation",
    default=default_simulation,
    show_default="pybullet where it is installed, otherwise mujoco",
    metavar="mujoco|pybullet|NAME",
    help="Physics engine; a plug-in may bring another.",
)
"""The option that names a physics engine."""
IMPERFECTIONS = click.option(
    "--imperfections",
    type=click.FloatRange(0.0, 10.0),
    default=0.0,
    show_default=True,
    metavar="FACTOR",
    help="Factor of the simulated errors of measured poses, mounted cameras and depth; 1 for those of a real cell.",
)
"""The option that scales what a simulation is no better at than a real cell."""


class _Seconds(click.FloatRange):
    """A time [s] that a wait can last: more than none, and no longer than an hour."""

    def __init__(self) -> None:
        super().__init__(min=0.0, max=3600.0, min_open=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Parses a time."""
        seconds: float = super().convert(value, param, ctx)
        if math.isnan(seconds):  # it is in every range, for all that comparisons tell
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return seconds


def time_limit_option(default: float, what: str) -> Callable[[_Command], _Command]:
    """Returns the option for a time limit.

    Args:
        default: The default [s].
        what: What it limits, for the help text ("Time limit of a reasoner").
    """
    help_ = f"{what} [s], 3600 at most.  [default: {default:g}]"
    return click.option("--time-limit", type=_Seconds(), default=default, metavar="S", help=help_)


def _pace(text: str) -> float | None:
    """Parses a pace; None for as fast as possible."""
    if text == "max":
        return None
    try:
        factor = 1.0 if text == "real" else float(text)
    except ValueError:
        factor = -1.0
    if not _SLOWEST <= factor <= _FASTEST:
        raise click.BadParameter(f"'{text}' is not 'max', 'real' or a factor from {_SLOWEST} to {_FASTEST:.0f}")
    return factor


def key_values(
    option: str, texts: Iterable[str], example: str, form: str = "NAME=VALUE", is_name: Callable[[str], object] = bool
) -> dict[str, str]:
    """Parses a repeatable option with values by name.

    Args:
        option: Its name, for messages ("--param").
        texts: The values on the command line.
        example: A valid value ("kit=kit_1").
        form: The general form.
        is_name: Tells whether a text can be such a name.

    Raises:
        UsageError: One is written otherwise, or given twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (equals and is_name(name)):
            raise UsageError(f"{option} takes {form}, such as {example}, not '{text}'")
        if name in found:
            raise UsageError(f"{option} {name} is given twice")
        found[name] = value
    return found


def given_params(params: Iterable[str]) -> dict[str, str]:
    """Reads parameters of a module, written as KEY=VALUE.

    Raises:
        UsageError: One is written otherwise, or given twice.
    """
    return key_values("--param", params, "Location=pallet_a", "KEY=VALUE")


def _login() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a container may run as a user without a name
        return "somebody"


DATA = data_option()
"""Where the world lives."""
JSON = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
"""For programs that read the answer."""


def combined(*options: Callable[[Any], Any]) -> Callable[[_Command], _Command]:
    """Returns a decorator that adds several options and arguments, in this order."""

    def decorate(command: _Command) -> _Command:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


CONFIG = click.option(
    "--config",
    multiple=True,
    metavar="MODULE.KEY=VALUE",
    callback=lambda _context, _option, texts: key_values(
        "--config", texts, "move_arm.speed=0.5", "MODULE.KEY=VALUE", lambda name: "." in name
    ),
    help="A configuration parameter.",
)
"""The option for configuration parameters by "module.key"."""


def _leave_out(context: click.Context, _option: click.Parameter, names: tuple[str, ...]) -> None:
    from skiros_py.plugins.installation import leaving_out

    context.with_resource(leaving_out(names))


WITHOUT = click.option(
    "--without",
    multiple=True,
    metavar="DISTRIBUTION",
    expose_value=False,
    callback=_leave_out,
    help="Leave out all that a distribution contributes; may be repeated.",
)
"""The option that leaves out the plug-ins of a distribution, as long as the command runs."""


def _look_up(context: click.Context, _option: click.Parameter, folders: tuple[str, ...]) -> None:
    before = os.environ.get(IMPORT_FOLDERS, "")
    os.environ[IMPORT_FOLDERS] = ":".join((*folders, before))
    context.call_on_close(lambda: os.environ.update({IMPORT_FOLDERS: before}))


IMPORTS = click.option(
    "--imports",
    multiple=True,
    metavar="FOLDER",
    type=click.Path(exists=True, file_okay=False),
    expose_value=False,
    callback=_look_up,
    help="Look up imported ontologies in FOLDER, besides those of SKIROS_IMPORTS; may be repeated.",
)
"""The option for the folders with ontologies that are imported."""
SKILLS = combined(
    click.option(
        "--skills",
        multiple=True,
        metavar="NAME,…",
        callback=lambda _context, _option, texts: tuple(n.strip() for t in texts for n in t.split(",") if n.strip()),
        help="Load only these skills.  [default: all]",
    ),
    WITHOUT,
)
"""The options for the offered skills and plug-ins."""
PLANNER = combined(
    click.option("--planner", metavar="NAME", help="Planner to use.  [default: the first that fits the task]"),
    click.option(
        "--planner-command",
        metavar="TEMPLATE",
        help="Command of any PDDL planner, such as 'pyperplan -s gbf {domain} {problem}'; {plan} is the plan's file.",
    ),
    click.option("--temporal", is_flag=True, help="Temporal planning with durations; needs a temporal planner."),
)
"""The options that choose a planner: ``planner``, ``planner_command`` and ``temporal``."""
ASK = click.option(
    "--ask/--no-ask",
    default=None,
    help="Whether robots may ask questions, answered by lines of input.  [default: if input is a terminal]",
)
"""The option for questions to the person at the terminal."""
AUTHOR = click.option("--author", default=_login, metavar="NAME", help="Author of the edit.  [default: your login]")
"""The option for the author of an edit."""


def cell_options(pace: str) -> Callable[[_Command], _Command]:
    """Returns the options for opening a cell, with the names of ``station.session.Options``.

    Args:
        pace: Default of the pace.
    """
    help_ = f"Simulated seconds per second.  [default: {pace}]"
    pace_option = click.option("--pace", type=_pace, default=pace, metavar="max|real|N", help=help_)
    return combined(SEED, pace_option, FAKE, DRIVER, SIMULATION, IMPERFECTIONS, CONFIG, IMPORTS)
