"""Opens and closes devices while the station runs: opening a device connects its driver."""

from __future__ import annotations

from skiros_py.errors import Refused, SkirosError, UnknownName, WrongState
from skiros_py.ports.composite import CompositeDriver
from skiros_py.ports.connection import Connection
from skiros_py.station.control import ControlThread
from skiros_py.station.session import Session


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
