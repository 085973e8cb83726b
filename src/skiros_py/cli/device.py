"""``skiros device``: opens and closes the devices of a server."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.output import tell
from skiros_py.cli.reaching import with_client

if TYPE_CHECKING:
    from skiros_py.client import Client


@click.group("device")
def command() -> None:
    """Lists, opens and closes the devices of a server while it runs."""


@command.command("list", epilog="Example: skiros device list --data cell")
@with_client()
@JSON
def list_(client: Client, as_json: bool) -> int:
    """Lists the devices, with the robot that each belongs to, and whether it is open."""
    devices = client.devices.list()
    lines = (f"{d.id:12} {d.kind:12} {d.robot or '-':12} {'open' if d.open else 'closed'}" for d in devices)
    return tell(devices, lines, as_json=as_json)


@command.command("open", epilog="Example: skiros device open gripper_1 --data cell")
@click.argument("device")
@with_client()
@JSON
def open_(device: str, client: Client, as_json: bool) -> int:
    """Opens DEVICE: its driver is connected, and modules may use it."""
    return tell(client.devices.open(device), [f"{device} is open"], as_json=as_json)


@command.command("close", epilog="Example: skiros device close gripper_1 --data cell")
@click.argument("device")
@with_client()
@JSON
def close(device: str, client: Client, as_json: bool) -> int:
    """Closes DEVICE, if nothing uses it: no module may use it until it is opened."""
    return tell(client.devices.close(device), [f"{device} is closed"], as_json=as_json)
