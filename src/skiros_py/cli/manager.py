"""``skiros manager``: opens and closes the skill managers of a server."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.output import tell
from skiros_py.cli.reaching import with_client

if TYPE_CHECKING:
    from skiros_py.api.modules import ManagerInfo
    from skiros_py.client import Client


@click.group("manager")
def command() -> None:
    """Lists, opens and closes the skill managers of a server while it runs."""


@command.command("list", epilog="Example: skiros manager list --data cell")
@with_client()
@JSON
def list_(client: Client, as_json: bool) -> int:
    """Lists the skill managers that are open, with what each offers and runs."""
    managers = client.modules.managers()
    return tell(managers, map(_line, managers), as_json=as_json)


def _line(manager: ManagerInfo) -> str:
    state = f"lost: {manager.lost}" if manager.lost else f"{len(manager.skills)} skills"
    running = f", runs {', '.join(one.module for one in manager.running)}" if manager.running else ""
    return f"{manager.agent:12} {manager.robot:12} {state}{running}"


@command.command("open", epilog="Example: skiros manager open arm_1 --data cell")
@click.argument("agent")
@with_client()
@JSON
def open_(agent: str, client: Client, as_json: bool) -> int:
    """Opens the skill manager of the subsystem AGENT: its skills are on offer from now on."""
    manager = client.modules.open_manager(agent)
    return tell(manager, [f"{agent} offers {', '.join(manager.skills) or 'no skill'}"], as_json=as_json)


@command.command("close", epilog="Example: skiros manager close arm_1 --data cell")
@click.argument("agent")
@click.option("--force", is_flag=True, help="Stop first what it runs.")
@with_client()
@JSON
def close(agent: str, force: bool, client: Client, as_json: bool) -> int:
    """Closes the skill manager of the subsystem AGENT: nothing is planned with its skills any more."""
    client.modules.close_manager(agent, force=force)
    return tell({"closed": agent}, [f"{agent} is closed"], as_json=as_json)
