"""``skiros doctor``: explains an environment."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import click

from skiros_py.cli.doctor_checks import CHECKS, Check, Finding, data_folder
from skiros_py.cli.exit_status import NOT_REACHED, REACHED
from skiros_py.cli.options import JSON, data_option
from skiros_py.cli.output import answer
from skiros_py.cli.text import escaped


@click.command("doctor", epilog="Example: skiros doctor --json")
@data_option(required=False)
@JSON
def command(data: Path | None, as_json: bool) -> int:
    """Looks at this environment: Python, libraries, plug-ins, ontologies, scenes, planner; says what to do.

    Exit status: 0 nothing is wrong (what is optional and absent is noted), 1 something is.
    """
    found: list[dict[str, Any]] = []
    wrong = False
    checks = dict(CHECKS)
    if data is not None:
        checks["data"] = partial(data_folder, data)
    for name, check in checks.items():
        for finding in examined(check):
            wrong = wrong or finding.wrong
            found.append({"check": name, "state": _state(finding), "text": finding.text, "todo": finding.todo})
            if not as_json:
                _print(name, finding)
    if as_json:
        answer({"checks": found, "status": NOT_REACHED if wrong else REACHED})
    elif not wrong:
        click.echo("nothing is wrong")
    return NOT_REACHED if wrong else REACHED


def examined(check: Check) -> Iterator[Finding]:
    """Makes one check; one that breaks is reported, and does not keep the others from being made.

    Yields:
        What it found; where it has nothing to say, that nothing is wrong.
    """
    said = False
    try:
        for finding in check():
            said = True
            yield finding
    except (GeneratorExit, KeyboardInterrupt):
        raise
    except BaseException as error:  # noqa: BLE001 - an environment can be broken in any way
        yield Finding(f"the check itself broke: {type(error).__name__}: {error}", "see the other lines", wrong=True)
    else:
        if not said:
            yield Finding("nothing wrong")


def _state(finding: Finding) -> str:
    return "wrong" if finding.wrong else "note" if finding.todo else "ok"


def _print(name: str, finding: Finding) -> None:
    click.echo(escaped(f"{_state(finding):5}  {name:18}  {finding.text}"))
    if finding.todo:
        click.echo(escaped(f"{'':27}do: {finding.todo}"))
