"""``skiros manager|device|stop|reset``: the skill managers and devices of a server; everything halts, and goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.output import NOT_REACHED, REACHED, tell
from skiros_py.cli.reaching import Found, served, with_client

if TYPE_CHECKING:
    from skiros_py.api.alarms import StopInfo
    from skiros_py.api.modules import ManagerInfo
    from skiros_py.client import Client

_TIMEOUT, _TRIES = 3.0, 3
"""A stop that does not work must be known soon [s], [tries]."""


@click.group("manager")
def manager() -> None:
    """Lists, opens and closes the skill managers of a server while it runs."""


@served(manager, "manager list --data cell")
def list_managers(client: Client) -> Found:
    """Lists the skill managers that are open, with what each offers and runs."""
    managers = client.modules.managers()
    return managers, map(_line, managers)


def _line(manager: ManagerInfo) -> str:
    state = f"lost: {manager.lost}" if manager.lost else f"{len(manager.skills)} skills"
    running = f", runs {', '.join(one.module for one in manager.running)}" if manager.running else ""
    return f"{manager.agent:12} {manager.robot:12} {state}{running}"


@served(manager, "manager open arm_1 --data cell")
@click.argument("agent")
def open_manager(client: Client, agent: str) -> Found:
    """Opens the skill manager of the subsystem AGENT: its skills are on offer from now on."""
    opened = client.modules.open_manager(agent)
    return opened, [f"{agent} offers {', '.join(opened.skills) or 'no skill'}"]


@served(manager, "manager close arm_1 --data cell")
@click.argument("agent")
@click.option("--force", is_flag=True, help="Stop first what it runs.")
def close_manager(client: Client, agent: str, force: bool) -> Found:
    """Closes the skill manager of the subsystem AGENT: nothing is planned with its skills any more."""
    client.modules.close_manager(agent, force=force)
    return {"closed": agent}, [f"{agent} is closed"]


@click.group("device")
def device() -> None:
    """Lists, opens and closes the devices of a server while it runs."""


@served(device, "device list --data cell")
def list_devices(client: Client) -> Found:
    """Lists the devices, with the robot that each belongs to, and whether it is open."""
    devices = client.devices.list()
    return devices, (f"{d.id:12} {d.kind:12} {d.robot or '-':12} {'open' if d.open else 'closed'}" for d in devices)


@served(device, "device open gripper_1 --data cell")
@click.argument("device")
def open_device(client: Client, device: str) -> Found:
    """Opens DEVICE: its driver is connected, and modules may use it."""
    return client.devices.open(device), [f"{device} is open"]


@served(device, "device close gripper_1 --data cell")
@click.argument("device")
def close_device(client: Client, device: str) -> Found:
    """Closes DEVICE, if nothing uses it: no module may use it until it is opened."""
    return client.devices.close(device), [f"{device} is closed"]


@click.command("stop", epilog="Example: skiros stop --data cell --reason 'a person is in the cell'")
@click.option("--reason", default="", metavar="TEXT", help="Why, for those who have to reset it.")
@with_client(timeout=_TIMEOUT, tries=_TRIES)
@JSON
def stop(reason: str, client: Client, as_json: bool) -> int:
    """Halts all robots of a server in the next control cycle; nothing moves until 'skiros reset'.

    It does not replace the emergency stop of a machine. Exit status: 0 obeyed, 1 not, or not known.
    """
    return _show(client.station.stop(reason), as_json=as_json)


@click.command("reset", epilog="Example: skiros reset --data cell")
@with_client()
@JSON
def reset(client: Client, as_json: bool) -> int:
    """Lets the robots of a server start again after everything was halted; look first why that was.

    Jobs that were under way wait for an answer then: skiros job answer JOB retry.
    """
    return _show(client.station.reset(), as_json=as_json)


def _show(info: StopInfo, *, as_json: bool) -> int:
    """Shows whether everything is halted, and returns the exit status that says whether that can be relied on."""
    if not info.obeyed and info.halted and not as_json:
        click.echo("NOT OBEYED: the control thread does not run; press the button of the machine", err=True)
        return NOT_REACHED
    by = f", by {info.by}" if info.by else ""
    halted = f"halted ({info.why}{by}): {'everything stands' if info.standing else 'it brakes'}"
    tell(info, [halted if info.halted else "nothing is halted"], as_json=as_json)
    return REACHED if info.obeyed else NOT_REACHED
