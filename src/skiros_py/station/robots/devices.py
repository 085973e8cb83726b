"""Devices and signals: as their kinds describe them, read, set, opened and closed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from skiros_py.api.robots import (
    CellSignal,
    DeviceInfo,
    DeviceReading,
    JointDescription,
    SignalInfo,
    SignalReading,
    SignalReadings,
)
from skiros_py.api.view import PoseInfo
from skiros_py.errors import DeviceError, Refused, SkirosError, UnknownName, WrongState
from skiros_py.execution.signals import SignalLost, Signals
from skiros_py.ports.device import to_plain
from skiros_py.ports.driver import CompositeDriver, Connection
from skiros_py.ports.kinematics import JointRange, Kinematics
from skiros_py.ports.signals import Value, dimension_of
from skiros_py.ports.values import Snapshot
from skiros_py.station.control import ControlThread
from skiros_py.station.requests import Service, addressed
from skiros_py.station.robots.manual import device_modules
from skiros_py.station.session import Session
from skiros_py.world.vocabulary import HELD_BY

_UNLIMITED = JointRange(None, None, None)


def device_infos(session: Session) -> list[DeviceInfo]:
    """Describes all devices of the cell."""
    return [device_info(session, id_) for id_ in session.spec.devices]


def device_info(session: Session, id_: str) -> DeviceInfo:
    """Describes a device; callable in any thread.

    Raises:
        UnknownName: There is none with this id.
    """
    group = session.spec.group_of(id_)
    device = group.device(id_)
    model = session.runtime.context.frames.kinematics(group)
    robot = group.id if group in session.spec.robots else None
    described = to_plain(device)
    described.pop("id")
    return DeviceInfo(
        id=id_,
        kind=device.kind,
        robot=robot,
        model="" if robot else group.model,
        place=None if robot else PoseInfo.view_of(group.place),
        description=described,
        signals=tuple(SignalInfo.view_of(s, dimension=dimension_of(s.unit)) for s in device.signals),
        open=id_ not in session.cycle.board.closed,
        commanded=device.target_type is not None,
        joints=tuple(joint_description(name, model) for name in device.joint_names),
        frames=device.frame_names,
        mounted_on=device.mounted_on,
        jog=device_modules(session, id_, device.jog),
        teach=device_modules(session, id_, device.teach),
    )


def joint_description(name: str, model: Kinematics | None) -> JointDescription:
    """Describes a joint of a model; without limits where the model is not known."""
    joint = _UNLIMITED if model is None else model.joints.get(name, _UNLIMITED)
    return JointDescription(name=name, lower=joint.lower, upper=joint.upper, velocity=joint.velocity)


def device_reading(session: Session, id_: str) -> DeviceReading:
    """Returns the present readings of a device; does not block; callable from any thread.

    Raises:
        UnknownName: There is none with this id.
    """
    board = session.cycle.board
    if id_ not in board.devices:
        raise UnknownName("device", id_, board.devices)
    snapshot = board.snapshot
    state = snapshot.devices.get(id_)
    signals = () if state is None else board.devices[id_].signals
    return DeviceReading(
        id=id_,
        time=snapshot.time,
        cycle=snapshot.cycle,
        signals={signal.name: signal.read(state) for signal in signals},
        **device_state(session, snapshot, id_),
    )


def device_state(session: Session, snapshot: Snapshot, id_: str) -> dict[str, Any]:
    """Returns the state of a device in one cycle as plain data, as :class:`~skiros_py.api.view.DeviceState` has it."""
    board, state = session.cycle.board, snapshot.devices.get(id_)
    device, still, data = board.devices[id_], True, None
    if state is not None:
        with suppress(DeviceError):  # of a kind that fails there is no state; the alarms name it
            still = board.guard.call(device, "still", state)
            data = board.guard.call(device, "encode", state)
    return {
        "still": still,
        "state": data,
        "holds": next(iter(session.world.snapshot().subjects(HELD_BY, id_)), None),
    }


class SignalService(Service):
    """Describes, reads and sets signals."""

    def all(self) -> list[CellSignal]:
        """Describes all signals, those of the devices first."""
        signals = self._station.session.runtime.signals
        return [_described(signals, name) for name in signals.names]

    def read(self, names: Sequence[str]) -> SignalReadings:
        """Returns the values of signals in one control cycle.

        Args:
            names: Their names. A stateful signal is computed in every cycle after it is read for the first time.

        Raises:
            NotFound: There is no such signal.
        """

        def readings(session: Session) -> SignalReadings:
            snapshot = session.cycle.board.snapshot
            values = {name: _reading(session.runtime.signals, name) for name in names}
            return SignalReadings(time=snapshot.time, cycle=snapshot.cycle, signals=values)

        with addressed():
            return self._station.control.call(readings)

    def set(self, name: str, value: Value) -> None:
        """Sets an input; the value takes effect in the next cycle.

        Raises:
            NotFound: There is no such signal.
            UsageError: It is not an input, or the value does not have its shape.
        """
        with addressed():
            self._station.session.runtime.signals.set(name, value)


def _described(signals: Signals, name: str) -> CellSignal:
    one = signals.describe(name)
    return CellSignal(
        name=name,
        unit=one.unit,
        dimension=dimension_of(one.unit),
        frame=one.frame,
        help=one.help,
        length=one.length,
        source=signals.source(name),
        input=signals.is_input(name),
    )


def _reading(signals: Signals, name: str) -> SignalReading:
    try:
        return SignalReading(value=signals.read(name).value, reason="")
    except SignalLost as error:
        return SignalReading(value=None, reason=error.reason)


def open_device(control: ControlThread, device: str) -> None:
    """Opens a device: connects its driver if necessary, and lets the device accept commands again.

    Args:
        control: Runs the session, which continues while the driver connects.
        device: Id of the device. An open device stays open.

    Raises:
        UnknownName: There is no device with this id.
        Refused: Its driver cannot be connected.
    """
    connection = control.call(lambda session: _connection_of(session, device))
    try:
        if connection is not None:
            connection.connect()
    except SkirosError as error:
        raise Refused("NotConnected", f"{device} cannot be opened: {error}") from error
    control.call(lambda session: session.cycle.board.closed.discard(device))


def close_device(control: ControlThread, device: str) -> None:
    """Closes a device: it accepts no commands; with its last open device, the driver is disconnected.

    A simulated device stays in the simulation, at a standstill.

    Args:
        control: Runs the session.
        device: Id of the device. A closed device stays closed.

    Raises:
        UnknownName: There is no device with this id.
        WrongState: It is in use, or it moves.
    """

    def close(session: Session) -> Connection | None:
        connection, board = _connection_of(session, device), session.cycle.board
        with session.managers.claims.request("closing it", {device}) as claim:
            users = claim.waits_for()
        if users:
            raise WrongState(f"{', '.join(users)} is in use: stop that first")
        if not board.stand({device}):
            raise WrongState(f"{device} moves: wait until it stands")
        board.closed.add(device)
        return connection if connection is not None and connection.devices.keys() <= board.closed else None

    left = control.call(close)
    driver = None if left is None else control.call(lambda _session: left.disconnect())
    if driver is not None:
        driver.close()


def _connection_of(session: Session, device: str) -> Connection | None:
    """Returns the connection of a device; None if it belongs to the simulation or to the driver of the whole cell."""
    if device not in session.cycle.board.devices:
        raise UnknownName("device", device, session.cycle.board.devices)
    cell = session.cell
    for driver in cell.drivers if isinstance(cell, CompositeDriver) else (cell,):
        if isinstance(driver, Connection) and device in driver.devices:
            return driver
    return None
