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
