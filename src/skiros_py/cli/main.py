"""The ``skiros`` command: its sub-commands, and what happens to faults."""

from __future__ import annotations

import os
import sys
import traceback
from contextlib import nullcontext
from pathlib import Path

import click

from skiros_py.cli.ending import ignore_stops, leave, unwind_on_stops, warnings_on_stderr
from skiros_py.cli.lazy import LazyGroup
from skiros_py.cli.output import NOT_REACHED, REACHED, STOPPED, USAGE, answer, answers_alone, brief, silence
from skiros_py.errors import DeviceError, PlanningError, SkirosError
from skiros_py.interruptions import UserStop, by_user

_COMMANDS = {
    "run": ("run", "Plan and execute the goal of a scene."),
    "serve": ("serve", "Serve a scene or data directory to factory systems, clients and people."),
    "job": ("job", "Order, follow and command jobs of a server."),
    "stop": ("cell:stop", "Halt all robots of a server immediately."),
    "reset": ("cell:reset", "Allow motion again after a halt."),
    "manager": ("cell:manager", "Open and close the skill managers of a server while it runs."),
    "signal": ("cell:signal", "List, read and set the signals of a server."),
    "device": ("cell:device", "List, open, close, jog and teach the devices of a server while it runs."),
    "document": ("document", "Import, export, run and debug the documents of a server: trees, sequences, templates."),
    "call": ("call", "Call any operation of a server; list them."),
    "report": ("report", "Create a page about a run: timeline, pictures, events and their reasons."),
    "plan": ("plan", "Show domain, problem and plan without executing anything."),
    "rehearse": ("rehearse", "Try the plan for a goal in a second physics world; say what would fail."),
    "skills": ("skills", "List the installed skills, primitives and conditions."),
    "plugins": ("plugins", "List the installed plug-ins and their faults."),
    "check-plugin": ("check_plugin", "Check plug-ins against the rules, and test their skills."),
    "data": ("data", "Back up and check a data directory; export its audit log."),
    "key": ("key", "Create, list and revoke keys of a server."),
    "doctor": ("doctor", "Check this environment: what is installed, what is missing, how to fix it."),
    "module": ("module", "Run single skills and primitives; show which conditions hold, and why not."),
    "new": (
        "new",
        "Write a package, or a skill, primitive, condition, ontology, robot or scene into one.",
    ),
    "scene": ("scene", "Show, check, compare and save scenes."),
    "world": ("world", "Show, query and undo changes in the world of a data directory."),
    "ontology": ("ontology", "Check ontologies, generate Python constants for their terms."),
}


@click.command(
    cls=LazyGroup,
    elsewhere=_COMMANDS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Example: skiros run kitting --goal 'InKit(Starter, kit_1)' --record run.png",
)
@click.version_option(package_name="skiros-py", prog_name="skiros")
def cli() -> None:
    """Describe a scene and state a goal: a robot plans and executes it.

    Exit status: 0 goal reached, 1 not reached, 2 wrong usage or a broken file, 3 no plan, 130 stopped.
    """


def main() -> None:
    """Runs the command line; faults become one message and an exit status, never a traceback."""
    unwind_on_stops()
    arguments = sys.argv[1:]
    as_json = "--json" in arguments
    # stdout is for the answer where a program reads it, or where PyBullet's window prints from C
    stdout = answers_alone(prints=as_json) if as_json or "--gui" in arguments else nullcontext()
    try:
        with stdout, warnings_on_stderr():
            status = _run(arguments, as_json=as_json)
    except UserStop:  # a second stop, while the first was being answered
        status = STOPPED
    ignore_stops()
    leave(status)


def _run(arguments: list[str], *, as_json: bool) -> int:
    try:
        status = cli.main(args=arguments, prog_name="skiros", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return _fault(error.format_message(), USAGE, as_json=as_json)
    except (click.Abort, KeyboardInterrupt) as error:
        cause = error.__cause__ or error
        if isinstance(cause, KeyboardInterrupt) and not by_user(cause):
            return _internal(cause, as_json=as_json)
        ignore_stops()
        return _fault("stopped", STOPPED, as_json=as_json, show=True)
    except SkirosError as error:
        broken = isinstance(error, DeviceError | PlanningError)
        return _fault(brief(str(error)), NOT_REACHED if broken else USAGE, as_json=as_json, show=True)
    except BrokenPipeError:
        silence()
        return STOPPED
    except SystemExit as error:
        raised_in = Path(traceback.extract_tb(error.__traceback__)[-1].filename).parts
        if {"click", "rich"}.isdisjoint(raised_in):
            return _internal(error, as_json=as_json)
        # they exit when the reader of the output has left
        silence()
        return STOPPED
    except OSError as error:
        status = _fault(f"{error.strerror or error}", NOT_REACHED, as_json=False, show=True)
        silence()
        return status
    except BaseException as error:  # noqa: BLE001 - the last line of defence: users never see a traceback
        return _internal(error, as_json=as_json)
    return status if isinstance(status, int) else REACHED


def _internal(error: BaseException, *, as_json: bool) -> int:
    """Reports an exception that was not handled earlier, with its origin."""
    if os.environ.get("SKIROS_DEBUG"):
        traceback.print_exception(error)
    stack = "".join(traceback.format_tb(error.__traceback__))
    what = f"internal error: {type(error).__name__}: {error}\n"
    text = brief(what + stack)
    if text.strip() == what.strip():  # it is the platform's own
        last = traceback.extract_tb(error.__traceback__)[-1]
        text = f"{text.strip()} ({last.filename}:{last.lineno} in {last.name})"
    return _fault(f"{text} (SKIROS_DEBUG=1 shows where)", NOT_REACHED, as_json=as_json, show=True)


def _fault(text: str, status: int, *, as_json: bool, show: bool = False) -> int:
    if show:
        click.echo(f"skiros: {text}", err=True)
    if as_json:
        answer({"error": text, "status": status})
    return status
