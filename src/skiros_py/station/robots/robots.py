"""Robots as the API shows them."""

from __future__ import annotations

from skiros_py.api.robots import RobotInfo, RobotReading
from skiros_py.api.view import DeviceState, PoseInfo
from skiros_py.errors import UnknownName
from skiros_py.ports.cell import RobotSpec
from skiros_py.skills.surroundings import owner
from skiros_py.station.robots.devices import device_info, device_state
from skiros_py.station.session import Session


def robot_of(session: Session, id_: str) -> RobotSpec:
    """Returns a robot.

    Raises:
        UnknownName: There is none with this id.
    """
    by_id = {robot.id: robot for robot in session.spec.robots}
    if id_ not in by_id:
        raise UnknownName("robot", id_, by_id)
    return by_id[id_]


def info(session: Session, robot: RobotSpec) -> RobotInfo:
    """Describes a robot; callable in any thread."""
    view = session.world.snapshot()
    return RobotInfo(
        id=robot.id,
        label=view.element(robot.id).label if view.has(robot.id) else "",
        model=robot.model,
        carrier=None if robot.carrier is None else robot.carrier.id,
        place=PoseInfo.view_of(robot.place) if robot.carrier is None else None,
        footprint=robot.outline,
        devices=tuple(device_info(session, device.id) for device in robot.devices),
        agents=tuple(a for a in sorted(session.managers) if view.has(a) and owner(view, a) == robot.id),
    )


def reading(session: Session, robot: RobotSpec) -> RobotReading:
    """Returns the present state of a robot; does not block; callable from any thread."""
    snapshot, view = session.cycle.board.snapshot, session.world.snapshot()
    placement = view.placement(robot.id) if view.has(robot.id) else None
    frames = session.runtime.context.frames.at(snapshot).devices()
    ids = [device.id for device in robot.devices]
    return RobotReading(
        id=robot.id,
        time=snapshot.time,
        cycle=snapshot.cycle,
        halted=session.cycle.halted,
        at=placement.place if placement else "",
        pose=PoseInfo.view_of(robot.pose(snapshot, session.cycle.board.guard)),
        devices={id_: DeviceState(**device_state(session, snapshot, id_)) for id_ in ids},
        frames={id_: PoseInfo.view_of(frames[id_]) for id_ in ids if id_ in frames},
    )
