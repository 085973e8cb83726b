"""Robots as the API shows them."""

from __future__ import annotations

from skiros_py.api.robots import (
    ArmDescription,
    ArmReading,
    BaseDescription,
    CameraDescription,
    GripperDescription,
    RobotInfo,
    RobotReading,
)
from skiros_py.api.view import BaseInfo, GripperInfo, PoseInfo
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.gripper import GripperSpec, GripperState
from skiros_py.devices.mobile_base import BaseSpec, BaseState
from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.frames import FrameTree
from skiros_py.ports.kinematics import BASE_JOINTS, Kinematics
from skiros_py.ports.values import Snapshot
from skiros_py.skills.surroundings import owner
from skiros_py.station.robots.devices import joint_description
from skiros_py.station.session import Session
from skiros_py.world.vocabulary import HELD_BY

# ---------------------------------------------------------------------- description


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
    model, view = session.runtime.context.frames.kinematics(robot), session.world.snapshot()
    return RobotInfo(
        id=robot.id,
        label=view.element(robot.id).label if view.has(robot.id) else "",
        model=robot.model,
        base=_base(robot, model),
        carrier=None if robot.carrier is None else robot.carrier.id,
        place=_pose(robot.place) if robot.carrier is None else None,
        footprint=robot.outline,
        arms=tuple(_arm(arm, model) for arm in robot.of(ArmSpec)),
        grippers=tuple(
            GripperDescription(id=g.id, arm=g.arm, joints=g.joints, max_gap=g.max_gap, max_force=g.max_force)
            for g in robot.of(GripperSpec)
        ),
        cameras=tuple(
            CameraDescription(id=c.id, frame=c.frame, width=c.width, height=c.height, vertical_fov=c.vertical_fov)
            for c in robot.of(CameraSpec)
        ),
        agents=_agents(session, robot),
    )


def _base(robot: RobotSpec, model: Kinematics | None) -> BaseDescription | None:
    for base in robot.of(BaseSpec):
        return BaseDescription(
            id=base.id,
            joints=tuple(name for name in BASE_JOINTS if model is not None and name in model.joints),
            max_linear=base.max_linear,
            max_angular=base.max_angular,
            footprint=base.footprint,
        )
    return None


def _arm(arm: ArmSpec, model: Kinematics | None) -> ArmDescription:
    return ArmDescription(
        id=arm.id, joints=tuple(joint_description(n, model) for n in arm.joints), home=arm.home, tip=arm.tip
    )


def _agents(session: Session, robot: RobotSpec) -> tuple[str, ...]:
    view = session.world.snapshot()
    return tuple(a for a in sorted(session.managers) if view.has(a) and owner(view, a) == robot.id)


# ---------------------------------------------------------------------- state


def reading(session: Session, robot: RobotSpec) -> RobotReading:
    """Returns the present state of a robot; does not block; callable from any thread."""
    snapshot, view = session.cycle.board.snapshot, session.world.snapshot()
    placement = view.placement(robot.id) if view.has(robot.id) else None
    grippers = {g.id: snapshot.state(g.id, GripperState) for g in robot.of(GripperSpec)}
    return RobotReading(
        id=robot.id,
        time=snapshot.time,
        cycle=snapshot.cycle,
        halted=session.cycle.halted,
        at=placement.place if placement else "",
        base=_base_reading(robot, snapshot),
        pose=_pose(robot.pose(snapshot)),
        arms={arm.id: _arm_reading(arm.id, session.runtime.context.frames.at(snapshot)) for arm in robot.of(ArmSpec)},
        grippers={
            id_: GripperInfo(
                gap=g.gap, force=g.force, still=g.still, holds=next(iter(view.subjects(HELD_BY, id_)), None)
            )
            for id_, g in grippers.items()
        },
    )


def _base_reading(robot: RobotSpec, snapshot: Snapshot) -> BaseInfo | None:
    for base in robot.of(BaseSpec):
        now = snapshot.state(base.id, BaseState)
        return BaseInfo(pose=_pose(robot.pose(snapshot)), linear=now.linear, angular=now.angular, still=now.still)
    return None


def _arm_reading(arm: str, frames: FrameTree) -> ArmReading:
    state, tool = frames.snapshot.state(arm, ArmState), frames.device(arm)
    return ArmReading(
        positions=state.positions,
        velocities=state.velocities,
        still=state.still,
        tool=_pose(tool) if tool is not None else None,
    )


def _pose(pose: Pose) -> PoseInfo:
    return PoseInfo(position=pose.position, orientation=pose.orientation)
