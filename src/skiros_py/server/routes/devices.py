"""Routes: devices of any kind, and signals."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query

from skiros_py.api.devices import CellSignal, DeviceInfo, DeviceReading, SetSignal, SignalReadings
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.services import StationDep

router = APIRouter(tags=["robots"])

Id = Annotated[str, Path(max_length=200)]


@router.get("/devices", summary="List the devices", dependencies=[needs(Role.VIEWER)])
def list_devices(station: StationDep) -> list[DeviceInfo]:
    """All devices of the cell, of robots and by themselves, with the values that each offers."""
    return station.devices.all()


@router.get("/devices/{id}", summary="Describe a device", dependencies=[needs(Role.VIEWER)])
def get_device(id: Id, station: StationDep) -> DeviceInfo:  # noqa: A002 - as the address says it
    """One device."""
    return station.devices.get(id)


@router.get("/devices/{id}/state", summary="Read a device", dependencies=[needs(Role.VIEWER)])
def get_device_state(id: Id, station: StationDep) -> DeviceReading:  # noqa: A002
    """What a device says now, and the values that it offers."""
    return station.devices.reading(id)


@router.post("/devices/{id}/open", summary="Open a device", dependencies=[needs(Role.ENGINEER)])
def open_device(id: Id, station: StationDep) -> DeviceInfo:  # noqa: A002
    """Connects the driver of a device, so that modules may use it again."""
    return station.devices.open(id)


@router.post("/devices/{id}/close", summary="Close a device", dependencies=[needs(Role.ENGINEER)])
def close_device(id: Id, station: StationDep) -> DeviceInfo:  # noqa: A002
    """Keeps modules from using a device; refused (409) while one does, or while it moves.

    With its last open device a driver is disconnected. A simulated device stays where it is.
    """
    return station.devices.close(id)


@router.get("/signals", summary="List the signals", dependencies=[needs(Role.VIEWER)])
def list_signals(station: StationDep) -> list[CellSignal]:
    """All signals of the cell: those of devices, computed ones, and inputs that can be set."""
    return station.signals.all()


@router.get("/signals/values", summary="Read signals", dependencies=[needs(Role.VIEWER)])
def read_signals(
    station: StationDep,
    name: Annotated[list[str], Query(min_length=1, max_length=200, description="Names of the signals.")],
) -> SignalReadings:
    """The values of some signals in one control cycle; where one has no value, why."""
    return station.signals.read(name)


@router.put("/signals/{name}/value", status_code=204, summary="Set a signal", dependencies=[needs(Role.OPERATOR)])
def set_signal(name: Id, request: SetSignal, station: StationDep) -> None:
    """Sets an input of the cell; the value counts from the next control cycle on."""
    station.signals.set(name, request.value)
