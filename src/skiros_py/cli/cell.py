"""``skiros manager|device|signal|stop|reset``: managers, devices and signals of a server; a halt and its end."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from skiros_py.cli.commands import Found, served
from skiros_py.cli.options import combined, given_params
from skiros_py.cli.output import NOT_REACHED, REACHED
from skiros_py.errors import DeviceError

if TYPE_CHECKING:
    from skiros_py.api.alarms import StopInfo
    from skiros_py.api.modules import ManagerInfo, ModuleRunInfo
    from skiros_py.api.robots import SignalValue
    from skiros_py.client import Client

_TIMEOUT, _TRIES = 3.0, 3
"""The user must learn soon that a stop failed [s], [tries]."""
_POLLING = 0.1
"""Time between two looks at a run [s]."""


def _value(_context: click.Context, _parameter: click.Parameter, text: str) -> SignalValue:
    from skiros_py.api.robots import SetSignal

    try:
        return SetSignal(value=json.loads(text)).value
    except ValueError:
        raise click.BadParameter(f"{text} is no finite number, truth value or list of numbers") from None


@click.group("manager")
def manager() -> None:
    """Lists, opens and closes the skill managers of a server while it runs."""


@served("manager list --data cell", manager)
def list_managers(client: Client) -> Found:
    """Lists the open skill managers, with their skills and running modules."""
    managers = client.modules.managers()
    return managers, map(_line, managers.items)


def _line(manager: ManagerInfo) -> str:
    state = f"lost: {manager.lost}" if manager.lost else f"{len(manager.skills)} skills"
    running = f", runs {', '.join(one.module for one in manager.running)}" if manager.running else ""
    return f"{manager.agent:12} {manager.robot:12} {state}{running}"


@served("manager open arm_1 --data cell", manager)
@click.argument("agent")
def open_manager(client: Client, agent: str) -> Found:
    """Opens the skill manager of the subsystem AGENT: its skills become available."""
    opened = client.modules.open_manager(agent)
    return opened, [f"{agent} offers {', '.join(opened.skills) or 'no skill'}"]


@served("manager close arm_1 --data cell", manager)
@click.argument("agent")
@click.option("--force", is_flag=True, help="Stop its running modules first.")
def close_manager(client: Client, agent: str, force: bool) -> Found:
    """Closes the skill manager of the subsystem AGENT: its skills are no longer used for planning."""
    client.modules.close_manager(agent, force=force)
    return {"closed": agent}, [f"{agent} is closed"]


@click.group("device")
def device() -> None:
    """Lists, opens, closes, jogs and teaches the devices of a server while it runs."""


@served("device list --data cell", device)
def list_devices(client: Client) -> Found:
    """Lists the devices, with the robot that each belongs to, and whether it is open."""
    devices = client.devices.list()
    return devices, (
        f"{d.id:12} {d.kind:12} {d.robot or '-':12} {'open' if d.open else 'closed'}" for d in devices.items
    )


@served("device open gripper_1 --data cell", device)
@click.argument("device")
def open_device(client: Client, device: str) -> Found:
    """Opens DEVICE: its driver is connected, and modules may use it."""
    return client.devices.open(device), [f"{device} is open"]


@served("device close gripper_1 --data cell", device)
@click.argument("device")
def close_device(client: Client, device: str) -> Found:
    """Closes DEVICE, if nothing uses it: no module may use it until it is opened."""
    return client.devices.close(device), [f"{device} is closed"]


_by_hand = combined(
    click.argument("device"),
    click.option("--module", metavar="NAME", help="One of the modules for this.  [default: the first of the kind]"),
    click.option("--param", "params", multiple=True, metavar="KEY=VALUE", help="A parameter of the module. Repeat it."),
)


@served("device jog gripper_1 --param gap=0.03 --data cell", device)
@_by_hand
def jog_device(client: Client, device: str, module: str | None, params: tuple[str, ...]) -> Found:
    """Moves DEVICE by a small step, or home, and waits until it stands; Ctrl-C stops it."""
    return _followed(client, client.devices.jog(device, given_params(params), module=module))


@served("device teach base_1 --param location=pallet_a --data cell", device)
@_by_hand
def teach_device(client: Client, device: str, module: str | None, params: tuple[str, ...]) -> Found:
    """Learns something from the current state of DEVICE, such as a grasp or a driving pose."""
    return _followed(client, client.devices.teach(device, given_params(params), module=module))


def _followed(client: Client, run: ModuleRunInfo) -> Found:
    """Waits for the end of a run.

    Raises:
        DeviceError: It failed, or was stopped.
    """
    try:
        while run.status in ("running", "paused", "stopping"):
            time.sleep(_POLLING)
            run = client.modules.get_run(run.id)
    except KeyboardInterrupt:
        client.modules.command(run.id, "stop")
        raise
    text = run.rounds[-1].text if run.rounds else run.status
    if run.status != "succeeded":
        raise DeviceError(f"{run.module} of {run.agent}: {text}")
    return run, [text]


@click.group("signal")
def signal() -> None:
    """Lists, reads and sets the signals of a server: of devices, computed ones, and inputs."""


@served("signal list --data cell", signal)
def list_signals(client: Client) -> Found:
    """Lists the signals, with their unit, dimension, source and meaning."""
    signals = client.signals.list()
    return signals, (
        f"{s.name:24} {s.unit or '-':8} {s.dimension or '-':16} {'input' if s.input else s.source:20} {s.help}"
        for s in signals.items
    )


@served("signal get gripper_1.gap --data cell", signal)
@click.argument("names", nargs=-1, required=True)
def get_signals(client: Client, names: tuple[str, ...]) -> Found:
    """Reads the signals NAMES, all in the same control cycle."""
    readings = client.signals.read(*names)
    lines = []
    for name, one in readings.signals.items():
        lines.append(f"{name:24} {one.reason if one.value is None else json.dumps(one.value)}")
    return readings, lines


@served("signal set speed_limit 0.3 --data cell", signal)
@click.argument("name")
@click.argument("value", callback=_value)
def set_signal(client: Client, name: str, value: SignalValue) -> Found:
    """Sets the input NAME to VALUE (a number, true or false, or [numbers]) from the next control cycle on."""
    client.signals.set(name, value)
    return {name: value}, [f"{name} is {json.dumps(value)}"]


@served("stop --data cell --reason 'a person is in the cell'", client={"timeout": _TIMEOUT, "tries": _TRIES})
@click.option("--reason", default="", metavar="TEXT", help="Reason, for the person who resets the halt.")
def stop(client: Client, reason: str) -> Found:
    """Halts all robots of a server in the next control cycle; nothing moves until 'skiros reset'.

    It does not replace the emergency stop of a machine. Exit status: 0 obeyed, 1 not, or not known.
    """
    return _halt(client.station.stop(reason))


@served("reset --data cell")
def reset(client: Client) -> Found:
    """Allows the robots of a server to move again after a halt; check its reason first.

    Interrupted jobs then wait for an answer: skiros job answer JOB retry.
    """
    return _halt(client.station.reset())


def _halt(info: StopInfo) -> Found:
    """Describes whether everything is halted; the exit status says whether the server obeyed."""
    status = REACHED if info.obeyed else NOT_REACHED
    if info.halted and not info.obeyed:
        return info, _not_obeyed(), status
    by = f", by {info.by}" if info.by else ""
    halted = f"halted ({info.why}{by}): {'all devices stand still' if info.standing else 'braking'}"
    return info, [halted if info.halted else "nothing is halted"], status


def _not_obeyed() -> Iterator[str]:
    click.echo("NOT OBEYED: the control thread does not run; press the button of the machine", err=True)
    yield from ()
