"""Routes: devices of any kind."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path

from skiros_py.api.devices import DeviceInfo, DeviceReading
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
