"""Robots, devices and signals: state, jogging, teaching, opening, closing and stopping."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skiros_py.api.alarms import StopInfo
from skiros_py.api.modules import ModuleRunInfo
from skiros_py.api.robots import (
    CellSignal,
    DeviceInfo,
    DeviceMotion,
    DeviceReading,
    Look,
    RobotInfo,
    RobotReading,
    SignalReadings,
    SignalValue,
)
from skiros_py.client.request import Call, nothing, path_of


def list_robots() -> Call[list[RobotInfo]]:
    """Lists the robots with their components."""
    return Call("GET", "/robots", list[RobotInfo])


def get_robot(robot: str) -> Call[RobotInfo]:
    """Returns a robot with its components."""
    return Call("GET", path_of("robots", robot), RobotInfo)


def get_robot_state(robot: str) -> Call[RobotReading]:
    """Returns the current state of a robot."""
    return Call("GET", path_of("robots", robot, "state"), RobotReading)


def get_robot_model(robot: str) -> Call[str]:
    """Returns the model of a robot as URDF."""
    return Call("GET", path_of("robots", robot, "model"), lambda r: r.text)


def get_robot_mesh(robot: str, mesh: str) -> Call[bytes]:
    """Returns a mesh of the model as binary STL.

    Args:
        robot: The robot.
        mesh: The last part of the file name in the model.
    """
    return Call("GET", path_of("robots", robot, "model", "meshes", mesh), lambda r: r.content)


def list_devices() -> Call[list[DeviceInfo]]:
    """Lists the devices with their values."""
    return Call("GET", "/devices", list[DeviceInfo])


def get_device(device: str) -> Call[DeviceInfo]:
    """Returns a device."""
    return Call("GET", path_of("devices", device), DeviceInfo)


def get_device_motion(device: str) -> Call[DeviceMotion]:
    """Returns the planned motion of a device."""
    return Call("GET", path_of("devices", device, "motion"), DeviceMotion)


def get_device_look(device: str) -> Call[Look]:
    """Returns the last image of a camera."""
    return Call("GET", path_of("devices", device, "look"), Look)


def open_device(device: str) -> Call[DeviceInfo]:
    """Opens a device: its driver is connected, and modules may use it."""
    return Call("POST", path_of("devices", device, "open"), DeviceInfo)


def close_device(device: str) -> Call[DeviceInfo]:
    """Closes a device: no module may use it, and its driver may be disconnected."""
    return Call("POST", path_of("devices", device, "close"), DeviceInfo)


def jog_device(
    device: str, arguments: Mapping[str, Any] | None = None, *, module: str | None = None
) -> Call[ModuleRunInfo]:
    """Moves a device by a small step, or home; follow the run with :func:`~skiros_py.client.calls.get_module_run`.

    Args:
        device: The device.
        arguments: Parameters of the module, without the device.
        module: One of those that the kind of the device names for this; None for the first.
    """
    return _by_hand(device, "jog", arguments, module)


def teach_device(
    device: str, arguments: Mapping[str, Any] | None = None, *, module: str | None = None
) -> Call[ModuleRunInfo]:
    """Learns something from the present state of a device; see :func:`jog_device`."""
    return _by_hand(device, "teach", arguments, module)


def _by_hand(device: str, verb: str, arguments: Mapping[str, Any] | None, module: str | None) -> Call[ModuleRunInfo]:
    body = {"module": module, "arguments": dict(arguments or {})}
    return Call("POST", path_of("devices", device, verb), ModuleRunInfo, json=body, repeatable=False)


def get_device_state(device: str) -> Call[DeviceReading]:
    """Reads a device."""
    return Call("GET", path_of("devices", device, "state"), DeviceReading)


def list_signals() -> Call[list[CellSignal]]:
    """Lists the signals: of devices, computed ones, and inputs."""
    return Call("GET", "/signals", list[CellSignal])


def read_signals(*names: str) -> Call[SignalReadings]:
    """Reads signals, all in the same control cycle."""
    return Call("GET", "/signals/values", SignalReadings, query={"name": list(names)})


def set_signal(name: str, value: SignalValue) -> Call[None]:
    """Sets an input; it takes effect in the next control cycle."""
    return Call("PUT", path_of("signals", name, "value"), nothing, json={"value": value})


def stop(reason: str = "") -> Call[StopInfo]:
    """Halts all robots in the next control cycle.

    Args:
        reason: Why, for the user.
    """
    return Call("POST", "/stop", StopInfo, json={"reason": reason})


def get_stop() -> Call[StopInfo]:
    """Returns whether the system is halted."""
    return Call("GET", "/stop", StopInfo)


def reset() -> Call[StopInfo]:
    """Resets a halt after its cause has been checked, so that things can start again."""
    return Call("POST", "/reset", StopInfo)
