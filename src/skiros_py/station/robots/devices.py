"""Devices as the API shows them: described by their kinds, without knowledge of their types."""

from __future__ import annotations

from skiros_py.api.devices import DeviceInfo, DeviceReading, SignalInfo
from skiros_py.errors import UnknownName
from skiros_py.ports.device import to_plain
from skiros_py.station.session import Session


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
    described = to_plain(device)
    described.pop("id")
    return DeviceInfo(
        id=id_,
        kind=device.kind,
        robot=group.id if group in session.spec.robots else None,
        description=described,
        signals=tuple(SignalInfo(name=s.name, unit=s.unit, frame=s.frame, help=s.help) for s in device.signals),
        open=id_ not in session.cycle.board.closed,
        commanded=device.target_type is not None,
        jog=device.jog,
        teach=device.teach,
    )


def device_reading(session: Session, id_: str) -> DeviceReading:
    """Returns the present readings of a device; does not block; callable from any thread.

    Raises:
        UnknownName: There is none with this id.
    """
    board = session.cycle.board
    if id_ not in board.devices:
        raise UnknownName("device", id_, board.devices)
    device, snapshot = board.devices[id_], board.snapshot
    state = snapshot.devices.get(id_)
    return DeviceReading(
        id=id_,
        time=snapshot.time,
        cycle=snapshot.cycle,
        still=state is None or device.still(state),
        state=None if state is None else device.encode(state),
        signals={} if state is None else {signal.name: signal.read(state) for signal in device.signals},
    )
