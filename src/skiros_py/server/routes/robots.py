"""Routes: robots with their models; devices, with jogging and teaching; signals."""

from __future__ import annotations

import math
from typing import Annotated, Any

from fastapi import Path, Query, Response

from skiros_py.api import robots as api
from skiros_py.api.modules import ModuleRunInfo
from skiros_py.errors import Busy
from skiros_py.server.access.roles import Engineer, Operator, Viewer
from skiros_py.server.problems import topic_router

router = topic_router("robots")

Id = Annotated[str, Path(max_length=200)]
DeviceId = Annotated[str, Path(alias="id", max_length=200)]
RobotId = Annotated[str, Path(alias="id", max_length=200)]


@router.get("/robots")
def list_robots(act: Viewer) -> api.Robots:
    """List the robots.

    The devices of each robot, of any kind, with their joints and frames.
    """
    return api.Robots(items=act.station.robots.all())


@router.get("/robots/{id}")
def get_robot(act: Viewer, robot: RobotId) -> api.RobotInfo:
    """Describe a robot.

    One robot with its devices.
    """
    return act.station.robots.get(robot)


@router.get("/robots/{id}/state")
def get_robot_state(act: Viewer, robot: RobotId) -> api.RobotReading:
    """See where a robot is.

    The states of its devices in one cycle, and their frames in the map, as localised.
    """
    return act.station.robots.reading(robot)


_MeshName = Annotated[str, Path(max_length=200, description="As the model names it.")]
_FOREVER = {"Cache-Control": "private, max-age=31536000, immutable"}
"""What is named by its content never changes."""
_URDF: dict[int | str, dict[str, Any]] = {
    200: {"description": "The model.", "content": {"application/xml": {}}},
    202: {"description": "It is being made: ask again after `Retry-After` seconds."},
}
_STL: dict[int | str, dict[str, Any]] = {200: {"description": "The mesh.", "content": {"model/stl": {}}}}


@router.get("/robots/{id}/model", response_class=Response, responses=_URDF)
def get_robot_model(act: Viewer, robot: RobotId) -> Response:
    """Read a robot's model.

    Returns links, joints and visible shapes with their colours as URDF; of a robot, or of a device without a robot.

    Mesh files are relative to the address of the model, binary STL, and have few triangles. The live state has the
    positions of the joints. The first request may take some seconds: 202 without content says when to ask again.
    """
    try:
        return Response(act.station.robots.model(robot).urdf, media_type="application/xml")
    except Busy as busy:
        return Response(status_code=202, headers={"Retry-After": str(math.ceil(busy.retry_after))})


@router.get("/robots/{id}/model/meshes/{name}", response_class=Response, responses=_STL)
def get_robot_mesh(act: Viewer, robot: RobotId, name: _MeshName) -> Response:
    """Read a mesh of a robot's model.

    Returns one of the mesh files of the model, as binary STL [m].
    """
    return Response(act.station.robots.mesh(robot, name), media_type="model/stl", headers=_FOREVER)


@router.get("/devices")
def list_devices(act: Viewer) -> api.Devices:
    """List the devices.

    All devices of the cell, of robots and by themselves, with the values that each offers.
    """
    return api.Devices(items=act.station.devices.all())


@router.get("/devices/{id}")
def get_device(act: Viewer, device: DeviceId) -> api.DeviceInfo:
    """Describe a device.

    One device.
    """
    return act.station.devices.get(device)


@router.get("/devices/{id}/state")
def get_device_state(act: Viewer, device: DeviceId) -> api.DeviceReading:
    """Read a device.

    What a device says now, and the values that it offers.
    """
    return act.station.devices.reading(device)


@router.get("/devices/{id}/motion")
def get_device_motion(act: Viewer, device: DeviceId) -> api.DeviceMotion:
    """See where a device is about to go.

    The planned motion of a base, an arm or another device, until it stands at the end, or the module that planned it
    has ended.

    The `motions` of the station's state change with it.
    """
    return act.station.devices.motion(device)


@router.get("/devices/{id}/observation")
def get_device_observation(act: Viewer, device: DeviceId) -> api.Observation:
    """Get the last observation by a camera.

    The last image that a module used for perception, as points in the map, and the detections in it.

    It is new when its number in `observations` of the station's state has changed.
    """
    return act.station.devices.observation(device)


@router.post("/devices/{id}/open")
def open_device(act: Engineer, device: DeviceId) -> api.DeviceInfo:
    """Open a device.

    Connects the driver of a device, so that modules may use it again.
    """
    return act.station.devices.open(device)


@router.post("/devices/{id}/close")
def close_device(act: Engineer, device: DeviceId) -> api.DeviceInfo:
    """Close a device.

    Keeps modules from using a device; refused (409) while one does, or while it moves.

    With its last open device a driver is disconnected. A simulated device stays where it is.
    """
    return act.station.devices.close(device)


@router.post("/devices/{id}/jog", status_code=202)
def jog_device(act: Engineer, device: DeviceId, request: api.ManualRun) -> ModuleRunInfo:
    """Jog a device.

    Moves a device by a small step, or home, with a module that its kind names; follow the run that is answered.

    Refused (409) while its robot does something else. Where the way is not free, the run fails and says why.
    """
    run = act.station.devices.jog(device, request.arguments, module=request.module, author=act.author)
    act.locate("module-runs", run.id)
    return run


@router.post("/devices/{id}/teach", status_code=202)
def teach_device(act: Engineer, device: DeviceId, request: api.ManualRun) -> ModuleRunInfo:
    """Teach with a device.

    Learns from the current state of a device: a grasp, a driving pose, whatever its kind names modules for.
    """
    run = act.station.devices.teach(device, request.arguments, module=request.module, author=act.author)
    act.locate("module-runs", run.id)
    return run


@router.get("/signals")
def list_signals(act: Viewer) -> api.CellSignals:
    """List the signals.

    All signals of the cell: those of devices, computed ones, and inputs that can be set.
    """
    return api.CellSignals(items=act.station.signals.all())


@router.get("/signals/values")
def read_signals(
    act: Viewer,
    name: Annotated[list[str], Query(min_length=1, max_length=200, description="Names of the signals.")],
) -> api.SignalReadings:
    """Read signals.

    The values of some signals in one control cycle; where one has no value, why.
    """
    return act.station.signals.read(name)


@router.put("/signals/{name}/value", status_code=204)
def set_signal(act: Operator, name: Id, request: api.SetSignal) -> None:
    """Set a signal.

    Sets an input of the cell; the value counts from the next control cycle on.
    """
    act.station.signals.set(name, request.value)
