"""Devices of any kind."""

from __future__ import annotations

from urllib.parse import quote

from skiros_py.api.devices import DeviceInfo, DeviceReading
from skiros_py.client.call import Call


def list_devices() -> Call[list[DeviceInfo]]:
    """Lists the devices with the values that each offers."""
    return Call("GET", "/devices", list[DeviceInfo])


def get_device(device: str) -> Call[DeviceInfo]:
    """Describes a device."""
    return Call("GET", f"/devices/{quote(device, safe='')}", DeviceInfo)


def open_device(device: str) -> Call[DeviceInfo]:
    """Opens a device: its driver is connected, and modules may use it."""
    return Call("POST", f"/devices/{quote(device, safe='')}/open", DeviceInfo)


def close_device(device: str) -> Call[DeviceInfo]:
    """Closes a device: no module may use it, and its driver may be disconnected."""
    return Call("POST", f"/devices/{quote(device, safe='')}/close", DeviceInfo)


def get_device_state(device: str) -> Call[DeviceReading]:
    """Reads a device."""
    return Call("GET", f"/devices/{quote(device, safe='')}/state", DeviceReading)
