"""``skiros manager``: opens and closes the skill managers of a server."""

from __future__ import annotations

from pathlib import Path

import click

from skiros_py.cli.exit_status import REACHED
from skiros_py.cli.options import JSON
from skiros_py.cli.output import answer
from skiros_py.cli.reaching import reach, server_options
from skiros_py.cli.text import escaped


@click.group("manager")
def command() -> None:
    """Lists, opens and closes the skill managers of a server while it runs."""


@command.command("list", epilog="Example: skiros manager list --data cell")
@server_options
@JSON
def list_(data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Lists the skill managers that are open, with what each offers and runs."""
    with reach(data, url, key_file) as client:
        managers = client.modules.managers()
    if as_json:
        answer([manager.model_dump(mode="json") for manager in managers])
        return REACHED
    for manager in managers:
        state = f"lost: {manager.lost}" if manager.lost else f"{len(manager.skills)} skills"
        running = f", runs {', '.join(one.module for one in manager.running)}" if manager.running else ""
        click.echo(escaped(f"{manager.agent:12} {manager.robot:12} {state}{running}"))
    return REACHED


@command.command("open", epilog="Example: skiros manager open arm_1 --data cell")
@click.argument("agent")
@server_options
@JSON
def open_(agent: str, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Opens the skill manager of the subsystem AGENT: its skills are on offer from now on."""
    with reach(data, url, key_file) as client:
        manager = client.modules.open_manager(agent)
    if as_json:
        answer(manager.model_dump(mode="json"))
    else:
        click.echo(escaped(f"{manager.agent} offers {', '.join(manager.skills) or 'no skill'}"))
    return REACHED


@command.command("close", epilog="Example: skiros manager close arm_1 --data cell")
@click.argument("agent")
@click.option("--force", is_flag=True, help="Stop first what it runs.")
@server_options
@JSON
def close(agent: str, force: bool, data: Path | None, url: str | None, key_file: Path | None, as_json: bool) -> int:
    """Closes the skill manager of the subsystem AGENT: nothing is planned with its skills any more."""
    with reach(data, url, key_file) as client:
        client.modules.close_manager(agent, force=force)
    if as_json:
        answer({"closed": agent})
    else:
        click.echo(escaped(f"{agent} is closed"))
    return REACHED
